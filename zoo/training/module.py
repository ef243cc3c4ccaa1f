"""The LightningModule around a model of the zoo: the loss and nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import torch
from lightning.pytorch import LightningModule
from torch import Tensor, nn

from zoo.errors import WorkError
from zoo.models.base import FeatureModel, Model

MakeOptimizer = Callable[[Iterable[nn.Parameter]], torch.optim.Optimizer]
Batch = tuple[Tensor, Tensor]
OPTIMIZER = "optimizer_name"
"""Key under which a checkpoint names the optimizer whose state it holds."""


class Training(LightningModule):
    """Mean squared error in units of the training data's spread.

    Model and optimizer stay out of the saved hyperparameters, since torch's weights-only loading refuses objects; give them again on reloading:
    ``Training.load_from_checkpoint(path, model=…, optimizer=…)``.
    """

    def __init__(
        self, model: Model, optimizer: MakeOptimizer | None = None, error_scale: float = 1.0, goal: float | None = None, log_every: int = 50
    ) -> None:
        """Wrap a model.

        Args:
            model: what is trained.
            optimizer: makes the optimizer from the parameters; None for models that are fitted in other ways and only saved through Lightning.
            error_scale: unit of the loss [output's unit].
            goal: training stops once the loss is below.
            log_every: steps between two points of the loss curve.
        """
        super().__init__()
        self.save_hyperparameters(ignore=["model", "optimizer"])
        self.model = model
        self.make_optimizer = optimizer
        self.error_scale, self.goal, self.log_every = error_scale, goal, log_every
        self.evaluations = 0
        self.latest: Tensor | None = None

    def forward(self, features: Tensor) -> Tensor:
        """(M, F) features -> (M,) predicted error [output's unit]."""
        assert isinstance(self.model, FeatureModel)
        return self.model.head(features)

    def loss(self, predicted: Tensor, error: Tensor) -> Tensor:
        """(..., M) predicted and (M,) true error -> (...) mean squared error, dimensionless."""
        return ((predicted - error) / self.error_scale).square().mean(-1)

    def training_step(self, batch: Batch, index: int) -> Tensor:
        """One evaluation of the loss; L-BFGS asks several times a step."""
        loss = self.loss(self(batch[0]), batch[1])
        self.evaluations += 1
        self.latest = loss.detach()
        return loss

    def on_train_batch_end(self, outputs: object, batch: Batch, batch_idx: int) -> None:
        """Log now and then; stop at the goal, or where the loss is no number any more."""
        step = self.trainer.global_step
        if step % self.log_every == 0 or step == 1:
            loss = float(self.latest)  # type: ignore[arg-type]
            if self.logger:
                self.logger.log_metrics({"loss/fit": loss}, step)
            if not math.isfinite(loss):
                raise WorkError(f"training diverged: the loss is {loss} after {step} steps; try a smaller optimizer.lr")
        if self.goal is not None and float(self.latest) < self.goal:  # type: ignore[arg-type]
            self.trainer.should_stop = True

    def validation_step(self, batch: Batch, index: int) -> None:
        """The loss of the runs to check on."""
        self.log("loss/check", self.loss(self(batch[0]), batch[1]), batch_size=len(batch[1]))

    @property
    def optimizer_name(self) -> str | None:
        """Class of the optimizer; None for a model that is fitted in other ways."""
        return None if self.make_optimizer is None else type(self.configure_optimizers()).__name__

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Says whose state the checkpoint holds, since one optimizer's state means nothing to another."""
        checkpoint[OPTIMIZER] = self.optimizer_name

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """The optimizer chosen."""
        assert self.make_optimizer is not None
        return self.make_optimizer(self.parameters())
