"""Trains one model on some runs and scores it on these and others."""

from __future__ import annotations

import math
import platform
import shutil
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol, cast

import lightning
import torch
from lightning.pytorch import Callback
from lightning.pytorch.loggers import Logger, TensorBoardLogger
from torch import Generator

import zoo
from zoo.errors import InputError
from zoo.given import LARGEST_SEED, check_number, of_the_house
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.checks import check_many_weights, check_model, check_trainable
from zoo.models.prediction import usable_device
from zoo.threads import threads_for
from zoo.training.checkpoints import save_fitted
from zoo.training.fine_blocks import samples_of
from zoo.training.gradient import fit_by_gradient
from zoo.training.init import Init, log_to
from zoo.training.members import Member, compare_members, write_members
from zoo.training.module import MakeOptimizer, Training, check_steps
from zoo.training.one_after_another import one_after_another
from zoo.training.quiet import OwnScalars, quiet_lightning
from zoo.training.random_init import RandomInit
from zoo.training.resume import spent_before_s
from zoo.training.schedule import Schedule
from zoo.training.scores import score_runs
from zoo.training.stepwise import Stepwise, fit_stepwise, is_stepwise
from zoo.training.weights import check_drawn, weight_vector

EVENTS = "tensorboard"
WIDTH = 32
"""Numbers that a block makes in a small net's largest tensor, to judge how many threads are worth it."""


ELEMENTWISE = (torch.optim.Adam, torch.optim.AdamW, torch.optim.NAdam, torch.optim.RAdam, torch.optim.SGD, torch.optim.RMSprop, torch.optim.Rprop)
"""Optimizers whose step of one weight does not depend on the others: many members at once are stepped as each alone."""


class Fitter(Protocol):
    """An optimizer that is no gradient descent: it fits the model by itself.

    It may have ``physical(unit)``, what it knows of parameters. One with ``follows_device = True`` gets model and runs on the device that was chosen,
    any other on the CPU.
    """

    def fit(self, model: Model, runs: Sequence[Run], generator: Generator) -> int | None:
        """Fit in place; may return how often the model was evaluated."""


