"""A small effect beside a large one: its own, or the large one's misfit."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from zoo.diagnosis import corrections
from zoo.diagnosis.acceptance import ACCEPT, convinces
from zoo.diagnosis.corrections import _freer, has_own_input, is_smooth, stands_apart
from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.diagnosis.quantities import by_the_clock, momentary
from zoo.diagnosis.screening import Screened
from zoo.diagnosis.trials import OVERWHELMING, Step, Trial
from zoo.fitting.projection import complement, orthonormal
from zoo.measurements.run import Run
from zoo.simulator.in_process import as_run


@pytest.mark.parametrize("seed", [1, 3])
def test_a_small_effect_beside_a_large_one_of_one_quantity_is_named(simulation, catalogue, base, seed) -> None:
    """Fringes of less than the noise beside ageing of thirty times it, which any function of time would explain as well."""
    large, small = simulation("aging", seed, 30.0), simulation("polarization", seed, 0.7)
    runs = []
    for one, other in zip(large.runs, small.runs, strict=True):
        run = as_run(one)
        runs.append(replace(run, error=run.error + other.truth["polarization_dph"]))
    found = diagnose(runs, base, catalogue)
    assert (found.verdict, set(found.search.missing)) == ("missing", {"aging", "polarization"})


@pytest.fixture(scope="module")
def drifting():
    """A bench, its base and an ageing for a drift with a bend that ageing does not have."""

    def of(simulation, catalogue, base, white):
        runs = []
        for one in simulation("", 1).runs:
            run = as_run(one)
            share = (run.time - run.time[0]) / float(run.time[-1] - run.time[0])
            runs.append(replace(run, error=run.error + white * (30 * torch.log1p(8 * share) + 2.0 * torch.sin(5 * share))))
        bench = open_bench(runs, base, catalogue)
        start = bench.solve(tuple(base))
        return bench, start, bench.add(start, "aging")

    return of


def test_what_a_freer_form_of_the_first_explains_is_no_effect_of_its_own(drifting, simulation, catalogue, base, white) -> None:
    """What a warm-up was called for by, a function of time takes over."""
    bench, start, before = drifting(simulation, catalogue, base, white)
    after = bench.add(before, "warm_up")
    evidence = bench.evidence(before, after)
    assert evidence > 10.0
    assert not stands_apart(bench, start, before, after, evidence, 8.0)


def test_an_addition_stands_apart_beside_each_function_that_may_be_the_freer_form(drifting, simulation, catalogue, base, white, monkeypatch) -> None:
    """What is slow goes with several quantities, of which the one that follows it best may know nothing of a bend that belongs to another."""
    bench, start, before = drifting(simulation, catalogue, base, white)
    after = bench.add(before, "warm_up")
    (own,) = _freer(bench, start, before)
    other = bench.known(before.names).fit.plain.new_zeros(len(own), 1)
    found = []
    for forms in ([other], [other, own], [own, other], []):
        monkeypatch.setattr(corrections, "_freer", lambda *_, forms=forms: forms)
        found.append(stands_apart(bench, start, before, after, bench.evidence(before, after), 8.0))
    assert found == [True, False, False, False]


def both(simulation, large: str, small: str, sizes: tuple[float, float]) -> list[Run]:
    """Two effects, the second far smaller than the first."""
    recorded = zip(simulation(large, 1, sizes[0]).runs, simulation(small, 1, sizes[1]).runs, strict=True)
    return [replace(as_run(one), error=as_run(one).error + other.truth[f"{small}_dph"]) for one, other in recorded]


@pytest.mark.parametrize(
    ("large", "small", "smooth"),
    [
        ("aging", "glass_transition", True),
        ("aging", "polarization", False),
        ("chamber_cycling", "glass_transition", False),
        ("polarization", "rate_temperature_coupling", False),
    ],
)
def test_what_is_smooth_is_off_by_something_smooth(simulation, catalogue, base, large, small, smooth) -> None:
    """Not by fringes; and no line and no fringe is off by anything smooth."""
    bench = open_bench(both(simulation, large, small, (15.0, 3.0)), base, catalogue)
    start = bench.solve(tuple(base))
    before = bench.add(start, large)
    after = bench.add(before, small)
    evidence = bench.evidence(before, after)
    assert evidence > 10.0
    assert is_smooth(bench, start, before, after, evidence) is smooth


@pytest.mark.parametrize(
    ("small", "size", "evidence", "convincing"), [("moisture", 9.0, 30.0, False), ("moisture", 9.0, 250.0, True), ("polarization", 4.0, 30.0, True)]
)
def test_what_is_easily_confused_with_what_is_there_must_be_a_fair_part_of_it(simulation, catalogue, base, small, size, evidence, convincing) -> None:
    """All three take away a twentieth of the variance, which is enough for what nobody takes for stress that relaxes, and leave noise."""
    bench = open_bench(both(simulation, "viscoelastic", small, (20.0, size)), base, catalogue)
    start = bench.solve(tuple(base))
    before = bench.add(start, "viscoelastic")
    after = bench.add(before, small)
    assert 0.035 < (before.rms**2 - after.rms**2) / (start.rms**2 - before.rms**2) < 0.0625
    trial = Trial(Screened(small, after.shape_of(small), 0.0, 0), after, evidence, True)
    assert convinces(bench, start, Step(before, [trial], ACCEPT), trial) is convincing


@pytest.mark.parametrize(("small", "convincing"), [("glass_transition", False), ("polarization", True)])
def test_a_smooth_thirteenth_of_what_is_there_is_its_form_however_strong_the_evidence(simulation, catalogue, base, small, convincing) -> None:
    """Fringes as small are no part of any ageing."""
    bench = open_bench(both(simulation, "aging", small, (30.0, 2.3)), base, catalogue)
    start = bench.solve(tuple(base))
    before = bench.add(start, "aging")
    after = bench.add(before, small)
    assert before.rms**2 - after.rms**2 < 0.0064 * (start.rms**2 - before.rms**2)
    trial = Trial(Screened(small, after.shape_of(small), 0.0, 0), after, bench.evidence(before, after), True)
    assert trial.evidence > OVERWHELMING
    assert convinces(bench, start, Step(before, [trial], ACCEPT), trial) is convincing


BOTH_WAYS, ONE_WAY, STILL = (-1.0, 1.0), (1.0, 2.0), (1.0, 1.0)


@pytest.mark.parametrize(
    ("rates", "name", "others", "own"),
    [
        (STILL, "supply_voltage", ["aging"], True),
        (STILL, "supply_voltage", ["magnetic"], True),
        (STILL, "supply_voltage", ["supply_voltage", "magnetic"], False),
        (STILL, "aging", ["magnetic"], False),
        (BOTH_WAYS, "scale_factor", ["polarization"], True),
        (BOTH_WAYS, "scale_factor", ["misalignment"], False),
        (BOTH_WAYS, "misalignment", ["fixture_rotation"], False),
        (BOTH_WAYS, "fixture_rotation", ["aging"], True),
        (ONE_WAY, "scale_factor", ["aging"], True),
        (ONE_WAY, "fixture_rotation", ["aging"], False),
        (STILL, "scale_factor", ["aging"], False),
        (STILL, "fixture_rotation", ["aging"], False),
    ],
)
def test_an_input_of_its_own_changes_and_is_one_that_the_others_do_not_know(simulation, catalogue, base, rates, name, others, own) -> None:
    """A fixture's rotation looks at the way in which the table turns, and a scale factor at how fast."""
    bench = open_bench([turning(as_run(one), *rates) for one in simulation("", 1).runs], base, catalogue)
    assert has_own_input(bench, name, others) is own


