"""Stages as a paper's table cuts them: where the thermometer moves and where it does not, with nothing between."""

from __future__ import annotations

from itertools import pairwise

import torch
from torch import Tensor

from zoo.scoring.stages import local_rate

WINDOW_S = 600.0
"""Width over which the rate is taken, and the shortest stage but the first [s]."""


def rate_windows(time: Tensor, temperature: Tensor, still_k_per_min: float) -> list[slice]:
    """Consecutive stages, each a hold (below the limit) or a movement (above it), that cover all blocks.

    What is shorter than ten minutes, from the centre of its first block to that of its last, belongs to the stage before it, where there is one.

    Args:
        time: (N,) block centres, increasing [s].
        temperature: (N,) block means [°C].
        still_k_per_min: rate below which the thermometer counts as still.

    Returns:
        The blocks of each stage in time order.
    """
    moves = local_rate(time, temperature, WINDOW_S).abs() >= still_k_per_min
    cuts = [0, *(torch.nonzero(moves[1:] != moves[:-1]).flatten() + 1).tolist(), len(moves)]
    kept: list[tuple[int, bool]] = []
    for start, end in pairwise(cuts):
        long_enough = float(time[end - 1] - time[start]) >= WINDOW_S
        if not kept or (long_enough and bool(moves[start]) != kept[-1][1]):
            kept.append((start, bool(moves[start])))
    return [slice(a, b) for a, b in pairwise([*(start for start, _ in kept), len(moves)])]
