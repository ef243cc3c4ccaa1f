"""Simulated runs without the way over files."""

from __future__ import annotations

import torch

from zoo.measurements.run import Run
from zoo.simulator.simulate import Recorded

OUTPUTS = ("rate_dph", "reference_dph")


def as_run(recorded: Recorded, average_s: float = 100.0) -> Run:
    """The run that reading the measurement file would give, as long as a tenth of a block is no more than two rows.

    Args:
        recorded: one simulated run.
        average_s: block length [s].
    """
    table = recorded.table
    inputs = [name for name in table if name not in OUTPUTS]
    time = table["time_s"]
    block = ((time - time[0]) / average_s + 1e-6).long()
    rows = torch.bincount(block)
    # Only the last block can be thin; the reader leaves out what has less than half of its rows.
    full = average_s / float(time[1] - time[0])
    block = torch.where(rows[block] >= 0.5 * full, block, -torch.ones_like(block))
    return Run(
        name=recorded.name,
        unit="dph",
        average_s=average_s,
        columns=(*inputs, "reference_dph"),
        table=torch.stack([table[name] for name in (*inputs, "reference_dph")], dim=1),
        error=table["rate_dph"] - table["reference_dph"],
        count=torch.ones(len(time), dtype=torch.int64),
        block=block,
        rows=len(time),
    )