@pytest.mark.parametrize(("volts", "own"), [(0.1, True), (0.0, False)])
def test_a_column_that_never_changes_is_no_input_of_its_own(simulation, catalogue, base, volts, own) -> None:
    runs = [as_run(one) for one in simulation("", 1).runs]
    runs = [recorded(run, "supply_v", 5.0 + volts * (run.time / 1000).sin()) for run in runs]
    assert has_own_input(open_bench(runs, base, catalogue), "supply_voltage", ["aging"]) is own


def turning(run: Run, slow: float, fast: float) -> Run:
    """On a table that turns at one rate and at another in turns."""
    return recorded(run, run.columns[-1], torch.where(((run.time - run.time[0]) / 1700.0).long() % 2 == 0, fast, slow).to(run.error))


def recorded(run: Run, column: str, values: Tensor) -> Run:
    """With other values in a column."""
    table = run.table.clone()
    table[:, run.columns.index(column)] = values
    return replace(run, table=table)


def test_a_small_effect_of_a_column_is_named_beside_large_fringes(simulation, catalogue, base) -> None:
    """No free function stands for fringes; but they know nothing of the supply."""
    large, small = simulation("polarization", 1, 30.0), simulation("supply_voltage", 1, 0.7)
    runs = [as_run(one) for one in large.runs]
    runs = [replace(run, error=run.error + other.truth["supply_voltage_dph"]) for run, other in zip(runs, small.runs, strict=True)]
    found = diagnose(runs, base, catalogue)
    assert (found.verdict, set(found.search.missing)) == ("missing", {"polarization", "supply_voltage"})


