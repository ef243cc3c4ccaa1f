"""The likeliest noise of what is left."""

from __future__ import annotations

import math
import statistics

import pytest
import torch

from zoo.diagnosis.noise_likelihood import (
    FACTOR,
    FLICKER_SHARES,
    LEVEL_SPREAD,
    LEVELS,
    TYPICAL_FLICKER,
    TYPICAL_WALK,
    WALK_SHARES,
    Likelihood,
    NoiseMixtures,
    gain,
    held_cost,
)
from zoo.fitting.projection import project
from zoo.measurements.run import Run
from zoo.scoring.noise import NoiseModel

WHITE, WALK, BLOCKS, DRAWS = 0.01, 0.5, 400, 40


def hours(blocks: int, length: float = 600.0) -> Run:
    """A run of so many blocks of which nothing but the time matters."""
    time = length * (0.5 + torch.arange(blocks, dtype=torch.float64))
    table = torch.stack([time, 20 + 0 * time, 0 * time], dim=-1)
    ones = torch.ones(blocks, dtype=torch.int64)
    return Run("run", "dph", length, ("time_s", "temperature_c", "reference_dph"), table, 0 * time, ones, torch.arange(blocks))


def drawn(covariance: torch.Tensor) -> list[torch.Tensor]:
    """Some draws of a noise."""
    root, chance = torch.linalg.cholesky(covariance), torch.Generator().manual_seed(1)
    return [root @ torch.randn(len(root), generator=chance, dtype=torch.float64) for _ in range(DRAWS)]


@pytest.mark.slow
def test_slow_columns_hide_the_walk_from_the_likelihood_and_less_from_the_restricted_one() -> None:
    """Eight powers of time take most of a random walk away; the likelihood of what is left sees next to none, the restricted one more than half."""
    mixtures = NoiseMixtures([hours(BLOCKS)], WHITE)
    powers = torch.linspace(-1, 1, BLOCKS, dtype=torch.float64).unsqueeze(1) ** torch.arange(9)
    every = drawn(NoiseModel(WHITE, 0.18 * WHITE, WALK * WHITE).covariance(mixtures.runs[0]))
    plain = statistics.mean(mixtures.most_likely(powers, one, plain=True).noise.walk for one in every) / WHITE
    restricted = statistics.mean(mixtures.most_likely(powers, one).noise.walk for one in every) / WHITE
    assert plain < 0.1 * WALK
    assert 0.5 * WALK < restricted < 1.2 * WALK


@pytest.mark.parametrize("width", [15, 30])
def test_many_columns_make_what_is_left_quieter_and_that_is_reckoned_with(width) -> None:
    """K of N columns take K/N of the variance of white noise; the restricted likelihood knows of N − K."""
    mixtures = NoiseMixtures([hours(120, 100.0)], WHITE)
    columns = torch.randn(120, width, generator=torch.Generator().manual_seed(2), dtype=torch.float64)
    every = drawn(NoiseModel(WHITE, 0.18 * WHITE, 0.1 * WHITE).covariance(mixtures.runs[0]))
    restricted = statistics.mean(mixtures.most_likely(columns, one).noise.white for one in every)
    assert restricted == pytest.approx(WHITE, rel=0.01)
    assert statistics.mean(float(project(columns, one).residual.std()) for one in every) < restricted - 0.02 * WHITE


@pytest.mark.parametrize("unit", [1.0, 1e-9, 1e9])
def test_what_the_columns_reach_makes_no_difference(unit) -> None:
    """Nor do their mixtures, but for a constant, nor the unit of the output; and one column twice is still a column."""
    white = unit * WHITE
    mixtures = NoiseMixtures([hours(BLOCKS)], white)
    chance = torch.Generator().manual_seed(2)
    columns = torch.randn(BLOCKS, 4, generator=chance, dtype=torch.float64).cumsum(0)
    target = torch.randn(BLOCKS, generator=chance, dtype=torch.float64)
    weights = torch.randn(4, generator=chance, dtype=torch.float64)
    mixed = columns @ torch.randn(4, 4, generator=chance, dtype=torch.float64)
    cases = ((columns, 0.0), (columns, columns @ weights), (mixed, 0.0), (torch.cat([columns, columns[:, :1]], dim=1), 0.0))
    one, moved, other, twice = (mixtures.most_likely(unit * made, white * target + unit * more) for made, more in cases)
    assert one.place == moved.place == other.place == twice.place
    assert moved.restricted == pytest.approx(one.restricted, abs=1e-5)
    assert other.noise == one.noise
    assert abs(one.restricted - one.logarithm) > 1.0


