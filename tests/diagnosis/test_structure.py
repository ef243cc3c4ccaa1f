"""What passes for noise and what does not, where the level and smooth dependences of the residual tell nothing."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace

import pytest
import torch
from torch import Generator, Tensor

from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.free_functions import SIGNIFICANT, TOGETHER, anywhere, free_functions, functions_of, worth
from zoo.diagnosis.moments import moments, rarity
from zoo.diagnosis.outdone import outdone
from zoo.diagnosis.restless import restless
from zoo.diagnosis.solved import Freed, Solved
from zoo.diagnosis.structure import (
    CLEAR,
    LEVEL_ALLOWED,
    LINE,
    MATERIAL,
    SLIGHT,
    Structure,
    _lines,
    _Test,
    examine,
    free_dependences,
    leaves_noise,
    spectral_line,
)
from zoo.diagnosis.swings import _around, recurrence, swings
from zoo.diagnosis.workbench import Workbench
from zoo.measurements.run import Run
from zoo.simulator.noise import rate_walk

WALK, SWITCHES_PER_HOUR = 2.5, 0.25
"""Rate random walk per √h over the white noise of a block, more than any gyro's that is not broken; and how often a telegraph switches."""

LINE_S, LINE_SHARE, SUPPLY_SHARE = 900.0, 0.5, 3.0
"""Period, and amplitude of a line and RMS of what a supply does, over the white noise of a block."""

BURST = 7.0
"""First block of a burst in every run, over the white noise of a block."""

HIGHEST = 0.16
"""What the highest temperature so far adds per K, over the white noise of a block."""


@pytest.fixture
def planted(simulation, runs, catalogue, base) -> Callable[..., Workbench]:
    """The bench of a gyro without secrets and of what a function (run, its coil's temperature) -> (T,) adds to each run."""

    def plant(what: Callable[[Run, Tensor], Tensor], seed: int, most: int = 2) -> Workbench:
        coils = [one.truth["temperature_coil_c"] for one in simulation("", seed).runs]
        given = list(zip(runs("", seed), coils, strict=True))[:most]
        return open_bench([replace(run, error=run.error + what(run, coil)) for run, coil in given], base, catalogue)

    return plant


def is_noise(bench: Workbench, final: Solved, base: Solved) -> bool:
    """Whether what is left is noise, which both ways of asking must agree on."""
    whole = examine(bench, final, base).is_noise
    assert leaves_noise(bench, final, base) is whole
    return whole


def looks_quiet(structure: Structure) -> bool:
    """Whether nothing but the part in question objects: no excess, no smooth dependence, no line."""
    return structure.excess < LEVEL_ALLOWED and not structure.dependences


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_a_large_random_walk_of_normal_steps_is_noise(planted, base, white, seed) -> None:
    chance = Generator().manual_seed(seed)
    bench = planted(lambda run, coil: rate_walk(WALK * white, len(run.time), 20.0, chance), seed)
    solved = bench.solve(tuple(base))
    assert is_noise(bench, solved, solved)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_a_bias_that_switches_is_not_though_it_spreads_as_fast(planted, base, white, seed) -> None:
    """Steps of ±d at a rate r spread by d²·r·t, a walk by K²·t: nothing but the steps' distribution tells them apart."""
    chance = Generator().manual_seed(seed)
    half = 0.5 * WALK * white / math.sqrt(SWITCHES_PER_HOUR)

    def telegraph(run: Run, coil: Tensor) -> Tensor:
        span = float(run.time[-1] - run.time[0])
        moments = span * torch.rand(round(SWITCHES_PER_HOUR * span / 3600.0), generator=chance, dtype=torch.float64)
        return half * (1.0 - 2.0 * ((run.time - run.time[0]).unsqueeze(1) > moments).sum(dim=1).remainder(2))

    bench = planted(telegraph, seed)
    solved = bench.solve(tuple(base))
    structure = examine(bench, solved, solved)
    assert bench.mixtures.much_walk(solved.likely.noise)
    assert looks_quiet(structure)
    assert not structure.is_noise