@pytest.mark.parametrize("seed", [1])
def test_a_small_effect_beside_a_large_line_is_named(simulation, catalogue, base, seed) -> None:
    large, small = simulation("chamber_cycling", seed, 20.0), simulation("rate_temperature_coupling", seed, 1.0)
    runs = [as_run(one) for one in large.runs]
    runs = [replace(run, error=run.error + other.truth["rate_temperature_coupling_dph"]) for run, other in zip(runs, small.runs, strict=True)]
    found = diagnose(runs, base, catalogue)
    assert (found.verdict, found.search.missing[0]) == ("missing", "chamber_cycling")
    assert found.search.missing[1:] in (["rate_temperature_coupling"], ["glass_transition"]), "the two are alike here"


@pytest.mark.parametrize(("size", "phase"), [(0.0, 0.5), (1.0, 0.0)])
def test_the_freer_form_of_a_line_has_a_phase_that_wanders_and_a_size_that_changes(simulation, catalogue, base, white, size, phase) -> None:
    """By half a radian in each run, or three times as large hot as cold: what the line leaves of it a freer one takes over."""
    runs, waves = [], []
    for one in simulation("", 1).runs:
        run = as_run(one)
        share, warm = run.time / float(run.time[-1]), (run.column("temperature_c") - 20) / 80
        wave = 8 * white * (1 + size * warm) * (2 * torch.pi * run.time / 400 + phase * (2 * torch.pi * share).sin()).sin()
        runs.append(replace(run, error=run.error + wave))
        waves.append(run.block_mean(wave))
    bench = open_bench(runs, base, catalogue)
    start = bench.solve(tuple(base))
    line = bench.add(start, "chamber_cycling")
    left = complement(torch.cat(waves).unsqueeze(1), orthonormal(line.fit.plain))
    (freer,) = _freer(bench, start, line)
    assert left.norm() > white * len(left) ** 0.5
    assert complement(left, orthonormal(torch.cat([line.fit.plain, freer], dim=1))).norm() < 0.1 * left.norm()


def tilted(run: Run, white: float, curved: float) -> Run:
    """A table that turns one way and the other, and an axis whose tilt grows with the temperature, or saturates [white]."""
    turned = turning(run, -10.0, 10.0)
    way = turned.table[:, -1].sign()
    theta = (run.select([run.thermometers[-1]]).squeeze(1) - 20) / 40
    return replace(turned, error=run.error + 12 * white * way * (0.5 + (1 - curved) * theta + curved * (3 * theta).tanh()))


@pytest.mark.parametrize("seed", [1, 3])
def test_small_fringes_beside_a_large_scale_factor_are_named(simulation, catalogue, base, white, seed) -> None:
    """What goes with the true input, whatever its form, makes no fringes at rest."""
    runs = []
    for one in simulation("polarization", seed, 1.0).runs:
        runs.append(tilted(as_run(one), white, 0.1))
    found = diagnose(runs, base, catalogue)
    assert found.verdict == "missing"
    assert "polarization" in found.search.missing
    assert len(found.search.missing) == 2
    assert set(found.search.missing) & {"scale_factor", "misalignment", "scale_factor_nonlinearity"}


def test_what_a_saturating_scale_factor_leaves_is_no_effect_of_its_own(simulation, catalogue, base, white) -> None:
    """Whatever is added for the bend that no parabola has, the same input with a freer size takes over."""
    bench = open_bench([tilted(as_run(one), 3 * white, 1.0) for one in simulation("", 1).runs], base, catalogue)
    start = bench.solve(tuple(base))
    before = bench.add(start, "misalignment")
    for name in ("polarization", "fixture_rotation", "glass_transition"):
        after = bench.add(before, name)
        evidence = bench.evidence(before, after)
        assert evidence > 50.0, name
        assert not stands_apart(bench, start, before, after, evidence, 8.0), name


@pytest.mark.parametrize(
    "name", ["aging", "bias_step", "chamber_cycling", "mohr", "polarization", "magnetic", "dead_band", "scale_factor", "misalignment"]
)
def test_what_has_no_memory_is_known_from_its_columns(catalogue, name) -> None:
    assert momentary(catalogue[name])


@pytest.mark.parametrize("name", ["hysteresis", "viscoelastic", "moisture", "sensor_lag", "shupe", "fixture_rotation"])
def test_what_has_a_memory_is_known_from_its_columns(catalogue, name) -> None:
    assert not momentary(catalogue[name])


@pytest.mark.parametrize("name", ["aging", "warm_up", "bias_step", "chamber_cycling", "mohr", "polarization", "magnetic", "dead_band", "moisture"])
def test_what_goes_by_the_clock_is_known_from_its_columns(catalogue, name) -> None:
    assert by_the_clock(catalogue[name]) is (name in ("aging", "warm_up", "bias_step", "chamber_cycling"))
