"""A named effect that a free form outdoes is not what it is; one that is there stays named and is outdone by none."""

from __future__ import annotations

import pytest
import torch

from zoo.diagnosis import outdone
from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.diagnosis.structure import examine
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import campaign, tour

STAIRS = campaign(
    [tour(-30, [(level, rate, 3600) for level in (-10, 10, 30, 50)], 3600) for rate in (1.0, 2.0)],
    tour(25, [(-25, 0.8, 2400), (55, 1.2, 2400)], 1800),
)
"""Each temperature is passed at one rate only, and always upwards: what goes with both looks like much else."""


def beside(runs, name, base, catalogue):
    """The bench, the model as it stands and with one effect named."""
    bench = open_bench(runs, base, catalogue)
    before = bench.begin(tuple(base))
    return bench, before, bench.add(before, name, (name,))


def test_a_form_fitted_with_the_coil_outdoes_what_its_function_on_a_grid_does_not(
    simulation, with_error_of, white, catalogue, base, monkeypatch
) -> None:
    runs = with_error_of(simulation(program=STAIRS).runs, lambda coil, rate: coil * rate.square(), 4 * white)
    bench, before, named = beside(runs, "glass_transition", base, catalogue)
    assert bench.evidence(before, named) > 100.0
    assert outdone.outdone(bench, named, before) > 2.0
    record = diagnose(runs, base, catalogue).record
    assert record["verdict"] == "unknown"
    assert "the coil's temperature and its rate together" in [one["depends_on"] for one in record["unexplained"]]
    monkeypatch.setattr(outdone, "CONTESTED", float("inf"))
    before.formed.clear()
    assert outdone.outdone(bench, named, before) < 0.2


def test_a_bend_of_the_bias_is_no_fringe(simulation, with_error_of, white, catalogue, base) -> None:
    """With a period as long as the runs are warm, the lines of a polariser follow it; no polynomial does."""
    runs = with_error_of(simulation().runs, lambda coil, rate: (coil - 30.0).clamp_min(0.0), 30 * white)
    bench, before, named = beside(runs, "polarization", base, catalogue)
    assert bench.evidence(before, named) > 100.0
    assert outdone.outdone(bench, named, before) > 2.0
    assert examine(bench, named, before).outdone
    found = diagnose(runs, base, catalogue).record
    assert (found["verdict"], found["outdone"]) == ("unknown", bool(found["missing"]))
    assert found["unexplained_words"].startswith("It bends at ")
    place = found["unexplained_form"]["parameters"]["place"]
    assert abs(place["value"] - 30.0) < 3.0 * place["stderr"] < 3.0


@pytest.mark.parametrize(("width", "seed"), [(0.3, 1), (2.0, 2)])
def test_a_step_at_a_temperature_is_no_fringe(simulation, with_error_of, white, catalogue, base, width, seed) -> None:
    """A polariser's lines at free ratios follow most of it, and a polynomial of the temperature less; hysteresis follows it where runs go one way."""
    runs = with_error_of(simulation(seed=seed).runs, lambda coil, rate: torch.sigmoid((coil - 22.0) / width), 2 * white)
    found = diagnose(runs, base, catalogue).record
    assert found["verdict"] == "unknown"
    assert found["unexplained_words"].startswith("It steps up by ")
    assert "Not so in" not in found["unexplained_words"]
    place = found["unexplained_form"]["parameters"]["place"]
    assert abs(place["value"] - 22.0) < 3.0 * place["stderr"] < 3.0
    curve, step = found["unexplained"][0]["curves"][0], found["unexplained_form"]["parameters"]["step"]["value"]
    drawn = [y for x, y in zip(curve["x"], curve["y"], strict=True) if abs(x - 22.0) < 5.0 + 2.0 * width]
    assert max(drawn) - min(drawn) > 0.5 * step, "as a step, of which a polynomial makes a fifth"


@pytest.mark.parametrize("hidden", ["glass_transition", "viscoelastic", "rate_temperature_coupling"])
def test_what_is_there_is_named_on_the_same_stairs(simulation, catalogue, base, hidden) -> None:
    found = diagnose([as_run(one) for one in simulation(hidden, program=STAIRS).runs], base, catalogue)
    assert (found.verdict, found.search.missing) == ("missing", [hidden])


@pytest.mark.parametrize("hidden", ["glass_transition", "polarization"])
def test_what_is_there_is_not_outdone_on_the_same_stairs(simulation, catalogue, base, hidden) -> None:
    bench, before, named = beside([as_run(one) for one in simulation(hidden, program=STAIRS).runs], hidden, base, catalogue)
    assert bench.evidence(before, named) > 20.0
    assert outdone.outdone(bench, named, before) < 0.5
    assert not examine(bench, named, before).outdone