@pytest.mark.parametrize(("share", "most"), [(0.1, 0.03), (0.5, 0.6)])
def test_what_is_left_far_below_the_noise_is_no_sign_of_anything(planted, base, white, share, most) -> None:
    """However clearly it goes with something: of runs without noise all that is left does."""
    bench = planted(lambda run, coil: 5 * white * torch.sin(run.time / 700.0), 1)
    solved = bench.solve(tuple(base))
    assert examine(bench, solved, solved).strain > 1.0
    faint = replace(solved)
    faint.__dict__["residual"] = solved.residual * share * bench.mixtures.white / solved.rms
    assert 0.0 < examine(bench, faint, faint).strain < most


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_effect_that_a_free_function_outdoes_is_not_what_it_is(planted, base, white, seed) -> None:
    """A polynomial of fourth order in temperature: a glass transition and much walk make noise of it, but any function of temperature does better."""

    def wave(run: Run, coil: Tensor) -> Tensor:
        reduced = ((coil - 20.0) / 42.0).clamp(-1, 1)
        fourth = 8 * reduced.pow(4) - 8 * reduced.square() + 1
        return 2 * white * (fourth - fourth.mean()) / fourth.std()

    bench = planted(wave, seed)
    before = bench.solve(tuple(base))
    wrong, other = (bench.add(before, name) for name in ("glass_transition", "polarization"))
    structure = examine(bench, wrong, before)
    assert bench.evidence(before, wrong) > SIGNIFICANT, "a search could name it"
    assert structure.excess < LEVEL_ALLOWED
    assert outdone(bench, wrong, before) > 1.0
    assert not structure.is_noise
    assert bench.evidence(before, wrong) < bench.evidence(before, other), "fringes have nearly that shape"
    assert not is_noise(bench, other, before), "but a polynomial that is fitted with the coil does better"


def test_a_free_function_is_weighed_at_the_coil_that_suits_it(planted, base, white) -> None:
    """At a coil that lags far too much, functions of its temperature explain less than at one of the grid."""
    bench = planted(lambda run, coil: 0.4 * white * (coil.cummax(dim=0).values - coil[0]), 1)
    fitted = bench.solve(tuple(base))
    lagging = fitted.fit.theta.clone()
    lagging[0] = 0.9
    for solved, least, most in ((fitted, -1.0, 5.0), (bench.moved(fitted, lagging), SIGNIFICANT, math.inf)):
        here = {words: worth(bench, solved, free).evidence for words, free in free_functions(bench, solved).items()}
        there = {words: one.evidence for words, one in anywhere(bench, solved).items()}
        assert all(there[words] > evidence - 1.0 for words, evidence in here.items()), "its own coil is one of them"
        assert max(there, key=lambda words: there[words]) == "the highest temperature so far"
        assert least < there["the highest temperature so far"] - here["the highest temperature so far"] < most


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_columns_are_worth_the_orders_that_are_called_for(planted, base, white, seed) -> None:
    """What is linear in the size of the rate costs one order, and any basis of the same polynomials finds it."""
    bench = planted(lambda run, coil: 0.8 * white * torch.gradient(coil, spacing=(run.time,))[0].abs() * 60.0, seed)
    solved = bench.solve(tuple(base))
    free = free_functions(bench, solved)["the size of the temperature rate, not its sign"]
    mixed = free @ torch.triu(torch.ones(free.shape[1], free.shape[1], dtype=free.dtype))
    first, found, other = (worth(bench, solved, columns) for columns in (free[:, :1], free, mixed))
    assert first.evidence - math.log(2.0) - 1.0 < found.evidence, "and the noise may be chosen beside all of them"
    assert other == pytest.approx(found, abs=1e-3)


