"""Checkpoints that a killed training goes on from."""

from __future__ import annotations

import time
from pathlib import Path

from lightning.pytorch import Callback, LightningModule, Trainer

from zoo.artifacts import replacing
from zoo.training.files import CHECKPOINT
from zoo.training.module import Training

EVERY_S = 5.0
"""Time between two checkpoints: what a killed training loses at most, beside one point of the curve. One takes some milliseconds."""


def save_checkpoint(trainer: Trainer, folder: Path) -> None:
    """Write a Lightning checkpoint whole or not at all.

    Args:
        trainer: with its module.
        folder: an existing folder.
    """
    with replacing(folder / CHECKPOINT) as path:
        trainer.save_checkpoint(path)


def save_fitted(module: Training, folder: Path) -> None:
    """A Lightning checkpoint of a module that no trainer has trained."""
    trainer = Trainer(accelerator="cpu", logger=False, enable_checkpointing=False, enable_model_summary=False, enable_progress_bar=False)
    trainer.strategy.connect(module)
    save_checkpoint(trainer, folder)


class Checkpoints(Callback):
    """Now and then one on the way; Lightning's own callback looks at the clock after every step, which small nets notice."""

    def __init__(self, folder: Path, every: int) -> None:
        """Remember.

        Args:
            folder: an existing folder.
            every: steps between two looks at the clock.
        """
        self.folder, self.every = folder, every
        self.last_s = time.monotonic()

    def on_train_batch_end(self, trainer: Trainer, pl_module: LightningModule, outputs: object, batch: object, batch_idx: int) -> None:
        """Save where it is time."""
        # Not after the last step: there the training's own end follows at once, and a checkpoint without it would leave nothing to go on with.
        due = trainer.global_step % self.every == 0 and trainer.global_step < trainer.max_steps
        if due and time.monotonic() - self.last_s > EVERY_S:
            save_checkpoint(trainer, self.folder)
            self.last_s = time.monotonic()
