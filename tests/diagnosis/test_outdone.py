"""A named effect that a free form outdoes is not what it is; one that is there stays named."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from zoo.diagnosis import outdone
from zoo.diagnosis.diagnose import diagnose
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import campaign, tour

STAIRS = campaign(
    [tour(-30, [(level, rate, 3600) for level in (-10, 10, 30, 50)], 3600) for rate in (1.0, 2.0)],
    tour(25, [(-25, 0.8, 2400), (55, 1.2, 2400)], 1800),
)
"""Each temperature is passed at one rate only, and always upwards: what goes with both looks like much else."""


def squared_by_temperature(simulation, white):
    """Runs with T·(dT/dt)² of four times the white noise of a block."""
    recorded, added = simulation(program=STAIRS).runs, []
    for one in recorded:
        time, coil = one.truth["time_s"], one.truth["temperature_coil_c"]
        added.append(coil * torch.gradient(coil, spacing=(time / 60,))[0].square())
    scale = 4 * white / torch.cat(added).std()
    return [replace(as_run(one), error=as_run(one).error + scale * more) for one, more in zip(recorded, added, strict=True)]


def test_a_form_that_is_fitted_with_the_coil_outdoes_what_its_function_on_a_grid_does_not(simulation, white, catalogue, base, monkeypatch) -> None:
    found = diagnose(squared_by_temperature(simulation, white), base, catalogue)
    named = found.search.steps[0].trials[0].solved
    assert named is not None
    assert found.verdict == "unknown"
    assert "the coil's temperature and its rate together" in [one["depends_on"] for one in found.record["unexplained"]]
    assert outdone.outdone(found.bench, named, found.search.base) > 2.0
    monkeypatch.setattr(outdone, "CONTESTED", float("inf"))
    assert outdone.outdone(found.bench, named, found.search.base) < 0.2


def test_a_bend_of_the_bias_is_no_fringe(simulation, white, catalogue, base) -> None:
    """With a period as long as the runs are warm, the lines of a polariser follow it to the noise; no polynomial does."""
    recorded = simulation().runs
    added = [(one.truth["temperature_coil_c"] - 30.0).clamp_min(0.0) for one in recorded]
    scale = 30 * white / torch.cat(added).std()
    runs = [replace(as_run(one), error=as_run(one).error + scale * more) for one, more in zip(recorded, added, strict=True)]
    found = diagnose(runs, base, catalogue)
    assert found.verdict == "unknown"
    assert found.record["unexplained_words"].startswith("It bends at ")
    place = found.record["unexplained_form"]["parameters"]["place"]
    assert abs(place["value"] - 30.0) < 3.0 * place["stderr"] < 3.0


@pytest.mark.parametrize("hidden", ["glass_transition", "viscoelastic", "rate_temperature_coupling"])
def test_what_is_there_is_named_on_the_same_stairs(simulation, catalogue, base, hidden) -> None:
    found = diagnose([as_run(one) for one in simulation(hidden, program=STAIRS).runs], base, catalogue)
    assert (found.verdict, found.search.missing) == ("missing", [hidden])
