"""Blocks that no physics explains are found; what physics makes is left alone."""

from __future__ import annotations

import pytest
import torch
from torch import Generator, Tensor

from zoo.scoring.spikes import scatter, spikes

SIGMA = 0.01


def noise(seed: int = 1, count: int = 300) -> Tensor:
    return SIGMA * torch.randn(count, generator=Generator().manual_seed(seed), dtype=torch.float64)


@pytest.mark.parametrize("place", [0, 1, 2, 3, 150, 297, 298, 299])
@pytest.mark.parametrize("height", [30.0, -30.0])
def test_a_planted_spike_is_found_and_nothing_else(place, height) -> None:
    values = noise()
    values[place] += height * SIGMA
    assert spikes(values, SIGMA).nonzero().flatten().tolist() == [place]


def test_two_blocks_in_a_row_are_still_a_spike() -> None:
    values = noise()
    values[100:102] += 40 * SIGMA
    assert spikes(values, SIGMA).nonzero().flatten().tolist() == [100, 101]


def test_noise_has_none() -> None:
    assert sum(int(spikes(noise(seed), SIGMA).sum()) for seed in range(200)) == 0


@pytest.mark.parametrize("height", [5.0, 100.0, 1e4])
@pytest.mark.parametrize("place", [4, 150, 295])
def test_a_step_is_left_alone(place, height) -> None:
    values = noise()
    values[place:] += height * SIGMA
    assert int(spikes(values, SIGMA).sum()) == 0


def test_an_edge_of_a_ramp_is_left_alone() -> None:
    """A Shupe spike rises at once and dies within minutes; a warm-up falls from the start."""
    t = torch.arange(300, dtype=torch.float64)
    for edge in ((t >= 100) * torch.exp(-(t - 100) / 4), torch.exp(-t / 4), torch.clamp(t - 150, 0, 20) / 4):
        assert int(spikes(noise() + 30 * SIGMA * edge, SIGMA).sum()) == 0


def test_a_steep_slope_hides_no_spike_and_makes_none() -> None:
    slope = SIGMA * torch.arange(300, dtype=torch.float64)
    assert int(spikes(noise() + slope, SIGMA).sum()) == 0
    values = noise() + slope
    values[200] -= 60 * SIGMA
    assert spikes(values, SIGMA).nonzero().flatten().tolist() == [200]


def test_the_unit_does_not_matter() -> None:
    values = noise()
    values[7] += 1.0
    assert torch.equal(spikes(1e-8 * values, 1e-8 * SIGMA), spikes(values, SIGMA))


def test_too_short_a_run_has_none() -> None:
    assert not bool(spikes(torch.tensor([0.0, 9.0, 0.0, 0.0]), SIGMA).any())


@pytest.mark.parametrize("spoiled", [0, 3, 30])
def test_the_scatter_is_that_of_the_noise_whatever_a_few_values_do(spoiled) -> None:
    values = noise(count=3000) + 5 * SIGMA * torch.sin(torch.arange(3000, dtype=torch.float64) / 200)
    values[:: 3000 // max(spoiled, 1)][:spoiled] += 100 * SIGMA
    assert scatter(values) == pytest.approx(SIGMA, rel=0.06)


def test_the_scatter_of_coarse_steps_is_not_nothing() -> None:
    values = (noise(count=3000) / (4 * SIGMA)).round() * 4 * SIGMA
    assert 0.1 * SIGMA < scatter(values) < 3 * SIGMA
    assert scatter(values[:5]) == float("inf"), "too few to say"
