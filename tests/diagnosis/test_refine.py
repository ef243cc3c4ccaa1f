"""The ladder: an effect at a time, refitted, checked on a run that was never fitted."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import pytest
import torch

from zoo.diagnosis.diagnose import diagnose
from zoo.diagnosis.refine import check_added, check_rms, refine
from zoo.diagnosis.search import NEAR, Search
from zoo.errors import InputError
from zoo.models.prediction import predict_blocks

LADDER_KEYS = {"added", "effects", "rms", "rms_check"}


@pytest.fixture(scope="module")
def climbed():
    """Ladders by (hidden, add), each climbed once."""
    return {}


@pytest.fixture
def ladder(climbed, runs, check, catalogue, base, diagnosis):
    """From the diagnosis that other tests look at, as the command takes its own."""

    def climb(hidden: str, add: str | tuple[str, ...] = "auto"):
        if (hidden, add) not in climbed:
            climbed[hidden, add] = refine(
                runs(hidden), check(hidden), base, list(add) if isinstance(add, tuple) else add, catalogue, diagnosis=diagnosis(hidden)
            )
        return climbed[hidden, add]

    return climb


def test_auto_climbs_to_what_is_missing(ladder, base, white) -> None:
    found = ladder("polarization")
    record = json.loads(json.dumps(found.record, allow_nan=False))
    assert set(record) >= {"ladder", "noise_floor", "noise_floor_check", "verdict"}
    assert [step["added"] for step in record["ladder"]] == [None, "polarization"]
    assert [step["effects"] for step in record["ladder"]] == [base, [*base, "polarization"]]
    assert all(set(step) == LADDER_KEYS for step in record["ladder"])
    assert record["verdict"] == "complete"
    first, last = record["ladder"]
    assert last["rms_check"] < 0.5 * first["rms_check"]
    assert last["rms_check"] < 1.15 * record["noise_floor_check"]
    assert record["noise_floor_check"] == pytest.approx(white, rel=0.2)


def test_an_effect_named_by_hand_is_searched_for_and_refitted_as_by_auto(runs, check, base, catalogue, white) -> None:
    """On the runs as the diagnosis left them, which here walk more than most, with a block that was knocked."""
    chance, shaken = torch.Generator().manual_seed(1), []
    for run in runs("polarization"):
        walk = 0.06 * white * torch.randn(len(run.error), generator=chance, dtype=torch.float64).cumsum(0)
        shaken.append(replace(run, error=run.error + walk + 12 * white * (run.block == 100)))
    few = {name: catalogue[name] for name in (*base, "polarization", "hysteresis", "aging", "rate_temperature_coupling")}
    by_hand, auto = (refine(shaken, check("polarization"), base, add, few) for add in (["polarization"], "auto"))
    left = auto.diagnosis.bench
    assert left.noise.walk > 0.2 * left.noise.white, "not the noise that is assumed at first"
    assert left.blocks < sum(run.blocks for run in shaken)
    for mine, found in zip(by_hand.record["ladder"], auto.record["ladder"], strict=True):
        for key in ("rms", "rms_check"):
            assert mine[key] == pytest.approx(found[key], rel=1e-4)
    assert by_hand.record["ladder"][0]["rms"] == by_hand.diagnosis.record["rms"]


def test_a_model_as_it_stands_knows_what_only_wanders(runs, check, base, catalogue, white) -> None:
    """Under white noise alone it would follow the walk of these runs, and be further from others."""
    chance, walked = torch.Generator().manual_seed(3), []
    for run in runs(""):
        walked.append(replace(run, error=run.error + 0.045 * white * torch.randn(len(run.error), generator=chance, dtype=torch.float64).cumsum(0)))
    found = refine(walked, check(""), base, "auto", catalogue)
    search, record = found.diagnosis.search, found.diagnosis.record
    assert found.diagnosis.bench.noise.walk > 0.2 * white
    assert search.first.rms < search.as_it_stands.rms <= NEAR * search.first.rms
    assert found.record["ladder"][0]["rms_check"] < 0.9 * check_rms(search.first.model, check(""))
    assert record["rms"] == found.record["ladder"][0]["rms"] == search.as_it_stands.rms
    assert record["rms"] <= record["rms_final"] or record["missing"]
    assert record["rms"] < record["rms_uncompensated"]


@pytest.mark.parametrize(("first", "base", "shown"), [(None, 3.0, 3.0), (1.0, 1.1, 1.1), (1.0, 1.3, 1.0)])
def test_a_model_as_it_stands_is_near_the_runs(first, base, shown) -> None:
    """Beside a walk so large that it hides something slow, the model that leaves it to the walk is not the one to show."""
    asked, assumed = (SimpleNamespace(rms=value) for value in (base, first))
    assert Search(asked, asked, first=None if first is None else assumed).as_it_stands.rms == shown  # type: ignore[arg-type]


def test_what_was_diagnosed_already_is_not_diagnosed_again(runs, catalogue, base, ladder, monkeypatch) -> None:
    before = ladder("polarization").diagnosis
    monkeypatch.setattr("zoo.diagnosis.refine.diagnose", None)
    found = refine(runs("polarization"), [], base, "aging", catalogue, diagnosis=before)
    assert found.diagnosis is before
    assert found.record["ladder"][0]["rms"] == before.record["rms"]
    assert [step["added"] for step in found.record["ladder"]] == [None, "aging"]


def test_where_nothing_is_missing_the_ladder_is_one_rung(ladder) -> None:
    record = ladder("").record
    assert [step["added"] for step in record["ladder"]] == [None]
    assert record["verdict"] == "complete"


@pytest.mark.parametrize("add", [("polarization", "aging", "warm_up"), ("hysteresis", "rate_temperature_coupling", "polarization"), ("sensor_lag",)])
def test_the_error_on_fitted_runs_never_rises(ladder, add) -> None:
    steps = ladder("polarization", add).record["ladder"]
    assert [step["added"] for step in steps] == [None, *add]
    for before, after in pairwise(steps):
        assert after["rms"] <= before["rms"] * 1.002, after["added"]


def test_the_models_predictions_are_those_that_were_scored(ladder, check) -> None:
    found = ladder("polarization")
    for step, solved in zip(found.record["ladder"], found.solutions, strict=True):
        assert [name for name, _ in solved.model.named_effects()] == step["effects"]
        assert check_rms(solved.model, check("polarization")) == step["rms_check"]
        predicted = torch.cat([predict_blocks(solved.model, run) for run in solved.design.runs])
        left = solved.design.error - predicted
        assert float(left.square().mean().sqrt()) == pytest.approx(step["rms"], rel=1e-9)
    assert found.model is found.solutions[-1].model


def test_how_far_check_runs_go_beyond_the_fitted_ones_is_told(runs, check, base, catalogue, ladder) -> None:
    assert ladder("").record["beyond"] == {}
    hot = [replace(run, table=run.table + torch.tensor([40.0 if name.startswith("temp") else 0.0 for name in run.columns])) for run in check("")]
    record = refine(runs(""), hot, base, [], catalogue, diagnosis=ladder("").diagnosis).record
    assert set(record["beyond"]) == set(runs("")[0].thermometers)
    for one in record["beyond"].values():
        assert one["reached"][1] > one["fitted"][1] + 20.0
        assert 0.1 < one["share"] < 0.9


def test_without_a_check_run_there_is_nothing_to_check(runs, catalogue, base) -> None:
    record = refine(runs(), [], base, "warm_up", catalogue).record
    assert [step["rms_check"] for step in record["ladder"]] == [None, None]
    assert record["noise_floor_check"] is None
    json.dumps(record, allow_nan=False)


@pytest.mark.parametrize(
    ("add", "words"),
    [
        ("mohr", "'mohr' is in the model already"),
        (["aging", "static_bias"], "'static_bias' is in the model already"),
        ("polarisation", "unknown effect 'polarisation': did you mean polarization"),
        (["aging", "nothing"], "unknown effect 'nothing'"),
    ],
)
def test_what_cannot_be_added_is_refused(runs, catalogue, base, add, words) -> None:
    with pytest.raises(InputError) as caught:
        refine(runs(), [], base, add, catalogue)
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) <= 2


def test_nothing_to_compare_is_said_so(runs, catalogue, base) -> None:
    for some, effects, words in (([], base, "no run to compare with"), (runs(), [], "no effect to start from")):
        with pytest.raises(InputError, match=words):
            diagnose(some, effects, catalogue)
        with pytest.raises(InputError, match=words):
            refine(some, [], effects, "auto", catalogue)


def test_check_runs_averaged_otherwise_are_refused(runs, check, catalogue, base) -> None:
    other = [replace(run, average_s=2 * run.average_s) for run in check()]
    with pytest.raises(InputError, match=r"200 s.*100 s"):
        refine(runs(), other, base, "aging", catalogue)


def test_an_effect_named_twice_is_refused(runs, catalogue, base) -> None:
    with pytest.raises(InputError, match="aging"):
        refine(runs(), [], base, ["aging", "aging"], catalogue)


def test_recordings_sampled_alike_check_each_other_although_rounding_differs(runs, base, catalogue) -> None:
    """The median step of 0, 0.1, 0.2, … depends on how many rows there are, by 1e-14."""
    fitted = runs("polarization")
    check_added(fitted, [replace(fitted[0], average_s=fitted[0].average_s * (1 + 1e-13))], base, ["aging"], catalogue)
    with pytest.raises(InputError, match="read all with one average_s"):
        check_added(fitted, [replace(fitted[0], name="check", average_s=2 * fitted[0].average_s)], base, ["aging"], catalogue)
