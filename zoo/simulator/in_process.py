"""Simulated runs without the way over files, for tests and benchmarks.

Blocks are numbered as those of the files are, by the same function. Means agree with those of the files but for the last digits: `Recording` sums
differences from the first row of each, in pieces.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from zoo.measurements.recording import FINE_PER_BLOCK, numbered
from zoo.measurements.run import Run
from zoo.simulator.recorded import Recorded

OUTPUTS = ("rate_dph", "reference_dph")


def as_run(recorded: Recorded, average_s: float = 100.0) -> Run:
    """The run that reading the measurement file would give.

    Args:
        recorded: one simulated run.
        average_s: block length [s], no shorter than the time between rows.
    """
    inputs = [name for name in recorded.table if name not in OUTPUTS]
    time = recorded.table["time_s"]
    since, step = time - time[0], float(time[1] - time[0])
    fine_s = average_s / FINE_PER_BLOCK
    fine = (since / fine_s + 1e-6).long() if fine_s >= 2 * step else torch.arange(len(time))
    count = torch.bincount(fine)
    raw = torch.stack([*(recorded.table[name] for name in (*inputs, *OUTPUTS[::-1]))], dim=1)
    table = torch.zeros(len(count), raw.shape[1], dtype=raw.dtype).index_add(0, fine, raw) / count.unsqueeze(1)
    return Run(
        name=recorded.name,
        unit="dph",
        average_s=average_s,
        columns=(*inputs, "reference_dph"),
        table=table[:, :-1],
        error=table[:, -1] - table[:, -2],
        count=count,
        block=_blocks(since, count, average_s, step),
        rows=len(time),
    )


def _blocks(since: Tensor, count: Tensor, average_s: float, step: float) -> Tensor:
    """(T,) block of each fine sample, see `numbered`."""
    first = since[count.cumsum(0) - count]
    tick = (first / average_s + 1e-6).long()
    return torch.from_numpy(numbered(np.zeros(len(count), np.int64), tick.numpy(), count.numpy(), average_s / step)[0])
