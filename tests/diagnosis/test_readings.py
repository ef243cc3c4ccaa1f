"""Thermometers that read in steps of 1/16 K, beside a model that makes much of them."""

from __future__ import annotations

import math
from copy import deepcopy
from dataclasses import replace

import pytest
import torch

from zoo.diagnosis import readings
from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.diagnosis.readings import scatter_in, without_scatter
from zoo.diagnosis.refine import _of_readings, check_rms, refine
from zoo.diagnosis.settle import settle
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import leaves_noise
from zoo.diagnosis.workbench import Workbench
from zoo.measurements.run import Run
from zoo.measurements.steady import steadied
from zoo.models.prediction import predict_blocks
from zoo.report.verdict import verdict_of
from zoo.scoring.stages import rms
from zoo.simulator.in_process import as_run

STRONG = "thermal_gradient"
"""Shupe's column where there are two thermometers: its RMS is a hundred times the noise before anything of it is beyond the base."""


@pytest.fixture
def few(base, catalogue):
    """Effects enough to be found in the wrong."""
    return {name: catalogue[name] for name in (*base, STRONG, "fixture_rotation", "sensor_lag", "viscoelastic", "glass_transition")}


@pytest.fixture
def troubled(runs, base, catalogue):
    """A bench of which the base makes more noise than there is."""
    bench = open_bench(runs(STRONG, 3), base, catalogue)
    return bench, bench.begin(tuple(base))


def test_where_a_model_makes_little_of_them_nothing_is_touched(runs, base, catalogue) -> None:
    bench = open_bench(runs("hysteresis"), base, catalogue)
    assert without_scatter(bench, [bench.begin(tuple(base))]) is bench
    assert bench.scatter == 0.0


def test_where_no_curve_can_be_drawn_nothing_is_said_of_one(runs, base, catalogue, monkeypatch) -> None:
    """As through the readings of a run of some minutes, whatever they make of the model."""
    monkeypatch.setattr(readings, "MATTERS", 0.0)
    monkeypatch.setattr(readings, "steadied", lambda run: run)
    bench = open_bench(runs(""), base, catalogue)
    assert without_scatter(bench, [bench.begin(tuple(base))]) is bench


def test_what_filters_readings_must_explain_more_than_their_scatter(runs, base, catalogue) -> None:
    """All that the scatter adds to χ² is what a filter could take away."""
    bench = open_bench(runs("glass_transition"), base, catalogue)
    bench.stirred = 0.3 * bench.mixtures.white
    before, names = bench.begin(tuple(base)), ("fixture_rotation", "glass_transition")
    added = [bench.add(before, name, (name,)) for name in names]
    judged = [bench.evidence(before, one) for one in added]
    bench.stirred = 0.0
    for one in (before, *added):
        one.prices.clear()
    less = [bench.evidence(before, one) - known for one, known in zip(added, judged, strict=True)]
    assert less == pytest.approx([0.5 * bench.blocks * 0.09, 0.0])


def test_a_filter_of_readings_is_no_effect(simulation, white, catalogue, base, monkeypatch) -> None:
    """A large coefficient of the true coil's rate, and thermometers that read in steps: nothing is hidden."""
    few = {name: catalogue[name] for name in (*base, STRONG, "fixture_rotation", "sensor_lag")}
    found = []
    for one in simulation().runs:
        time, coil = one.truth["time_s"], one.truth["temperature_coil_c"]
        rate = torch.gradient(coil, spacing=(time / 60,))[0]
        found.append(replace(as_run(one), error=as_run(one).error + 100.0 * white * rate))
    assert diagnose(found, base, few).verdict == "complete"
    monkeypatch.setattr(Workbench, "_of_readings", lambda *_: 0.0)
    assert diagnose(found, base, few).record["missing"] == ["fixture_rotation"]


def test_drawn_smooth_they_make_less_noise_and_what_is_left_is_reckoned_with(troubled, white) -> None:
    """Against other readings of temperatures that are known: with a noise of .02 K, in steps of 1/16 K."""
    bench, solved = troubled
    steady = without_scatter(bench, [solved])
    made = rms(torch.cat([_output(solved, read) - _output(solved, drawn) for read, drawn in zip(bench.runs, steady.runs, strict=True)]))
    anew = [_read(run, seed) for seed, run in enumerate(steady.runs)]
    left = rms(torch.cat([_output(solved, steadied(read)) - _output(solved, true) for read, true in zip(anew, steady.runs, strict=True)]))
    assert made > 1.3 * white
    assert left < 0.6 * made  # of a difference; of a rate a third
    assert steady.scatter == pytest.approx(left, rel=0.2)
    assert steady.mixtures.white == pytest.approx(math.hypot(bench.mixtures.white, left), rel=0.1)
    assert steady.steadied
    assert not bench.steadied


