"""Training by gradient through Lightning, tuned for nets whose step takes a fraction of a millisecond."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import torch
from lightning.pytorch import Callback, Trainer
from lightning.pytorch.loggers import Logger
from lightning.pytorch.utilities.exceptions import SIGTERMException

from zoo.errors import Stopped, WorkError
from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel
from zoo.models.scaler import spread
from zoo.training.checkpoints import Checkpoints, save_checkpoint
from zoo.training.ensemble import Ensemble
from zoo.training.fine_blocks import rows_of, samples_of, seen
from zoo.training.members import Member
from zoo.training.module import MakeOptimizer, Training
from zoo.training.problem import Problem
from zoo.training.progress import TrainingProgress
from zoo.training.resume import check_resumable
from zoo.training.schedule import POINTS, Schedule
from zoo.training.stopping import STOPPED
from zoo.training.weights import weight_vector

PASSES_PER_EPOCH = 50
"""Passes over the data in what Lightning calls an epoch, whose price is many times a small net's step."""


def fit_by_gradient(
    model: FeatureModel,
    runs: tuple[Sequence[Run], Sequence[Run]],
    optimizer: MakeOptimizer,
    init: Callback,
    schedule: Schedule,
    seeds: Sequence[int],
    out: Path,
    logger: Logger | None,
) -> list[Member]:
    """Standardise, initialise, train, and leave a checkpoint.

    Args:
        model: trained in place; of several members, a pattern that is only standardised.
        runs: to fit, and to check on.
        optimizer: makes the optimizer from the parameters; for several members one that works element by element.
        init: draws the initial weights as training starts.
        schedule: how long and where.
        seeds: of the shuffling, one a member.
        out: an existing folder, for the checkpoint.
        logger: takes the curves; None where nobody does.

    Returns:
        The members whose training came to a finite end.

    Raises:
        InputError: the checkpoint to go on from does not fit.
        WorkError: the training diverged.
    """
    chance = [torch.Generator().manual_seed(seed) for seed in seeds]
    samples = samples_of(runs[0])
    data = RunsDataModule(
        *runs,
        rows_of(model, samples),
        passes=min(PASSES_PER_EPOCH, schedule.epochs),
        batch_size=schedule.batch_size,
        generator=chance[0] if len(seeds) == 1 else chance,
    )
    features, error = data.fitted
    seen(model, samples).standardise(features, error)
    steps_per_pass = data.train_dataloader().batches_per_pass
    steps = schedule.epochs * steps_per_pass
    every = max(steps // POINTS, 1)
    trained = model if len(seeds) == 1 else Ensemble(model, len(seeds))
    module = Training(trained, optimizer, float(spread(error)), schedule.goal, every, schedule.settings, samples)
    if schedule.resume is not None:
        data.begun = check_resumable(schedule.resume, module, steps)
    trainer = _trainer(steps, every, schedule.device, [init, TrainingProgress(steps, every), Checkpoints(out, every)], logger)
    with _interruptible():
        trainer.fit(module, datamodule=data, ckpt_path=schedule.resume, weights_only=True)
    module.finished = True
    members = _members(module, seeds, data, getattr(init, "evaluations", 0), steps_per_pass)
    save_checkpoint(trainer, out)
    return members


def _members(module: Training, seeds: Sequence[int], data: RunsDataModule, drawn: int, steps_per_pass: int) -> list[Member]:
    """What has become of each, less those that diverged."""
    trained, problem = module.model, Problem(module.net, *(one.to(module.device) for one in data.fitted))
    weights = trained.weights.detach() if isinstance(trained, Ensemble) else weight_vector(trained).unsqueeze(0)
    steps = trained.steps.tolist() if isinstance(trained, Ensemble) else [module.trainer.global_step]
    losses = problem.losses(weights).tolist()
    ended = [k for k, loss in enumerate(losses) if math.isfinite(loss)]
    if not ended:
        raise WorkError(f"training diverged: the loss is {losses[0]} after {steps[0]} steps; try a smaller optimizer.lr")
    found = []
    for k in ended:
        evaluations = drawn + (steps[k] if isinstance(trained, Ensemble) else module.evaluations)
        one = trained.member(k) if isinstance(trained, Ensemble) else trained
        found.append(Member.of(seeds[k], one, epochs=steps[k] // steps_per_pass, evaluations=evaluations, loss=losses[k]))
    return found


@contextmanager
def _interruptible() -> Iterator[None]:
    """Ctrl-C as everywhere else, which Lightning makes an exit with code 1, without a word; and a word on an end at a time limit."""
    try:
        yield
    except SIGTERMException as stop:
        raise Stopped(STOPPED) from stop
    except SystemExit as stop:
        if not isinstance(stop.__context__, KeyboardInterrupt):
            raise
        raise KeyboardInterrupt from stop


def _trainer(steps: int, every: int, device: str, callbacks: list[Callback], logger: Logger | None) -> Trainer:
    on_gpu = device.startswith("cuda")
    return Trainer(
        accelerator="gpu" if on_gpu else "cpu",
        devices=[int(device.partition(":")[2] or 0)] if on_gpu else 1,
        max_steps=steps,
        max_epochs=-1,
        logger=logger or False,
        callbacks=callbacks,
        log_every_n_steps=every,
        # Each of these costs more than a step of a net with a few dozen weights.
        enable_progress_bar=False,
        enable_model_summary=False,
        enable_checkpointing=False,
        num_sanity_val_steps=0,
        use_distributed_sampler=False,
    )
