"""The progress bar of a training, at no cost per step."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

from lightning.pytorch import Callback, LightningModule, Trainer

from zoo.progress import progress


class TrainingProgress(Callback):
    """The bar during training, moved once in `every` steps."""

    def __init__(self, total: int, every: int) -> None:
        self.total, self.every = total, every
        self._bar: AbstractContextManager[Callable[..., None]] | None = None

    def on_train_start(self, trainer: Trainer, pl_module: LightningModule) -> None:
        """Open the bar."""
        self._bar = progress("training", self.total - trainer.global_step)
        self._advance = self._bar.__enter__()

    def on_train_batch_end(self, trainer: Trainer, pl_module: LightningModule, outputs: object, batch: object, batch_idx: int) -> None:
        """Move it now and then."""
        if trainer.global_step % self.every == 0:
            self._advance(self.every)

    def teardown(self, trainer: Trainer, pl_module: LightningModule, stage: str) -> None:
        """Close it, also after a failure."""
        if self._bar is not None:
            self._bar.__exit__(None, None, None)
            self._bar = None