def train(
    model: Model,
    runs: Sequence[Run],
    check_runs: Sequence[Run] = (),
    *,
    optimizer: MakeOptimizer | Fitter | Stepwise,
    out: Path,
    init: Callback | None = None,
    epochs: int = 1000,
    goal: float | None = None,
    batch_size: int | None = None,
    seed: int = 1,
    seeds: int = 1,
    device: str = "cpu",
    resume: Path | None = None,
    labels: Mapping[str, str | None] | None = None,
    hyperparameters: Mapping[str, bool | int | float | str] | None = None,
    settings: str = "",
) -> dict[str, Any]:
    """Fit a model and score it; leaves a checkpoint and TensorBoard events in `out`, and of several seeds all members.

    Args:
        model: fitted in place and left on the CPU, in evaluation mode; of several seeds it is the one with the lowest RMS of the fitted runs.
        runs: fitted.
        check_runs: only scored.
        optimizer: makes a torch optimizer from parameters (for a `FeatureModel`), or is a `Stepwise` (the same), or has a method
            ``fit(model, runs, generator)``.
        out: an existing folder.
        init: draws the initial weights; by default at random from `seed`. Of no use to an optimizer that fits by itself.
        epochs: passes over the fitted runs.
        goal: training stops once the loss (squared error over the error's variance) is below.
        batch_size: blocks a step; None for all at once.
        seed: of all chance here.
        seeds: E trainings with the seeds `seed` … `seed` + E − 1, as one batch where the optimizer works element by element, else one after another
            (L-BFGS searches along a line that all weights share). Each ends as it would alone: by Levenberg–Marquardt but for rounding, which its
            nearly singular equations may amplify, and under Adam only where none has waited for others at a goal that was lowered since.
        device: ``"cpu"`` or ``"cuda"``.
        resume: checkpoint of an earlier call with the same model, to go on from.
        labels: what the user calls model, init and optimizer; first in the metrics and among TensorBoard's hyperparameters.
        hyperparameters: more for TensorBoard to tell trainings apart by, beside seed, seeds, epochs and the labels.
        settings: all that decides the training, as text: a checkpoint tells by it whether it belongs to a command.

    Returns:
        Metrics as JSON takes them: RMS by run and stage [output's unit], seed, versions, wall time, evaluations; of several seeds those of the
        model, with the RMS of all beside them.

    Raises:
        InputError: model, optimizer, device and checkpoint do not fit together.
        WorkError: the training diverged.
    """
    started = time.perf_counter()
    _check(model, runs, optimizer, device)
    _check_numbers(epochs=epochs, goal=goal, batch_size=batch_size, seed=seed, seeds=seeds)
    if goal is not None and batch_size is not None:
        raise InputError(f"goal={goal} is of the loss over all blocks, of which batch_size={batch_size} shows a few at a time; leave one of them out")
    place = device
    if hasattr(optimizer, "fit"):
        place = device if getattr(optimizer, "follows_device", False) else "cpu"
        useless = next((name for name, value in (("resume", resume), ("batch_size", batch_size)) if value is not None), None)
        if useless:
            raise InputError(f"{useless}: {type(optimizer).__name__} solves in one go, from all blocks at once; leave it out")
    logger = OwnScalars(out, name=EVENTS, version="", default_hp_metric=False)
    every, started = range(seed, seed + seeds), started - spent_before_s(resume)  # now, for that may be overwritten
    with quiet_lightning(), _no_half_curve(out / EVENTS), threads_for(WIDTH * samples_of(runs) * sum(run.blocks for run in runs)):
        if hasattr(optimizer, "fit"):
            members = _fit_by_itself(model, runs, cast(Fitter, optimizer), every, place, out)
        else:
            schedule = Schedule(epochs, goal, device, batch_size, resume, settings)
            start = _drawing_apart(init or RandomInit(seed), model, optimizer, seeds)
            if is_stepwise(optimizer):
                method = cast(Stepwise, optimizer)
                members = fit_stepwise(cast(FeatureModel, model), runs, method, _drawing(start, "optimizer"), schedule, every, out, log_to(logger))
            else:
                members = _fit_by_gradient(
                    cast(FeatureModel, model), (runs, check_runs), cast(MakeOptimizer, optimizer), start, schedule, every, out, logger
                )
        model.cpu().eval()
        if _has_own_fit(model):
            check_model(model)
        best, spread = members[0], None
        if seeds > 1:
            best, spread = compare_members(model, members, runs, check_runs)
            spread["failed_seeds"] = sorted(set(every) - {member.seed for member in members})
            write_members(out, members)
    metrics = dict(labels or {}) | best.facts | score_runs(model, runs, check_runs)
    metrics |= {"seed": seed, "device": place, "parameters": sum(p.numel() for p in model.parameters()), "versions": versions()}
    metrics |= {} if spread is None else {"members": spread}
    metrics |= {"formula": formula} if (formula := model.formula()) else {}
    metrics["wall_time_s"] = round(time.perf_counter() - started, 3)
    _log_result(logger, metrics, [*(labels or {}), "parameters", "average_s"], {"seeds": seeds, "epochs": epochs} | dict(hyperparameters or {}))
    return metrics


def _fit_by_gradient(
    model: FeatureModel,
    runs: tuple[Sequence[Run], Sequence[Run]],
    optimizer: MakeOptimizer,
    init: Callback,
    schedule: Schedule,
    seeds: range,
    out: Path,
    logger: Logger,
) -> list[Member]:
    if len(seeds) == 1:
        return fit_by_gradient(model, runs, optimizer, init, schedule, seeds, out, logger)
    init = _drawing(init, f"seeds={len(seeds)}")
    if isinstance(optimizer([torch.nn.Parameter(torch.zeros(1))]), ELEMENTWISE):
        return fit_by_gradient(model, runs, optimizer, init, schedule, seeds, out, logger)
    if schedule.resume is not None:
        raise InputError(f"resume: this optimizer trains the {len(seeds)} seeds one after another, and no checkpoint holds them all; leave it out")

    # The checkpoint of one member is none that the command could go on from, and one curve for all would begin anew with each.
    by_itself = replace(schedule, settings="")

    def alone(one: Model, seed: int) -> Member:
        start, curve = init.of_member(seed - seeds[0]), logger if seed == seeds[0] else None
        return fit_by_gradient(cast(FeatureModel, one), runs, optimizer, start, by_itself, [seed], out, curve)[0]

    return one_after_another(model, seeds, alone)


