"""Fits that step a whole population of weights by themselves, through no gradient descent: what they share around their steps."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol

import torch
from torch import Tensor

from zoo.errors import InputError, WorkError
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel
from zoo.progress import progress
from zoo.training.checkpoints import EVERY_S, save_fitted
from zoo.training.init import Init, Log
from zoo.training.members import Member
from zoo.training.module import Training
from zoo.training.problem import Problem
from zoo.training.resume import STATE, spent_before_s, stepwise_state
from zoo.training.schedule import POINTS, Schedule
from zoo.training.stopping import stoppable
from zoo.training.weights import set_weights

SAME = 1e-6
"""Share by which the loss of a checkpoint may differ from that of its weights."""


class Stepwise(Protocol):
    """An optimizer of maps of features that takes the whole problem, and all members of an ensemble at once.

    Its states have `weights` (E, D), and `settled` (E,), which members need no further step.
    """

    starts_from_init: bool

    def most_steps(self, epochs: int) -> int:
        """How many steps are taken at most."""

    def start(self, problem: Problem, weights: Tensor | None, seeds: Iterable[int]) -> Any:
        """The first state, from (E, D) initial weights or from one seed a member."""

    def step(self, problem: Problem, state: Any) -> Any:
        """The next state; who is settled stays."""

    def evaluations(self, state: Any) -> list[int]:
        """Of the model, by each member."""

    def steps_of(self, state: Any) -> list[int]:
        """Steps that each member has taken."""

    def kept(self, state: Any) -> dict[str, Tensor] | None:
        """The state as tensors for a checkpoint; None where it cannot be gone on from."""

    def restored(self, problem: Problem, kept: dict[str, Tensor]) -> Any:
        """The inverse of `kept`."""


def fit_stepwise(
    model: FeatureModel, runs: Sequence[Run], method: Stepwise, init: Init, schedule: Schedule, seeds: Sequence[int], out: Path, log: Log
) -> list[Member]:
    """Standardise, initialise, step, and leave a checkpoint.

    Args:
        model: standardised in place, and given the last member's weights.
        runs: to fit.
        method: takes the steps.
        init: draws the initial weights of a method that needs them.
        schedule: how long and where.
        seeds: one a member.
        out: an existing folder, for the checkpoint.
        log: takes the curve.

    Returns:
        The members whose loss is finite.

    Raises:
        InputError: the checkpoint to go on from does not fit.
        WorkError: no loss is finite.
    """
    if schedule.batch_size is not None:
        raise InputError(f"batch_size={schedule.batch_size}: {type(method).__name__} steps on all blocks at once; leave it out")
    problem = Problem.of_runs(model, runs, schedule.device)
    most, done, drawn = method.most_steps(schedule.epochs), 0, 0
    if schedule.resume is None:
        state = method.start(problem, init.weights(problem, len(seeds), log) if method.starts_from_init else None, seeds)
        drawn = init.evaluations if method.starts_from_init else 0
    else:
        done, drawn, kept = stepwise_state(schedule.resume, type(method).__name__, (len(seeds), problem.size), most, schedule.goal)
        state = _judged_anew(problem, method.restored(problem, kept))
    module = Training(model, goal=schedule.goal, settings=schedule.settings)
    module.stepper, module.evaluations, module.spent_before_s = type(method).__name__, drawn, spent_before_s(schedule.resume)
    state = _stepped(problem, method, state, range(done, most), schedule.goal, module, out, log)
    losses, steps, evaluations = problem.losses(state.weights).tolist(), method.steps_of(state), method.evaluations(state)
    members = []
    for k in [k for k, loss in enumerate(losses) if math.isfinite(loss)]:
        set_weights(model, state.weights[k])
        members.append(Member.of(seeds[k], model, epochs=steps[k], evaluations=drawn + evaluations[k], loss=losses[k]))
    if not members:
        raise WorkError(f"training diverged: {type(method).__name__} found no weights with a finite loss; try another init or seed")
    module.finished = True
    _save(module, method, state, max(steps), out)
    return members


def _stepped(problem: Problem, method: Stepwise, state: Any, steps: range, goal: float | None, module: Training, out: Path, log: Log) -> Any:
    every, last_s = max(len(steps) // POINTS, 1), time.monotonic()
    with stoppable(), progress("training", len(steps)) as advance:
        for count in steps:
            if bool(state.settled.all()):
                break
            state = method.step(problem, state)
            losses = state.losses
            if goal is not None:
                state = state._replace(settled=state.settled | (losses < goal))
            if (count + 1) % every == 0 or count == 0:
                log({"loss/fit": float(losses.nanmedian())}, count + 1)
            if time.monotonic() - last_s > EVERY_S and count + 1 < steps.stop:  # after the last step the end follows at once
                _save(module, method, state, count + 1, out)
                last_s = time.monotonic()
            advance()
    return state


def _judged_anew(problem: Problem, state: Any) -> Any:
    """A state to go on from, whose members are not at rest where their losses are others now, as with other measurements."""
    losses = problem.losses(state.weights)
    same = torch.isclose(losses, state.losses, rtol=SAME, atol=0.0)
    return state._replace(losses=torch.where(same, state.losses, losses), settled=state.settled & same)


def _save(module: Training, method: Stepwise, state: Any, steps: int, out: Path) -> None:
    kept = method.kept(state)
    if kept is not None or module.finished:
        module.kept = {STATE: kept, "steps": steps}
        save_fitted(module, out)


def is_stepwise(optimizer: Any) -> bool:
    """Whether an optimizer is of this kind."""
    return hasattr(optimizer, "most_steps")
