"""Thermometers' readings drawn smooth: what they say of the temperature without the scatter and the steps of each reading."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from zoo.measurements.run import Run
from zoo.scoring.noise import white_level

STEPS = (2.0, 4.0, 8.0, 16.0)
"""Time constants that are tried, in steps of the fine grid."""
FEWEST = 32
"""Readings below which there is nothing to choose by."""
OFF = 4.0
"""Standard deviations that the mean of neighbouring readings may be off a curve through them: of thousands, chance puts the farthest at 3.6."""
FINEST = 0.05
"""Quantile of the differences between unlike neighbours that stands for the step of a reading, where readings have steps."""


def steadied(run: Run) -> Run:
    """A run with its thermometers drawn smooth, each as smooth as its readings allow; as it was read where they allow nothing.

    For looking back only: a curve through readings knows what comes after. In flight the readings are all there is, see `zoo.diagnosis.readings`.
    """
    table = run.table.clone()
    for place in map(run.columns.index, run.thermometers):
        table[:, place] = drawn(run.time, run.table[:, place])
    return replace(run, table=table, read=run.table)


def scatter(readings: Tensor) -> float:
    """Standard deviation of single readings (T,) about the temperature [K]: what differences show, and no less than their steps make of it."""
    unlike = torch.diff(readings).abs()
    unlike = unlike[unlike > 0]
    step = float(unlike.quantile(FINEST)) if len(unlike) else 0.0
    level = white_level([readings])  # of too few no number
    return max(level if math.isfinite(level) else 0.0, step / math.sqrt(12.0))


def drawn(time: Tensor, readings: Tensor) -> Tensor:
    """(T,) the smoothest curve through readings that leaves nothing but scatter.

    A cubic smoothing spline, the smoothest of some that no few neighbours lie off together: a kink or a wave that the readings show stays. Of a wave
    of angular frequency ω it leaves 1/(1 + (ωτ)⁴), τ being its time constant (Silverman 1984, Ann. Statist. 12:898).

    Args:
        time: (T,) increasing [s].
        readings: (T,) [K].
    """
    from scipy.interpolate import make_smoothing_spline  # a third of a second, which most commands do not need

    if len(time) < FEWEST:
        return readings
    clock, values = time.cpu().numpy() - float(time[0]), readings.cpu().numpy()
    step, sigma, found = float(np.median(np.diff(clock))), scatter(readings), values
    for steps in STEPS:
        curve = make_smoothing_spline(clock, values, lam=(steps * step) ** 4 / step)(clock)
        neighbours = round(steps)
        means = np.convolve(values - curve, np.full(neighbours, 1.0 / neighbours), mode="valid")
        if np.abs(means).max() * math.sqrt(neighbours) > OFF * sigma:
            break
        found = curve
    return torch.from_numpy(found).to(readings)