def _drawing_apart(init: Callback, model: Model, optimizer: MakeOptimizer | Stepwise, seeds: int) -> Callback:
    """The same, unless it would give many seeds of a model from outside the same weights."""
    if seeds > 1 and isinstance(init, RandomInit) and getattr(optimizer, "starts_from_init", True) and not of_the_house(model):
        check_drawn(model)
    return init


def _drawing(init: Callback, who: str) -> Init:
    if not isinstance(init, Init):
        raise InputError(f"{who} needs an init that is a {Init.__module__}.{Init.__name__}; {type(init).__name__} is a callback of one training only")
    return init


def _fit_by_itself(model: Model, runs: Sequence[Run], fitter: Fitter, seeds: range, place: str, out: Path) -> list[Member]:
    there = runs if place == "cpu" else [run.to(place) for run in runs]

    def alone(one: Model, seed: int) -> Member:
        evaluations = fitter.fit(one.to(place), there, torch.Generator().manual_seed(seed))
        one.cpu()
        told = {"physical": fitter.physical(runs[0].unit)} if hasattr(fitter, "physical") else {}
        save_fitted(Training(one), out)
        return Member.of(seed, one, epochs=None, evaluations=evaluations, loss=None, **told)

    return [alone(model, seeds[0])] if len(seeds) == 1 else one_after_another(model, seeds, alone)


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


def _check(model: Model, runs: Sequence[Run], optimizer: MakeOptimizer | Fitter | Stepwise, device: str) -> None:
    if not runs:
        raise InputError("data.files: no run to train on")
    usable_device(device)
    if not of_the_house(model):
        check_model(model, tried=not _has_own_fit(model))
    if not hasattr(optimizer, "fit") and not isinstance(model, FeatureModel):
        instead = "leave optimizer=auto" if hasattr(model, "fitted_by") else f"derive it from {FeatureModel.__module__}.FeatureModel"
        raise InputError(f"{type(model).__name__} is no map of features and cannot be trained by gradient; {instead}")
    if not hasattr(optimizer, "fit"):
        weight_vector(model)  # raises where there are none
        if not of_the_house(model):
            check_many_weights(cast(FeatureModel, model))
        if not is_stepwise(optimizer):
            if not of_the_house(model):
                check_trainable(cast(FeatureModel, model))
            check_steps(cast(MakeOptimizer, optimizer), device)


def _has_own_fit(model: Model) -> bool:
    """Whether a model from outside may have nothing to predict from before it is fitted, so that it is tried only then."""
    return not of_the_house(model) and hasattr(model, "fitted_by")


def _check_numbers(**given: Any) -> None:
    for name, value in given.items():
        if value is not None or name not in {"goal", "batch_size"}:
            low, high = 1 if name in {"epochs", "batch_size", "seeds"} else 0, LARGEST_SEED if name == "seed" else math.inf
            check_number(name, value, low, high, whole=name != "goal")


def versions() -> dict[str, str]:
    """What computed a result."""
    return {"fogzoo": zoo.__version__, "python": platform.python_version(), "torch": torch.__version__, "lightning": lightning.__version__}


def _log_result(logger: TensorBoardLogger, metrics: dict[str, Any], known: list[str], hyperparameters: dict[str, Any]) -> None:
    """The result among TensorBoard's hyperparameters: those given, what is known of the metrics, and the seed, of several that of the model."""
    seed = (metrics.get("members") or {}).get("best_seed", metrics["seed"])
    told = {key: metrics[key] for key in known if metrics[key] is not None} | {"seed": seed} | hyperparameters
    scalars = {f"rms/{key}": metrics[name] for key, name in (("fit", "rms"), ("check", "rms_check")) if metrics[name] is not None}
    logger.log_hyperparams(told, scalars)
    logger.log_metrics(scalars, metrics["epochs"] or 0)
    logger.save()
    logger.finalize("success")