def test_the_restricted_likelihood_is_that_of_what_no_column_reaches() -> None:
    """Written out: of the target's part outside them, under the covariance there, but for a constant; the other of the whole residual."""
    mixtures = NoiseMixtures([hours(60)], WHITE)
    chance = torch.Generator().manual_seed(3)
    columns = torch.randn(60, 3, generator=chance, dtype=torch.float64).cumsum(0)
    target = WHITE * torch.randn(60, generator=chance, dtype=torch.float64)
    outside = torch.linalg.qr(columns, mode="complete").Q[:, 3:]

    def written_out(place: tuple[int, int]) -> tuple[float, float]:
        """Both, each at the level that suits it best."""
        shares = FLICKER_SHARES[place[0]] / TYPICAL_FLICKER, WALK_SHARES[place[1]] / TYPICAL_WALK
        before = -0.5 * sum((math.log(share) / math.log(FACTOR)) ** 2 for share in shares)
        covariance = mixtures.whitener(place)[0].covariance(mixtures.runs[0])
        white = torch.linalg.inv(torch.linalg.cholesky(covariance))
        residual = torch.linalg.inv(white) @ project(white @ columns, white @ target).residual
        levels = [(level**2, -0.5 * (math.log(level) / LEVEL_SPREAD) ** 2) for level in LEVELS]
        plain = max(normal(residual, square * covariance) + known for square, known in levels)
        restricted = max(normal(outside.mT @ target, square * outside.mT @ covariance @ outside) + known for square, known in levels)
        return before + plain, before + restricted

    found, expected = ([one(place) for place in ((1, 1), (3, 4))] for one in (lambda place: mixtures.at(place, columns, target), written_out))
    for name, (before, after) in zip(("logarithm", "restricted"), zip(*expected, strict=True), strict=True):
        assert getattr(found[1], name) - getattr(found[0], name) == pytest.approx(after - before, abs=1e-6)


def normal(drawn: torch.Tensor, covariance: torch.Tensor) -> float:
    """Log density of a normal vector (N,) of this covariance and no mean."""
    return float(torch.distributions.MultivariateNormal(torch.zeros_like(drawn), covariance).log_prob(drawn))


def test_a_step_from_one_mixture_to_the_next_is_no_evidence() -> None:
    """More columns never fit worse under the same noise; each under its own, they may seem to, or to gain by the other's loss."""
    mixtures = NoiseMixtures([hours(BLOCKS)], WHITE)
    powers = torch.linspace(-1, 1, BLOCKS, dtype=torch.float64).unsqueeze(1) ** torch.arange(9)
    walks, apart = drawn(NoiseModel(WHITE, 0.18 * WHITE, WALK * WHITE).covariance(mixtures.runs[0])), []
    for target in walks:
        less, more = (Likelihood(mixtures, powers[:, :count], target) for count in (4, 9))
        gained, own = gain(less, more), more.likely.logarithm - less.likely.logarithm
        assert gained >= 0
        assert gained == -gain(more, less)
        assert gain(less, less) == 0
        each = [more.under(place).logarithm - less.under(place).logarithm for place in (less.likely.place, more.likely.place)]
        assert min(each) <= gained <= max(each), "between what it is under the one and under the other"
        apart.append(abs(gained - own))
    assert max(apart) > 1.0


def test_rows_that_hold_columns_back_are_a_prior_of_their_amplitudes() -> None:
    """The χ² is that of the posterior's mode, less what the prior charges for no move; further columns have no rows; loose rows change nothing."""
    chance = torch.Generator().manual_seed(5)
    white, (center, weight) = torch.randn(60, 5, generator=chance, dtype=torch.float64), (0.7, 9.0)
    held = torch.tensor([[0.0, weight**0.5, weight**0.5 * center]], dtype=torch.float64)  # of the second column; two more came later
    normal = white[:, :-1].mT @ white[:, :-1]
    normal[1, 1] += weight
    right = white[:, :-1].mT @ white[:, -1]
    right[1] += weight * center
    mode = torch.linalg.solve(normal, right)
    least = float((white[:, -1] - white[:, :-1] @ mode).square().sum()) + weight * float(mode[1] - center) ** 2 - weight * center**2
    assert held_cost(white, held) == pytest.approx(least, rel=1e-10)
    assert held_cost(white, 1e-9 * held) == pytest.approx(held_cost(white), rel=1e-10)
    without = white[:, [0, 2, 3, 4]]
    assert held_cost(white, torch.tensor([[0.0, 1e6, 0.0]], dtype=torch.float64)) == pytest.approx(held_cost(without), rel=1e-8)