def test_a_function_of_temperature_and_rate_has_every_product_of_them(runs, catalogue, base) -> None:
    """Up to the fourth degree, beside what is of the temperature alone, whatever units they are in."""
    bench = open_bench(runs(""), base, catalogue)
    together = next(one for one in functions_of(bench, bench.solve(tuple(base))) if one.words == TOGETHER)
    assert together.beside is not None
    rates, temperatures = (torch.linspace(axis.low, axis.high, 9, dtype=torch.float64) for axis in (together.axis, together.beside))
    rate, temperature = (one.flatten() for one in torch.meshgrid(rates, temperatures, indexing="ij"))
    of_temperature = torch.stack([(temperature / 60).pow(i) for i in range(4)], dim=1)
    columns = torch.cat([of_temperature, together.at(rate, temperature)], dim=1)
    for i in range(4):
        for j in range(1, 5 - i):
            product = (temperature / 60).pow(i) * (rate / rates.abs().max()).pow(j)
            left = product - columns @ torch.linalg.lstsq(columns, product.unsqueeze(1)).solution.squeeze(1)
            assert float(left.norm() / product.norm()) < 1e-10, (i, j)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_temperature_times_the_square_of_the_rate_goes_with_both(planted, base, white, seed) -> None:
    def product(run: Run, coil: Tensor) -> Tensor:
        both = coil * torch.gradient(coil, spacing=(run.time,))[0].square()
        return 1.5 * white * both / both.std()

    bench = planted(product, seed)
    found = {words: one.evidence for words, one in anywhere(bench, bench.solve(tuple(base))).items()}
    assert max(found, key=lambda words: found[words]) == TOGETHER


@pytest.mark.parametrize(("seed", "size"), [(1, 2.0), (2, 2.4), (3, 3.0)])
def test_a_small_share_is_not_overlooked_where_it_clearly_goes_with_something(planted, base, white, seed, size) -> None:
    """What only heating brings goes into Shupe's effect for the most part; what that leaves is a fifteenth of the variance, and nothing by chance."""

    def heating(run: Run, coil: Tensor) -> Tensor:
        warming = torch.gradient(coil, spacing=(run.time,))[0].clamp_min(0.0)
        return size * white * warming / warming.max()

    bench = planted(heating, seed)
    before = bench.solve(tuple(base))
    best = max(anywhere(bench, before).values(), key=lambda one: one.evidence)
    assert SLIGHT < 2.0 * best.gain / bench.blocks < MATERIAL
    assert not is_noise(bench, before, before)


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_noise_is_worth_nothing_at_any_coil(runs, catalogue, base, seed) -> None:
    bench = open_bench(runs("", seed), base, catalogue)
    assert max(one.evidence for one in anywhere(bench, bench.solve(tuple(base))).values()) < SIGNIFICANT


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_highest_temperature_is_not_moisture(planted, base, white, seed) -> None:
    """A first heating that the second does not repeat dries a coil as well, but in proportion to the highest temperature takes fewer parameters."""
    bench = planted(lambda run, coil: HIGHEST * white * (coil.cummax(dim=0).values - coil[0]), seed)
    before = bench.solve(tuple(base))
    wrong = bench.add(before, "moisture")
    assert bench.evidence(before, wrong) > SIGNIFICANT, "a search could name it"
    assert not is_noise(bench, wrong, before)


def test_what_a_bent_coil_leaves_counts_by_its_evidence_and_by_its_share_of_chi_squared(diagnosis) -> None:
    found = diagnosis("")
    bench, base = found.bench, found.search.base
    known, needed = dict(base.freed), SIGNIFICANT + math.log(2)
    try:
        for evidence, share, noise in (
            (1.1 * needed, 1.1 * MATERIAL, False),
            (1.1 * needed, 0.9 * MATERIAL, True),
            (SIGNIFICANT, 1.1 * MATERIAL, True),
            (1.1 * CLEAR * needed, 1.1 * SLIGHT, False),
            (0.9 * CLEAR * needed, 0.9 * MATERIAL, True),
            (100.0 * needed, 0.9 * SLIGHT, True),
        ):
            base.freed.clear()
            base.freed.update({"the size": Freed(evidence, 0.5 * share * bench.blocks, evidence), "the time": Freed(-1.0, 3.0, -9.0)})
            assert is_noise(bench, base, base) is noise, (evidence, share)
    finally:
        base.freed.clear()
        base.freed.update(known)


