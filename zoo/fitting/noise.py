"""The noise that fits are weighted with, from the runs themselves."""

from __future__ import annotations

import math

import torch

from zoo.measurements.run import Run
from zoo.scoring.noise import Blocks, NoiseModel, white_level

FLICKER_SHARE = 0.18
"""Flicker assumed, as bias instability over the white noise of one block: 0.002 °/h beside 0.008 °/h (100 s) is typical of a medium gyro."""
AGREEMENT = 0.25
STILL = 0.5
"""Share of the block differences that is looked at: what a ramp drives through fast fringes is left out, as long as half of the time is a hold."""
RESOLVED = 3e-3
"""Share of the drift below which a residual counts as noise, for no effect's formula is truer than that: a lag for what heat does in a winding."""


def blocks_of(runs: list[Run]) -> list[Blocks]:
    """When the block means of each run were taken; the same object for runs recorded alike, so that their noise is computed once."""
    found: list[Blocks] = []
    for run in runs:
        own = Blocks(run.block_mean(run.time), run.block_share())
        found.append(next((other for other in found if own.same(other)), own))
    return found


def noise_of(runs: list[Run]) -> NoiseModel:
    """White noise of one block mean from the quieter half of its differences, and the flicker that goes with it.

    Differences of the fine samples, scaled to a block, are ten times as many; they are believed where they agree with those of the blocks within 25
    %, which tells that the noise between the two scales is white.
    """
    blocks = [run.block_mean(run.error) for run in runs]
    coarse = white_level(blocks, kept=STILL)
    fine = _fine_level(runs)
    white = fine if math.isfinite(fine) and abs(fine - coarse) < AGREEMENT * coarse else coarse
    return assumed(white, runs)


def assumed(white: float, runs: list[Run]) -> NoiseModel:
    """White noise of this RMS [unit], or of the least that matters beside the runs' drift, and the flicker that usually goes with it."""
    errors = torch.cat([run.block_mean(run.error) for run in runs])
    least = max(RESOLVED * float((errors - errors.mean()).square().mean().sqrt()), 1e-15)
    white = white if white > least else least
    return NoiseModel(white, FLICKER_SHARE * white)


def _fine_level(runs: list[Run]) -> float:
    sigma = white_level([run.error for run in runs])
    per_block = torch.cat([torch.bincount(run.block[run.block >= 0]).double() for run in runs]).median()
    return sigma / math.sqrt(float(per_block))
