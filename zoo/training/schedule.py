"""How long a training takes, where, and from what it goes on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

POINTS = 100
"""Points of the loss curve."""


@dataclass(frozen=True)
class Schedule:
    """How long and where to train.

    Attributes:
        epochs: passes over the fitted runs.
        goal: training stops once the loss is below.
        device: ``"cpu"``, ``"cuda"`` or ``"cuda:1"``.
        batch_size: blocks a step; None for all at once.
        resume: checkpoint to go on from.
        settings: all that decides the training, for the checkpoints.
    """

    epochs: int
    goal: float | None = None
    device: str = "cpu"
    batch_size: int | None = None
    resume: Path | None = None
    settings: str = ""