def test_what_happens_at_few_moments_is_no_noise_and_they_are_told(planted, base, white) -> None:
    """Bursts that die within ten minutes, which a noise mixture takes for flicker."""
    moments_h = {1: (2.0, 6.5), 2: (4.2,)}

    def door(run: Run, coil: Tensor) -> Tensor:
        since = [(run.time - run.time[0] - 3600 * hours) for hours in moments_h[int(run.name.rsplit("_", 1)[1])]]
        return sum((8 * white * torch.exp(-one.clamp_min(0) / 600) * (one > 0) for one in since), torch.zeros_like(run.time))

    bench = planted(door, 1)
    solved = bench.solve(tuple(base))
    assert not is_noise(bench, solved, solved)
    assert rarity(bench, solved) > 1.5
    told = moments(bench, solved)
    assert [name for name, _ in told] == ["run_1", "run_1", "run_2"]
    assert [hours for _, hours in told] == pytest.approx([2.0, 6.5, 4.2], abs=0.3)
    said = restless(bench, solved)
    assert said.startswith("It happens at few moments: run_1 at ")
    assert "thermometer" not in said, "three times, at any temperature"


def test_moments_that_have_their_temperature_in_common_say_so(planted, base, white) -> None:
    """A burst whenever the coil warms through 40 °C."""

    def latch(run: Run, coil: Tensor) -> Tensor:
        crossed = torch.nonzero((coil[1:] > 40.0) & (coil[:-1] <= 40.0)).flatten()
        since = [run.time - run.time[place] for place in crossed]
        return sum((8 * white * torch.exp(-one.clamp_min(0) / 600) * (one > 0) for one in since), torch.zeros_like(run.time))

    bench = planted(latch, 1)
    said = restless(bench, bench.solve(tuple(base)))
    low, high = (float(word) for word in re.findall(r"thermometer between ([\d.]+) and ([\d.]+) °C while it warms\.$", said)[0])
    assert 35.0 < low <= high < 52.0, "which leads the coil"


@pytest.mark.parametrize(("share", "noise"), [(0.7, False), (6.0, True)])
def test_a_burst_is_forgiven_beside_an_effect_that_explains_far_more(planted, base, white, share, noise) -> None:
    """What a supply explains is `share` times the white noise; its form may leave 4 % of that squared, up to a quarter of the noise."""

    def both(run: Run, coil: Tensor) -> Tensor:
        supply, since = run.column("supply_v"), run.time - run.time[0] - 3600 * 4.2
        return share * white * (supply - supply.mean()) / supply.std() + BURST * white * torch.exp(-since.clamp_min(0) / 400) * (since > 0)

    bench = planted(both, 1)
    before = bench.solve(tuple(base))
    final = bench.add(before, "supply_voltage")
    assert rarity(bench, final) > 1.5
    assert is_noise(bench, final, before) is noise


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_noise_happens_all_the_time(runs, catalogue, base, seed) -> None:
    bench = open_bench(runs("", seed), base, catalogue)
    assert rarity(bench, bench.solve(tuple(base))) < 0.7


@pytest.mark.parametrize("hidden", ["supply_voltage", "magnetic", "warm_up", "aging"])
def test_a_right_effect_is_ahead_of_every_free_function(diagnosis, hidden) -> None:
    found = diagnosis(hidden)
    bench, base, final = found.bench, found.search.base, found.search.final
    assert final.names[-1] == hidden
    assert is_noise(bench, final, base)
    assert SIGNIFICANT < free_dependences(bench, base)[0].evidence < bench.evidence(base, final), "which would do much as well"


