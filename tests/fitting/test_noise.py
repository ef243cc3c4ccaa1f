"""The noise of the runs themselves."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch

from zoo.fitting.noise import blocks_of, levels_of, noise_of
from zoo.measurements.run import Run

FINE, BLOCKS, WHITE = 5, 400, 0.01


def recorded(level: float, seed: int, wave: float = 0.0) -> Run:
    """White noise of this level in block means of 100 s, over a slow drift, and perhaps a wave of 250 s."""
    chance, count = torch.Generator().manual_seed(seed), FINE * BLOCKS
    time = 20.0 * (torch.arange(count, dtype=torch.float64) + 0.5)
    noise = level * WHITE * math.sqrt(FINE) * torch.randn(count, generator=chance, dtype=torch.float64)
    return Run(
        name=f"run_{seed}",
        unit="dph",
        average_s=100.0,
        columns=("temperature_c", "reference_dph"),
        table=torch.stack([20.0 + 30.0 * torch.sin(time / 6000.0), 0.0 * time], dim=1),
        error=noise + 0.1 * torch.sin(time / 5000.0) + wave * WHITE * torch.sin(2 * torch.pi * time / 250.0),
        count=torch.ones(count, dtype=torch.float64),
        block=torch.arange(count) // FINE,
        rows=count,
        notes=(),
    )


@pytest.mark.parametrize("ratio", [1.6, 2.0, 4.0])
def test_a_noisier_run_has_a_level_of_its_own(ratio) -> None:
    runs = [recorded(1.0, 1), recorded(ratio, 2), recorded(1.0, 3)]
    first, second, third = levels_of(runs)
    assert second / first == pytest.approx(ratio, rel=0.12)
    assert third / first == pytest.approx(1.0, rel=0.12)
    variances = [blocks.white.mean() for blocks in blocks_of(runs)]
    assert float(variances[1] / variances[0]) == pytest.approx((second / first) ** 2, rel=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_runs_that_are_alike_share_one_level_and_their_noise_is_computed_once(seed) -> None:
    runs = [recorded(1.0, 10 * seed + i) for i in range(3)]
    assert levels_of(runs) == [1.0, 1.0, 1.0]
    assert len({id(blocks) for blocks in blocks_of(runs)}) == 1


def test_what_is_fast_in_one_run_is_not_taken_for_its_noise() -> None:
    """A wave of two and a half blocks is seen by differences of blocks and hardly by those of samples."""
    assert levels_of([recorded(1.0, 1), recorded(1.0, 2, wave=4.0)]) == [1.0, 1.0]


def test_a_run_by_itself_and_runs_without_noise_have_level_one() -> None:
    assert levels_of([recorded(3.0, 1)]) == [1.0]
    assert levels_of([recorded(0.0, 1), recorded(1.0, 2)]) == [1.0, 1.0]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("kept", [0.6, 0.85, 1.0])
def test_the_covariance_is_that_of_the_means_also_where_rows_are_missing(seed, kept) -> None:
    """White noise whose rows are lost at random: what the model says of the blocks' variance is what it is."""
    run, chance = recorded(1.0, seed), torch.Generator().manual_seed(seed)
    rows = torch.binomial(torch.full((FINE * BLOCKS,), 10.0, dtype=torch.float64), torch.tensor(kept, dtype=torch.float64), generator=chance)
    keep = rows > 0
    noise = WHITE * math.sqrt(FINE) * torch.randn(len(rows), generator=chance, dtype=torch.float64) / (rows / 10).sqrt()
    thin = replace(run, error=noise[keep], count=rows[keep], table=run.table[keep], block=run.block[keep])
    noise_model, (blocks,) = noise_of([thin]), blocks_of([thin])
    said = float(noise_model.white**2 * blocks.white.mean())
    assert said == pytest.approx(WHITE**2 / kept, rel=0.25)
    assert float(blocks.share.median()) == 1.0