def test_nothing_is_missing_where_only_the_steps_of_readings_are_left(runs, base, few, monkeypatch) -> None:
    found = diagnose(runs(STRONG, 3), base, few)
    assert found.verdict == "complete"
    assert any("drawn smooth for the diagnosis" in note for note in found.record["notes"])
    monkeypatch.setattr("zoo.diagnosis.settle.without_scatter", lambda bench, models: bench)
    bench, search = settle(open_bench(runs(STRONG, 3), base, few), tuple(base), [name for name in few if name not in base])
    assert not leaves_noise(bench, search.final, search.base), "readings as they are"


def test_the_model_that_flies_is_fitted_to_readings_as_they_are(runs, check, base, few) -> None:
    """One that was fitted to smooth readings makes more of the others' scatter: it is for looking back."""
    given, unseen = runs(STRONG, 3), check(STRONG, 3)
    found = refine(given, unseen, base, [], few)
    record, steady = found.record, found.diagnosis.search.base
    assert steady.design.runs[0].read is not None
    assert found.solutions[0].design.runs[0].read is None
    torch.testing.assert_close(found.solutions[0].design.runs[0].table, given[0].table, rtol=0, atol=0)
    raw = open_bench(given, base, few).begin(tuple(base))
    (step,) = record["ladder"]
    assert step["rms"] == pytest.approx(raw.rms, rel=0.02)
    assert step["rms_check"] == pytest.approx(check_rms(raw.model, unseen), rel=0.02)
    assert step["rms_check"] < 0.95 * check_rms(steady.model, unseen)
    assert record["borne_out"]
    assert record["verdict"] == "complete"
    gyro, read = record["noise_floor_check"], record["readings"]["check"]
    assert read == scatter_in(found.model, unseen) > 0.5 * gyro
    assert step["rms_check"] == pytest.approx(math.hypot(gyro, read), rel=0.2)
    assert any("thermometers" in sentence for sentence in verdict_of(found.diagnosis.record, record).sentences)


def test_a_rung_that_makes_more_of_the_scatter_is_not_excused_by_it(runs, base, catalogue) -> None:
    bench = open_bench(runs(STRONG, 3), base, catalogue)
    steady = without_scatter(bench, [bench.begin(tuple(base))])
    modest = steady.begin(tuple(base))
    bold = replace(modest, model=deepcopy(modest.model))
    bold.model.assign(modest.fit.theta, 3.0 * modest.fit.amplitudes)
    assert scatter_in(bold.model, steady.runs) > 1.5 * scatter_in(modest.model, steady.runs)
    alone, both = (_of_readings(steady, solutions, steady.runs)["check"] for solutions in ([modest], [modest, bold]))
    assert alone == both


def test_steady_runs_are_not_drawn_again(troubled) -> None:
    bench, solved = troubled
    steady = without_scatter(bench, [solved])
    assert without_scatter(steady, [steady.begin(solved.names)]) is steady
    assert steady.as_read().scatter == 0.0
    torch.testing.assert_close(steady.as_read().runs[0].table, bench.runs[0].table, rtol=0, atol=0)
    for other in (steady.with_white(1.0), steady.with_noise(steady.noise), steady.with_effects(dict(steady.effects))):
        assert other.scatter == steady.scatter


def _output(solved: Solved, run: Run) -> torch.Tensor:
    return predict_blocks(solved.model, run)


def _read(run: Run, seed: int) -> Run:
    """A run with its thermometers read anew."""
    random, table = torch.Generator().manual_seed(seed), run.table.clone()
    for place in map(run.columns.index, run.thermometers):
        noise = torch.randn(len(table), generator=random, dtype=table.dtype)
        table[:, place] = torch.round((table[:, place] + 0.02 * noise) / 0.0625) * 0.0625
    return replace(run, table=table, read=None)
