"""Two levels in noise: the recursions against all paths there are, levels and times recovered, noise not taken for them."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
import torch
from torch import Generator, Tensor

from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.noise_likelihood import FLICKER_SHARES, WALK_SHARES
from zoo.diagnosis.restless import restless
from zoo.diagnosis.structure import LEVEL_ALLOWED, examine
from zoo.diagnosis.switching import TWO_LEVELS, _both_ways, switching
from zoo.fitting.noise import blocks_of

HALF, DWELL_S = 1.5, 2000.0
"""Half the distance of the levels over the white noise of a block, and how long one lasts."""


def test_the_recursions_are_the_sum_over_all_paths() -> None:
    odds, rate = [0.3, 5.0, 2.0, 0.1, 1.7, 40.0], 0.2
    whole, upper, switches = 0.0, [0.0] * len(odds), 0.0
    for path in itertools.product((0, 1), repeat=len(odds)):
        jumps = sum(one != other for one, other in itertools.pairwise(path))
        weight = 0.5 * rate**jumps * (1 - rate) ** (len(odds) - 1 - jumps) * math.prod(odd for odd, state in zip(odds, path, strict=True) if state)
        whole, switches = whole + weight, switches + weight * jumps
        upper = [before + weight * state for before, state in zip(upper, path, strict=True)]
    found = _both_ways(odds, rate)
    assert found.logarithm == pytest.approx(math.log(whole), rel=1e-12)
    assert found.switches == pytest.approx(switches / whole, rel=1e-12)
    assert found.upper == pytest.approx([one / whole for one in upper], rel=1e-12)


@pytest.fixture
def telegraph(runs, white):
    """Runs with a bias that switches: no line, no band, no function, at no few moments."""

    def plant(seed: int):
        chance, found = Generator().manual_seed(seed), []
        for run in runs("", seed):
            flips = torch.rand(len(run.time), generator=chance, dtype=torch.float64) < torch.diff(run.time).median() / DWELL_S
            found.append(replace(run, error=run.error + HALF * white * (1.0 - 2.0 * (flips.cumsum(0) % 2))))
        return found

    return plant


def test_it_is_weighed_against_the_noise_of_the_greatest_likelihood(runs, catalogue, base, monkeypatch) -> None:
    """Which beside columns that take some of a walk away is not the likeliest, restricted one: two levels would seem better than they are."""
    bench = open_bench(runs(""), base, catalogue)
    solved, mixtures, against = bench.solve(tuple(base)), bench.mixtures, []
    climb = mixtures.most_likely
    monkeypatch.setattr(mixtures, "most_likely", lambda *given, **how: against.append(climb(*given, **how)) or against[-1])
    switching(bench, solved)
    places = itertools.product(range(len(FLICKER_SHARES)), range(len(WALK_SHARES)))
    greatest = max((mixtures.at(place, solved.fit.plain, solved.design.error) for place in places), key=lambda one: one.logarithm)
    assert against[-1].place == greatest.place
    assert greatest.logarithm > climb(solved.fit.plain, solved.design.error).logarithm, "the restricted one is another"


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_a_bias_that_switches_is_no_noise_though_flicker_spreads_as_much(telegraph, catalogue, base, white, seed) -> None:
    bench = open_bench(telegraph(seed), base, catalogue)
    solved = bench.solve(tuple(base))
    found, structure = switching(bench, solved), examine(bench, solved, solved)
    assert structure.excess < LEVEL_ALLOWED, "the likeliest noise accounts for its variance"
    assert not structure.is_noise
    assert found.matters
    assert found.apart == pytest.approx(2 * HALF * white, rel=0.15)
    assert found.dwell_s == pytest.approx(DWELL_S, rel=0.4)
    assert restless(bench, solved).startswith("It comes and goes at random: two levels ")


@pytest.mark.parametrize("flicker", FLICKER_SHARES[1:])
@pytest.mark.parametrize("walk", WALK_SHARES[::2])
def test_no_mixture_of_noise_switches(runs, catalogue, base, white, flicker, walk) -> None:
    """Drawn with the very covariance of the block means, so that nothing but its own two values could tell a telegraph from it."""
    chance, quiet = Generator().manual_seed(3), []
    for run in runs(""):
        blocks = blocks_of([run])[0]
        covariance = (flicker * white) ** 2 * blocks.flicker + (walk * white) ** 2 * blocks.walk
        extra = torch.linalg.cholesky(covariance + 1e-12 * white**2 * torch.eye(run.blocks, dtype=torch.float64)) @ _normal(run.blocks, chance)
        quiet.append(replace(run, error=run.error + extra[run.block.clamp_max(run.blocks - 1)]))
    bench = open_bench(quiet, base, catalogue)
    assert switching(bench, bench.solve(tuple(base))).evidence < 0.5 * TWO_LEVELS


def _normal(count: int, chance: Generator) -> Tensor:
    return torch.randn(count, generator=chance, dtype=torch.float64)
