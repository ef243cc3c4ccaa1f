"""Simulated power-ons without the way over files."""

from __future__ import annotations

import torch

from zoo.measurements.run import Run
from zoo.simulator.accelerometer.runs import PowerOnRun

COLUMNS = ("time_s", "temperature_c", "reference_pulses")


def as_run(recorded: PowerOnRun, name: str) -> Run:
    """The run that reading the measurement file as recorded would give: a row a block.

    Args:
        recorded: one power-on.
        name: of the run.
    """
    time = recorded.table["time_s"]
    return Run(
        name=name,
        unit="pulses",
        average_s=float(time[1] - time[0]),
        columns=COLUMNS,
        table=torch.stack([recorded.table[column] for column in COLUMNS], dim=1),
        error=recorded.error,
        count=torch.ones(len(time), dtype=torch.int64),
        block=torch.arange(len(time)),
        rows=len(time),
    )
