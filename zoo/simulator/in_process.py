"""Simulated runs without the way over files."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.measurements.recording import FINE_PER_BLOCK
from zoo.measurements.run import Run
from zoo.simulator.recorded import Recorded

OUTPUTS = ("rate_dph", "reference_dph")


def as_run(recorded: Recorded, average_s: float = 100.0) -> Run:
    """The run that reading the measurement file would give.

    Args:
        recorded: one simulated run.
        average_s: block length [s].
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
        block=_blocks(since, fine, count, average_s, step),
        rows=len(time),
    )


def _blocks(since: Tensor, fine: Tensor, count: Tensor, average_s: float, step: float) -> Tensor:
    """(T,) block of each fine sample, −1 for the last one where it has less than half of its rows."""
    first = torch.zeros(len(count), dtype=since.dtype).scatter_reduce(0, fine, since, "amin", include_self=False)
    block = (first / average_s + 1e-6).long()
    rows = torch.zeros(int(block[-1]) + 1, dtype=count.dtype).index_add(0, block, count)
    return torch.where(rows[block] >= 0.5 * average_s / step, block, -1)
