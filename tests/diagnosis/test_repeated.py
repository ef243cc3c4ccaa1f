"""What happens several times is one effect, with as many moments: found, named once, refitted, and known to the model that is kept."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import pytest

from zoo.diagnosis.diagnose import diagnose
from zoo.diagnosis.refine import refine
from zoo.measurements.run import Run

JUMPS = (((2.0, 4.0), (5.0, -3.0)), ((3.5, 7.0),))
"""Hour and height over the white noise of each, run by run."""


@pytest.fixture
def jumping(runs, white) -> Callable[..., list[Run]]:
    """Runs of a gyro whose bias jumps at its own moments in each."""

    def of(jumps=JUMPS, hidden: str = "") -> list[Run]:
        more = [sum(height * white * (run.time > 3600 * hour) for hour, height in own) for run, own in zip(runs(hidden), jumps, strict=True)]
        return [replace(run, error=run.error + one) for run, one in zip(runs(hidden), more, strict=True)]

    return of


@pytest.fixture(scope="module")
def made():
    """Diagnoses, each made once."""
    return {}


@pytest.fixture
def found(made, jumping, base, catalogue):
    if not made:
        made["jumps"] = diagnose(jumping(), base, catalogue)
    return made["jumps"]


def test_jumps_at_moments_of_their_own_are_one_effect_several_times(found, white) -> None:
    record = json.loads(json.dumps(found.record, allow_nan=False))
    assert (record["verdict"], record["missing"]) == ("missing", ["bias_step"])
    planted = [(number, *jump) for number, own in enumerate(JUMPS, 1) for jump in own]
    times = record["times"]["bias_step"]
    assert len(times) == len(planted), "in the order of the runs, and of moments in a run"
    for name, (number, hour, height) in zip(times, planted, strict=True):
        fitted = record["parameters"][name]
        assert fitted["run"]["value"] == number
        assert fitted["onset"]["value"] == pytest.approx(hour, abs=100 / 3600), "within a block"
        assert abs(fitted["step"]["value"] - height * white) < 4 * fitted["step"]["stderr"]
        assert fitted["step"]["stderr"] < 0.5 * white
    assert record["rms_final"] == pytest.approx(record["noise_floor"], rel=0.1)
    assert record["strangers"] == [], "though the others predict nothing of a run but what is left of it"


def test_how_often_it_happens_makes_no_other_hypothesis(found) -> None:
    record = found.record
    sets = [(tuple(one["effects"]), one["hypothesis"]) for one in record["posterior"]]
    assert len({*sets}) == len(sets)
    assert not any(name.startswith("bias_step_") for names, _ in sets for name in names)
    assert record["posterior"][0]["effects"] == ["bias_step"]
    named = [entry["effect"] for entry in record["candidates"]]
    assert named.count("bias_step") == 1
    assert not any(name.startswith("bias_step_") for name in named)
    assert record["candidates"][0]["probability"] > 0.9


@pytest.mark.parametrize("add", ["auto", ["bias_step"]])
def test_all_of_them_are_one_rung_of_the_ladder(found, jumping, check, base, catalogue, add) -> None:
    refined = refine(jumping(), check(), base, add, catalogue, diagnosis=found)
    first, last = refined.record["ladder"]
    assert (first["added"], last["added"]) == (None, "bias_step")
    assert {*last["effects"]} == {*base, *found.record["times"]["bias_step"]}
    assert refined.record["times"] == found.record["times"]
    assert refined.record["verdict"] == "complete"
    assert last["rms"] < 1.1 * refined.record["noise_floor"] < 0.6 * first["rms"]


def test_a_model_that_has_them_lacks_nothing_and_is_fitted_from_where_they_are(found, jumping, catalogue) -> None:
    """Looked for one after the other in another order, they are elsewhere."""
    kept = dict(found.search.final.model.named_effects())
    names = [*[name for name in kept if name not in found.search.base.names][::-1], *found.search.base.names]
    again = diagnose(jumping(), names, {**catalogue, **kept}).record
    assert (again["verdict"], again["missing"]) == ("complete", [])
    assert again["rms"] == pytest.approx(found.record["rms_final"], rel=1e-3)


def test_a_model_with_one_of_them_lacks_it_again(jumping, base, catalogue) -> None:
    record = diagnose(jumping(), [*base, "bias_step"], catalogue).record
    assert (record["verdict"], record["missing"]) == ("missing", ["bias_step"])
    assert len(record["times"]["bias_step"]) == 3


def test_what_happens_once_happens_once(diagnosis) -> None:
    record = diagnosis("bias_step").record
    assert record["missing"] == ["bias_step"]
    assert record["times"] == {}


def test_beside_jumps_another_effect_is_named(jumping, base, catalogue) -> None:
    record = diagnose(jumping(hidden="polarization"), base, catalogue).record
    assert record["verdict"] == "missing"
    assert sorted(record["missing"]) == ["bias_step", "polarization"]
    assert len(record["times"]["bias_step"]) == 3


def test_a_model_that_has_it_under_a_further_name_alone_is_examined(runs, base, catalogue) -> None:
    """Candidates that the user chose, without what the model has: nothing to add it from."""
    few = {name: catalogue[name] for name in (*base, "aging")}
    record = diagnose(runs("bias_step"), [*base, "bias_step_2"], {**few, "bias_step_2": catalogue["bias_step"]}).record
    assert (record["verdict"], record["missing"]) == ("complete", [])
    assert record["times"] == {"bias_step": ["bias_step_2"]}
    assert {*record["detection_limits"]} == {"aging"}
