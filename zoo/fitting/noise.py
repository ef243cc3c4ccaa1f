"""The noise that fits are weighted with, from the runs themselves."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import torch

from zoo.measurements.run import Run
from zoo.scoring.noise import Blocks, NoiseModel, white_level

FLICKER_SHARE = 0.18
"""Flicker assumed, as bias instability over the white noise of one block: 0.002 °/h beside 0.008 °/h (100 s) is typical of a medium gyro."""
AGREEMENT = 0.25
STILL = 0.5
"""Share of the block differences that is looked at: what a ramp drives through fast fringes is left out, as long as half of the time is a hold."""
UNEVEN = 1.35
"""Ratio of the noise of two runs from which each has a level of its own; of three hundred blocks it is known to 8 %."""
RESOLVED = 3e-3
"""Share of the drift below which a residual counts as noise, for no effect's formula is truer than that: a lag for what heat does in a winding."""


def blocks_of(runs: list[Run]) -> list[Blocks]:
    """When the block means of each run were taken; the same object for runs recorded alike, so that their noise is computed once.

    A mean of a run that is noisier than the others is worth as many rows less. Where rows are missing throughout, those of a usual block count as
    all: the level of the noise was read off such blocks.
    """
    found: list[Blocks] = []
    levels, shares = levels_of(runs), [run.block_share() for run in runs]
    usual = [float((torch.cat(shares) if len(set(levels)) == 1 else share).median()) for share in shares]
    for run, level, share, full in zip(runs, levels, shares, usual, strict=True):
        own = Blocks(run.block_mean(run.time), share / (full * level**2))
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


def levels_of(runs: list[Run]) -> list[float]:
    """White noise of each run's block means over that of all, see `noise_of`; 1 for all where they are alike, or where one cannot be told.

    Recorders of other rates, or another set-up, make one run noisier than the next. What the chamber drives through fast fringes does not: a run's
    own level is believed where differences of its fine samples and of its blocks agree on it.
    """
    each = [_level(run) for run in runs] if len(runs) > 1 else [math.nan]
    if not all(level > 0 for level in each) or max(each) < UNEVEN * min(each):
        return [1.0] * len(runs)
    return [level / noise_of(runs).white for level in each]


def floors_of(runs: list[Run], floor: float) -> dict[str, float]:
    """What the noise floor of some runs together [unit] is of each, by name: its share of their noise, see `levels_of`."""
    levels = levels_of(runs)
    mean = math.sqrt(sum(run.blocks * level**2 for run, level in zip(runs, levels, strict=True)) / sum(run.blocks for run in runs))
    return {run.name: floor * level / mean for run, level in zip(runs, levels, strict=True)}


def floor_of(run: Run, gyros: NoiseModel | None = None) -> float:
    """RMS of the block means that complete predictions of a run would leave [unit]: its own white noise, and the gyro's flicker and random walk.

    Args:
        run: one that was not fitted: of a fitted one the fit takes up some of the slow noise.
        gyros: its noise, in other runs' means over as long [unit]; None for white alone.
    """
    white = noise_of([run]).white
    noise = NoiseModel(white, 0.0) if gyros is None else replace(gyros, white=white)
    return float(noise.variance(blocks_of([run])[0]).mean().sqrt())


def of_all(runs: list[Run], floors: Iterable[float]) -> float:
    """The noise floor of some runs together [unit], from that of each."""
    total = sum(run.blocks for run in runs)
    return math.sqrt(sum(run.blocks * floor**2 for run, floor in zip(runs, floors, strict=True)) / total)


def _level(run: Run) -> float:
    """White noise of a run's block means where the two scales agree; NaN where they do not."""
    coarse, fine = white_level([run.block_mean(run.error)], kept=STILL), _fine_level([run])
    return fine if abs(fine - coarse) < AGREEMENT * coarse else math.nan


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
