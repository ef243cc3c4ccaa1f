"""Runs of another gyro, in another unit, without their true input: told; a gyro's own runs: not."""

from dataclasses import replace

import pytest
import torch

from zoo.catalog import build
from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.diagnosis.refine import refine
from zoo.diagnosis.strangers import strangers
from zoo.simulator.gyros.presets import MEDIUM
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import campaign, tour
from zoo.simulator.simulate import simulate


def renamed(runs, name, scale=1.0, shift=0.0):
    return [replace(run, name=name, error=scale * run.error + shift) for run in runs]


def named(given, base, catalogue) -> list[str]:
    """The strangers to a model as it stands."""
    bench = open_bench(given, base, catalogue)
    return [one["run"] for one in strangers(bench, [bench.begin(tuple(base))])]


@pytest.mark.parametrize("wrong", [{"scale": 1 / 3600}, {"shift": 11.2}])
def test_a_run_in_another_unit_or_without_its_true_input_is_a_stranger(runs, check, base, catalogue, wrong) -> None:
    own, odd = runs("aging"), renamed(check("aging"), "odd", **wrong)
    assert named([*own, *odd], base, catalogue) == ["odd"]
    assert {*named([own[0], *odd], base, catalogue)} == {own[0].name, "odd"}, "of two nobody knows which"
    assert named(own[:1], base, catalogue) == []


def test_runs_at_other_temperatures_say_nothing_of_each_other(base, catalogue) -> None:
    """Of one gyro, each in a range of its own: what the others say there they only extrapolate."""
    narrow = [tour(low, [(high, 1.0, 3600), (low, 1.0, 3600)], 3600) for low, high in ((-40, -20), (10, 25), (45, 65))]
    present = {name: catalogue[name] for name in base}
    apart = simulate(MEDIUM, campaign(narrow, narrow[1]), present, build("noise", "gyro"), catalogue=catalogue, runs=3, seed=1, sample_s=20.0)
    assert named([as_run(run) for run in apart.runs], base, catalogue) == []


def test_a_run_that_others_predict_beyond_what_they_know_is_no_stranger(runs, check, base, catalogue) -> None:
    """In a field many times as strong as theirs: no stranger to a gyro that feels it, and one to a gyro that does not."""
    turned = []
    for run, field in zip([*runs(), *check()], (1.0, 4.0, 40.0), strict=True):
        table = run.table.clone()
        table[:, run.columns.index("field_ut")] = field
        turned.append(replace(run, table=table, error=run.error + 0.01 * field))
    bench = open_bench(turned, base, catalogue)
    bare, felt = (bench.begin((*base, *more)) for more in ((), ("magnetic",)))
    assert [one["run"] for one in strangers(bench, [bare])] == [turned[-1].name]
    assert strangers(bench, [bare, felt]) == []


def test_another_gyros_check_run_is_a_stranger_and_the_gyros_own_is_not(runs, check, base, catalogue) -> None:
    candidates = {name: catalogue[name] for name in (*base, "aging")}
    for odd, told in ((check("aging"), []), (renamed(check("aging"), "other", -1.0), ["other"])):
        record = refine(runs("aging"), odd, base, "aging", candidates).record
        assert [one["run"] for one in record["strangers"]] == told


@pytest.mark.parametrize("hidden", ["", "hysteresis", "bias_step", "chamber_cycling"])
def test_a_gyros_own_runs_are_no_strangers(diagnosis, hidden) -> None:
    """Not where an effect is one run's own, nor where the phase of a line is."""
    assert diagnosis(hidden).record["strangers"] == []


def test_kelvins_called_degrees_are_told(runs, base, catalogue) -> None:
    given = runs("aging")
    hot = [replace(run, table=torch.cat([run.table[:, :1], run.table[:, 1:2] + 273.15, run.table[:, 2:]], dim=1)) for run in given]
    cool, found = (diagnose(one, base, {name: catalogue[name] for name in (*base, "aging")}).record["hot"] for one in (given, hot))
    assert cool == {}
    assert found == pytest.approx({run.name: float(run.temperature.max()) for run in hot})
