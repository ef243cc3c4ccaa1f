"""Blocks and samples that no physics explains: a start-up transient, a knocked table."""

from __future__ import annotations

import math

import torch
from torch import Tensor

HALF_WINDOW = 3
WINDOW = 2 * HALF_WINDOW + 1
"""Blocks that count as neighbours, the one in question among them."""
GAUSSIAN_MEDIAN, GAUSSIAN_MEAN = 0.6745, 0.7979
"""Median and mean of the magnitude of Gaussian noise, in standard deviations."""


def spikes(values: Tensor, sigma: float, limit: float = 10.0) -> Tensor:
    """Isolated blocks far from the median of their neighbours.

    A step or an edge that lasts three blocks or longer moves the median with it and is kept.

    Args:
        values: (N,) block means [unit].
        sigma: white noise of one block mean [unit].
        limit: how many sigma, beyond six times the local median deviation, count as far.

    Returns:
        (N,) bool.
    """
    if values.numel() < WINDOW:
        return torch.zeros_like(values, dtype=torch.bool)
    off, spread = off_neighbours(values)
    return off.abs() > limit * sigma + 6.0 * spread


def off_neighbours(values: Tensor) -> tuple[Tensor, Tensor]:
    """(N,) how far each of at least `WINDOW` values is off the median of itself and its neighbours, and (N,) the median deviation of these."""
    edge = values.new_zeros(HALF_WINDOW)
    padded = torch.cat([edge + values[1 : WINDOW + 1].median(), values, edge + values[-WINDOW - 1 : -1].median()])
    windows = padded.unfold(0, WINDOW, 1)
    centre = windows.median(dim=1).values
    return values - centre, (windows - centre.unsqueeze(1)).abs().median(dim=1).values


def scatter(values: Tensor) -> float:
    """White noise of values (N,) one after the other, by how far each is off the mean of the two beside it, whatever a few of them do.

    Of values in coarse steps, most of which are equal, by their mean instead of their median.
    """
    if values.numel() < WINDOW:
        return float("inf")
    off = (values[1:-1] - (values[:-2] + values[2:]) / 2).abs()
    typical = float(off.median()) / GAUSSIAN_MEDIAN or float(off.mean()) / GAUSSIAN_MEAN
    return typical / math.sqrt(1.5)