def test_a_line_is_forgiven_as_what_a_large_effect_leaves_and_not_by_itself(planted, base, white) -> None:
    """A sine that the simplification of a form could leave, an eighth of what the effect does, and the same where nothing else does more."""

    def faint_line(run: Run, coil: Tensor) -> Tensor:
        return LINE_SHARE * white * (2 * torch.pi * run.time / LINE_S).sin()

    def beside_supply(run: Run, coil: Tensor) -> Tensor:
        supply = run.column("supply_v")
        return faint_line(run, coil) + SUPPLY_SHARE * white * (supply - supply.mean()) / supply.std()

    alone, beside = planted(faint_line, 1), planted(beside_supply, 1)
    before = beside.solve(tuple(base))
    final = beside.add(before, "supply_voltage")
    line = spectral_line(beside, final)
    assert line is not None
    assert line.evidence > LINE
    assert is_noise(beside, final, before)
    assert not is_noise(beside, final, final), "the same residual, nothing added"
    solved = alone.solve(tuple(base))
    assert not is_noise(alone, solved, solved)


def chirp(time: Tensor) -> Tensor:
    """A sine whose period falls from 1500 s to 750 s within ten hours."""
    return (2 * torch.pi * time / 1500 * (1 + time / 72_000)).sin()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_swings_faster_and_faster_is_no_noise(planted, base, white, seed) -> None:
    """No frequency stands out of it, and flicker takes over its variance."""
    bench = planted(lambda run, coil: 1.2 * white * chirp(run.time - run.time[0]), seed)
    solved = bench.solve(tuple(base))
    found = swings(bench, solved)
    assert found.matters
    assert 600 < found.periods_s[0] < found.periods_s[1] < 2000
    assert not is_noise(bench, solved, solved)
    said = restless(bench, solved)
    assert said.startswith("It swings, with no period that stays: every ")
    assert "chamber" not in said, "too slow for one"


def test_what_swings_as_a_chamber_does_is_said_to(planted, base, white) -> None:
    """Every six minutes, with a phase that wanders by 5 rad within hours."""
    bench = planted(lambda run, coil: 1.2 * white * (2 * torch.pi * run.time / 360 + 5 * (run.time / 2900).sin()).sin(), 1)
    said = restless(bench, bench.solve(tuple(base)))
    assert said.startswith("It swings, with no period that stays: every ")
    assert "So does the air of a chamber" in said


@pytest.mark.parametrize(
    ("period_s", "overtone", "phases", "said"),
    [
        (4020.0, 0.5, (0.3, 2.1), ", in each run with a phase of its own"),
        (1500.0, 0.0, (0.3, 3.1), ", in each run with a phase of its own"),
        (700.0, 0.0, (0.3, 0.3), ", with the same phase in all runs"),
        (430.0, 0.0, (0.3, 2.1), ", in each run with a phase of its own"),
        (700.0, 0.0, (0.3,), ""),
    ],
)
def test_a_line_has_a_period_and_runs_a_phase_each(planted, base, white, period_s, overtone, phases, said) -> None:
    runs, phases = len(phases), iter(phases)

    def line(run: Run, coil: Tensor) -> Tensor:
        angle = 2 * torch.pi * (run.time - run.time[0]) / period_s + next(phases)
        return 3 * white * (angle.sin() + overtone * (2 * angle).cos())

    bench = planted(line, 1, runs)
    solved = bench.solve(tuple(base))
    found = recurrence(bench, solved)
    assert found.period_s == pytest.approx(period_s, rel=0.02), "a tenth of a resolution"
    assert restless(bench, solved) == f"It recurs every {found.period_s / 60:.2g} min{said}."


