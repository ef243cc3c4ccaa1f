"""The likeliest noise of what is left."""

from __future__ import annotations

import math
import statistics

import pytest
import torch

from zoo.diagnosis.noise_likelihood import NoiseMixtures
from zoo.measurements.run import Run
from zoo.scoring.noise import NoiseModel

WHITE, WALK, BLOCKS, DRAWS = 0.01, 0.8, 240, 40


def hours(blocks: int, length: float = 100.0) -> Run:
    """A run of so many blocks of which nothing but the time matters."""
    time = length * (0.5 + torch.arange(blocks, dtype=torch.float64))
    table = torch.stack([time, 20 + 0 * time, 0 * time], dim=-1)
    ones = torch.ones(blocks, dtype=torch.int64)
    return Run("run", "dph", length, ("time_s", "temperature_c", "reference_dph"), table, 0 * time, ones, torch.arange(blocks))


@pytest.mark.slow
def test_slow_columns_hide_the_walk_from_the_likelihood_and_not_from_the_restricted_one() -> None:
    """Eight powers of time take most of a random walk away; what is left looks quieter than it was, unless that is reckoned with."""
    mixtures = NoiseMixtures([hours(BLOCKS)], WHITE)
    covariance = NoiseModel(WHITE, 0.18 * WHITE, WALK * WHITE).covariance(mixtures.runs[0])
    root, chance = torch.linalg.cholesky(covariance), torch.Generator().manual_seed(1)
    powers = torch.linspace(-1, 1, BLOCKS, dtype=torch.float64).unsqueeze(1) ** torch.arange(9)
    plain, restricted = [], []
    for _ in range(DRAWS):
        target = root @ torch.randn(BLOCKS, generator=chance, dtype=torch.float64)
        plain.append(mixtures.most_likely(powers, target).noise.walk / WHITE)
        restricted.append(mixtures.most_likely(powers, target, restricted=True).noise.walk / WHITE)
    assert all(more >= less for more, less in zip(restricted, plain, strict=True))
    assert statistics.mean(plain) < statistics.mean(restricted) - 2 * statistics.stdev(restricted) / math.sqrt(DRAWS)
    assert abs(statistics.mean(restricted) - WALK) < abs(statistics.mean(plain) - WALK)


def test_what_the_columns_reach_makes_no_difference() -> None:
    """Nor does a likelihood of either kind change when the columns are mixed among each other, but for a constant."""
    mixtures = NoiseMixtures([hours(BLOCKS)], WHITE)
    chance = torch.Generator().manual_seed(2)
    columns, target = (torch.randn(BLOCKS, size, generator=chance, dtype=torch.float64) for size in (4, 1))
    weights = torch.randn(4, generator=chance, dtype=torch.float64)
    mixed = columns @ torch.randn(4, 4, generator=chance, dtype=torch.float64)
    for restricted in (False, True):
        one, moved, other = (
            mixtures.most_likely(made, WHITE * target[:, 0] + more, restricted=restricted)
            for made, more in ((columns, 0.0), (columns, columns @ weights), (mixed, 0.0))
        )
        assert one.place == moved.place == other.place
        assert moved.logarithm == pytest.approx(one.logarithm, abs=1e-6)
        assert other.noise == one.noise
