"""A made-up run within what a model was fitted to, to try an exported file on where no recording is at hand."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Generator, Tensor

from zoo.models.ranges import Ranges

ROWS = 5000
INTERVAL_S = 10.0
WAVES_S = (1200.0, 5400.0, 19000.0)
"""Periods of what every column does at once, as fast as a fan and as slow as a chamber. Engineering prior."""
UNKNOWN = (15.0, 35.0)
"""Range of a column that the model was saved without. Engineering prior."""


def rehearsal(inputs: Sequence[str], ranges: Ranges, generator: Generator, rows: int = ROWS) -> Tensor:
    """A run with uneven steps whose columns move within their ranges.

    Args:
        inputs: names of the raw columns, the time first.
        ranges: of them.
        generator: draws steps and phases.
        rows: how many.

    Returns:
        (rows, C).
    """
    steps = INTERVAL_S * (0.5 + torch.rand(rows, generator=generator, dtype=torch.float64))
    columns = [steps.cumsum(0)]
    for name in inputs[1:]:
        low, high = ranges.get(name, UNKNOWN)
        phase = 2 * math.pi * torch.rand(len(WAVES_S), generator=generator, dtype=torch.float64)
        angle = 2 * math.pi * columns[0].unsqueeze(-1) / torch.tensor(WAVES_S, dtype=torch.float64) + phase
        columns.append(low + (high - low) * (0.5 + 0.5 * torch.sin(angle).mean(-1)))
    return torch.stack(columns, dim=-1)
