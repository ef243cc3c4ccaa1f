"""Trains one model on some runs and scores it on these and others."""

from __future__ import annotations

import platform
import shutil
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Protocol, cast

import lightning
import torch
from lightning.pytorch import Callback
from lightning.pytorch.loggers import TensorBoardLogger
from torch import Generator

import zoo
from zoo.errors import InputError
from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.prediction import block_features, usable_device
from zoo.training.gradient import PASSES_PER_EPOCH, Schedule, fit_by_gradient, save_unfitted_by_gradient
from zoo.training.module import MakeOptimizer
from zoo.training.quiet import quiet_lightning
from zoo.training.scores import score_runs
from zoo.training.threads import threads_for
from zoo.training.weights import RandomInit, weight_vector

EVENTS = "tensorboard"
WIDTH = 32
"""Numbers that a block makes in a small net's largest tensor, to judge how many threads are worth it."""


class Fitter(Protocol):
    """An optimizer that is no gradient descent: it fits the model by itself."""

    def fit(self, model: Model, runs: Sequence[Run], generator: Generator) -> int | None:
        """Fit in place; may return how often the model was evaluated."""


def train(
    model: Model,
    runs: Sequence[Run],
    check_runs: Sequence[Run] = (),
    *,
    optimizer: MakeOptimizer | Fitter,
    out: Path,
    init: Callback | None = None,
    epochs: int = 1000,
    goal: float | None = None,
    batch_size: int | None = None,
    seed: int = 1,
    device: str = "cpu",
    resume: Path | None = None,
    labels: Mapping[str, str | None] | None = None,
) -> dict[str, Any]:
    """Fit a model and score it; leaves a checkpoint and TensorBoard events in `out`.

    Args:
        model: fitted in place and left on the CPU, in evaluation mode.
        runs: fitted.
        check_runs: only scored.
        optimizer: makes a torch optimizer from parameters (for a `FeatureModel`), or has a method ``fit(model, runs, generator)``.
        out: an existing folder.
        init: draws the initial weights; by default at random from `seed`. Of no use to an optimizer that fits by itself.
        epochs: passes over the fitted runs.
        goal: training stops once the loss (squared error over the error's variance) is below.
        batch_size: blocks a step; None for all at once.
        seed: of all chance here.
        device: ``"cpu"`` or ``"cuda"``.
        resume: checkpoint of an earlier call with the same model, to go on from.
        labels: what the user calls model, init and optimizer; first in the metrics and among TensorBoard's hyperparameters.

    Returns:
        Metrics as JSON takes them: RMS by run and stage [output's unit], seed, versions, wall time, evaluations.

    Raises:
        InputError: model, optimizer, device and checkpoint do not fit together.
        WorkError: the training diverged.
    """
    started = time.perf_counter()
    _check(model, runs, optimizer, device)
    _check_numbers(epochs=epochs, goal=goal, batch_size=batch_size, seed=seed)
    chance = torch.Generator().manual_seed(seed)
    logger = TensorBoardLogger(out, name=EVENTS, version="", default_hp_metric=False)
    with quiet_lightning(), _no_half_curve(out / EVENTS), threads_for(sum(run.blocks for run in runs) * WIDTH):
        if hasattr(optimizer, "fit"):
            evaluations = cast(Fitter, optimizer).fit(model, runs, chance)
            save_unfitted_by_gradient(model, out)
            fitted = {"epochs": None, "evaluations": evaluations, "loss": None}
            if hasattr(optimizer, "physical"):
                fitted["physical"] = optimizer.physical(runs[0].unit)
        else:
            net = cast(FeatureModel, model)
            passes = min(PASSES_PER_EPOCH, epochs)
            data = RunsDataModule(runs, check_runs, partial(block_features, net), passes=passes, batch_size=batch_size, generator=chance)
            fitted = fit_by_gradient(net, data, optimizer, init or RandomInit(seed), Schedule(epochs, goal, device, resume), out, logger)
    model.cpu().eval()
    metrics = dict(labels or {}) | fitted | score_runs(model, runs, check_runs)
    metrics |= {"seed": seed, "device": device, "parameters": sum(p.numel() for p in model.parameters()), "versions": versions()}
    metrics["wall_time_s"] = round(time.perf_counter() - started, 3)
    _log_result(logger, metrics, [*(labels or {}), "seed", "parameters", "average_s"])
    return metrics


@contextmanager
def _no_half_curve(folder: Path) -> Iterator[None]:
    """Takes the events of a training that was interrupted away again; those of one that diverged show how."""
    there = folder.exists()
    try:
        yield
    except KeyboardInterrupt:
        if not there:
            shutil.rmtree(folder, ignore_errors=True)
        raise


def _check(model: Model, runs: Sequence[Run], optimizer: MakeOptimizer | Fitter, device: str) -> None:
    if not runs:
        raise InputError("data.files: no run to train on")
    usable_device(device)
    if not hasattr(optimizer, "fit") and not isinstance(model, FeatureModel):
        raise InputError(f"{type(model).__name__} is no map of features and cannot be trained by gradient; leave optimizer=auto")
    if not hasattr(optimizer, "fit"):
        weight_vector(model)  # raises where there are none


def _check_numbers(**given: Any) -> None:
    for name, value in given.items():
        optional, whole = name in {"goal", "batch_size"}, name != "goal"
        if value is None and optional:
            continue
        low = 1 if name in {"epochs", "batch_size"} else 0
        if isinstance(value, bool) or not isinstance(value, int if whole else int | float) or not value >= low:
            raise InputError(f"{name}={value}: a {'whole ' if whole else ''}number from {low} up is needed{', or null' if optional else ''}")


def versions() -> dict[str, str]:
    """What computed a result."""
    return {"fogzoo": zoo.__version__, "python": platform.python_version(), "torch": torch.__version__, "lightning": lightning.__version__}


def _log_result(logger: TensorBoardLogger, metrics: dict[str, Any], hyperparameters: list[str]) -> None:
    scalars = {f"rms/{key}": metrics[name] for key, name in (("fit", "rms"), ("check", "rms_check")) if metrics[name] is not None}
    logger.log_hyperparams({key: metrics[key] for key in hyperparameters if metrics[key] is not None}, scalars)
    logger.log_metrics(scalars, metrics["epochs"] or 0)
    logger.save()
    logger.finalize("success")
