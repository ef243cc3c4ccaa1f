"""Blocks that no physics explains: a start-up transient, a knocked table."""

from __future__ import annotations

import torch
from torch import Tensor

HALF_WINDOW = 3


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
    size = 2 * HALF_WINDOW + 1
    if values.numel() < size:
        return torch.zeros_like(values, dtype=torch.bool)
    edge = values.new_full((HALF_WINDOW,), 0.0)
    padded = torch.cat([edge + values[1 : size + 1].median(), values, edge + values[-size - 1 : -1].median()])
    windows = padded.unfold(0, size, 1)
    centre = windows.median(dim=1).values
    spread = (windows - centre.unsqueeze(1)).abs().median(dim=1).values
    return (values - centre).abs() > limit * sigma + 6.0 * spread
