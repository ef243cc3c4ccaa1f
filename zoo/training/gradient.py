"""Training by gradient through Lightning, tuned for nets whose step takes a fraction of a millisecond."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from lightning.pytorch import Callback, Trainer
from lightning.pytorch.loggers import Logger

from zoo.errors import WorkError
from zoo.measurements.datamodule import RunsDataModule
from zoo.models.base import FeatureModel
from zoo.training.module import MakeOptimizer, Training
from zoo.training.progress import TrainingProgress
from zoo.training.resume import check_resumable

CHECKPOINT = "last.ckpt"
PASSES_PER_EPOCH = 50
"""Passes over the data in what Lightning calls an epoch, whose price is many times a small net's step."""
POINTS = 100
"""Points of the loss curve."""


@dataclass(frozen=True)
class Schedule:
    """How long and where to train.

    Attributes:
        epochs: passes over the fitted runs.
        goal: training stops once the loss is below.
        device: ``"cpu"``, ``"cuda"`` or ``"cuda:1"``.
        resume: checkpoint to go on from.
    """

    epochs: int
    goal: float | None = None
    device: str = "cpu"
    resume: Path | None = None


def fit_by_gradient(
    model: FeatureModel, data: RunsDataModule, optimizer: MakeOptimizer, init: Callback, schedule: Schedule, out: Path, logger: Logger
) -> dict[str, Any]:
    """Standardise, initialise, train, and leave a checkpoint.

    Args:
        model: trained in place.
        data: its features.
        optimizer: makes the optimizer from the parameters.
        init: draws the initial weights as training starts.
        schedule: how long and where.
        out: an existing folder, for the checkpoint.
        logger: takes the curves.

    Returns:
        Passes done, evaluations of the model, and the last loss.

    Raises:
        InputError: the checkpoint to go on from does not fit.
        WorkError: the training diverged.
    """
    features, error = data.fitted
    model.standardise(features, error)
    steps_per_pass = data.train_dataloader().batches_per_pass
    steps = schedule.epochs * steps_per_pass
    every = max(steps // POINTS, 1)
    spread = float(error.std(correction=0)) or 1.0
    module = Training(model, optimizer, error_scale=spread, goal=schedule.goal, log_every=every)
    if schedule.resume is not None:
        check_resumable(schedule.resume, module, steps)
    trainer = _trainer(steps, every, schedule.device, [init, TrainingProgress(steps, every)], logger)
    with _interruptible():
        trainer.fit(module, datamodule=data, ckpt_path=schedule.resume, weights_only=True)
    loss = _final_loss(module, data)
    if not math.isfinite(loss):
        raise WorkError(f"training diverged: the loss is {loss} after {trainer.global_step} steps; try a smaller optimizer.lr")
    trainer.save_checkpoint(out / CHECKPOINT)
    evaluations = module.evaluations + getattr(init, "evaluations", 0)
    return {"epochs": trainer.global_step // steps_per_pass, "evaluations": evaluations, "loss": loss}


@contextmanager
def _interruptible() -> Iterator[None]:
    """Ctrl-C as everywhere else; Lightning makes it an exit with code 1, without a word."""
    try:
        yield
    except SystemExit as stop:
        if not isinstance(stop.__context__, KeyboardInterrupt):
            raise
        raise KeyboardInterrupt from stop


def _trainer(steps: int, every: int, device: str, callbacks: list[Callback], logger: Logger) -> Trainer:
    on_gpu = device.startswith("cuda")
    return Trainer(
        accelerator="gpu" if on_gpu else "cpu",
        devices=[int(device.partition(":")[2] or 0)] if on_gpu else 1,
        max_steps=steps,
        max_epochs=-1,
        logger=logger,
        callbacks=callbacks,
        log_every_n_steps=every,
        # Each of these costs more than a step of a net with a few dozen weights.
        enable_progress_bar=False,
        enable_model_summary=False,
        enable_checkpointing=False,
        num_sanity_val_steps=0,
        use_distributed_sampler=False,
    )


def _final_loss(module: Training, data: RunsDataModule) -> float:
    features, error = data.fitted
    with torch.no_grad():
        return float(module.loss(module(features.to(module.device)), error.to(module.device)))


def save_unfitted_by_gradient(model: torch.nn.Module, out: Path) -> None:
    """A Lightning checkpoint of a model that was fitted in another way."""
    trainer = Trainer(accelerator="cpu", logger=False, enable_checkpointing=False, enable_model_summary=False, enable_progress_bar=False)
    trainer.strategy.connect(Training(model))  # type: ignore[arg-type]
    trainer.save_checkpoint(out / CHECKPOINT)
