"""Levenberg–Marquardt for networks, all members of an ensemble at once."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from torch import Tensor

from zoo.errors import InputError
from zoo.given import is_number
from zoo.training.damped_steps import Descent, begin, step
from zoo.training.problem import Problem


class LevenbergMarquardt:
    """Optimizer of maps of features: damped Gauss–Newton steps, see `zoo.training.damped_steps`."""

    starts_from_init = True

    def __init__(self, settled: float = 1e-6) -> None:
        """Remember.

        Args:
            settled: share of the loss by which a step must lower it to be followed by another.
        """
        if not is_number(settled) or not 0 <= settled < 1:
            raise InputError(f"optimizer.settled={settled}: a share from 0 up and below 1 is needed")
        self.settled = settled

    def most_steps(self, epochs: int) -> int:
        """A step is an epoch."""
        return epochs

    def start(self, problem: Problem, weights: Tensor | None, seeds: Iterable[int]) -> Descent:
        """From (E, D) weights."""
        assert weights is not None
        return begin(weights, problem.solved)

    def step(self, problem: Problem, state: Descent) -> Descent:
        """One of each member that has not settled."""
        return step(state, problem.normal_equations, problem.solved, self.settled)

    def evaluations(self, state: Descent) -> list[int]:
        """Of the network by each member: a Jacobian and a trial in each step."""
        return [1 + 2 * steps for steps in state.steps.tolist()]

    def steps_of(self, state: Descent) -> list[int]:
        """Tried by each member."""
        return list(state.steps.tolist())

    def kept(self, state: Descent) -> dict[str, Tensor]:
        """What goes on from here needs."""
        return {name: value.cpu() for name, value in state._asdict().items()}

    def restored(self, problem: Problem, kept: dict[str, Any]) -> Descent:
        """The inverse of `kept`."""
        return Descent(**{name: value.to(problem.features.device) for name, value in kept.items()})