def wandering(run: Run, seed: int) -> Tensor:
    """A chamber's line of 7 min whose phase walks by 0.008 of a cycle in each, and its overtone."""
    steps = torch.randn(len(run.time), generator=Generator().manual_seed(seed), dtype=torch.float64)
    cycles = run.time / 420.0 + 0.008 * ((run.time[1] - run.time[0]) / 420.0).sqrt() * steps.cumsum(0)
    return (2 * torch.pi * cycles).sin() + 0.05 * (4 * torch.pi * cycles).cos()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_a_line_with_a_wandering_phase_leaves_around_it_is_its_own(planted, base, white, seed) -> None:
    bench = planted(lambda run, coil: 8 * white * wandering(run, seed), seed).with_white(white)
    before = bench.solve(tuple(base))
    final = bench.add(before, "chamber_cycling")
    assert swings(bench, final).matters, "a band is left"
    assert is_noise(bench, final, before)
    assert not is_noise(bench, final, final), "the same residual, nothing added"


def test_what_is_left_around_a_line_is_its_own_only_where_that_is_little(planted, base, white) -> None:
    """And where means over a block fold it to."""
    allowed = []
    for moved in (lambda run: wandering(run, 1), lambda run: chirp(run.time - run.time[0])):
        bench = planted(lambda run, coil, moved=moved: 8 * white * moved(run), 1).with_white(white)
        before = bench.solve(tuple(base))
        allowed.append(len(_lines(bench, bench.add(before, "chamber_cycling"), before)))
    assert allowed == [3, 0]
    frequency = torch.fft.rfftfreq(400, 100.0).double()
    assert frequency[_around(frequency, (1 / 150,), 100.0)].tolist() == pytest.approx([1 / 300 + k / 40_000 for k in range(-3, 5)], abs=1e-5)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_line_does_not_stand_for_what_swings_faster_and_faster(planted, base, white, seed) -> None:
    bench = planted(lambda run, coil: 3 * white * chirp(run.time - run.time[0]), seed).with_white(white)
    before = bench.solve(tuple(base))
    assert not examine(bench, bench.add(before, "chamber_cycling"), before).is_noise


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_noise_swings_in_no_band(runs, catalogue, base, seed) -> None:
    bench = open_bench(runs("", seed), base, catalogue)
    assert swings(bench, bench.solve(tuple(base))).evidence < 2.0


def test_a_function_of_an_effects_own_input_does_not_outdo_it_and_one_of_anything_else_does(diagnosis) -> None:
    found = diagnosis("")
    bench, base = found.bench, found.search.base
    final, known = bench.add(base, "magnetic"), dict(base.freed)
    try:
        for words, ahead in (("the column field_ut", False), ("the column supply_v", True), ("the coil's temperature", True)):
            base.freed.clear()
            base.freed[words] = Freed(1000.0, 1000.0, 1000.0)
            assert (outdone(bench, final, base) > 1.0) is ahead, words
    finally:
        base.freed.clear()
        base.freed.update(known)


@pytest.mark.parametrize("useless", ["viscoelastic", "moisture"])
def test_what_was_noise_is_noise_beside_an_effect_that_the_runs_speak_against(diagnosis, useless) -> None:
    """As where a user adds it by name: it explains nothing, and takes nothing away from what was complete."""
    found = diagnosis("")
    bench, base = found.bench, found.search.base
    assert is_noise(bench, base, base)
    final = bench.add(base, useless)
    assert bench.evidence(base, final) < 0
    assert is_noise(bench, final, base)


@pytest.mark.parametrize("part", ["_level", "_line", "_swings", "_jumps", "_levels", "_shape", "_outdone"])
def test_each_part_can_object_by_itself(diagnosis, monkeypatch, part) -> None:
    found = diagnosis("")
    bench, base = found.bench, found.search.base
    assert is_noise(bench, base, base)
    monkeypatch.setattr(_Test, part, lambda self: 2.0)
    assert examine(bench, base, base).strain == 2.0
    assert not leaves_noise(bench, base, base)
