"""The noise that fits are weighted with, from the runs themselves."""

from __future__ import annotations

import math

import torch

from zoo.measurements.run import Run
from zoo.scoring.noise import Blocks, NoiseModel, white_level

FLICKER_SHARE = 0.18
"""Flicker assumed, as bias instability over the white noise of one block: 0.002 °/h beside 0.008 °/h (100 s) is typical of a medium gyro."""
AGREEMENT = 0.25


def blocks_of(runs: list[Run]) -> list[Blocks]:
    """When the block means of each run were taken."""
    return [Blocks(run.block_mean(run.time), run.block_share()) for run in runs]


def noise_of(runs: list[Run]) -> NoiseModel:
    """White noise of one block mean from differences, and the flicker that goes with it.

    Differences of the fine samples, scaled to a block, are ten times as many; they are believed where they agree with those of the blocks within 25
    %, which tells that the noise between the two scales is white.
    """
    coarse = white_level([run.block_mean(run.error) for run in runs])
    fine = _fine_level(runs)
    white = fine if math.isfinite(fine) and abs(fine / coarse - 1.0) < AGREEMENT else coarse
    if not white > 0:
        span = max(float(run.error.abs().max()) for run in runs)
        white = max(1e-9 * span, 1e-15)  # noiseless data, as from noise=none: keep the arithmetic finite
    return NoiseModel(white, FLICKER_SHARE * white)


def _fine_level(runs: list[Run]) -> float:
    sigma = white_level([run.error for run in runs])
    per_block = torch.cat([torch.bincount(run.block[run.block >= 0]).double() for run in runs]).median()
    return sigma / math.sqrt(float(per_block))
