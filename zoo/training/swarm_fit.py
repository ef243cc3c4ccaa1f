"""A swarm as the fit itself, as tong2019 fits its polynomials by PSO."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from torch import Tensor

from zoo.swarm.algorithm import SwarmAlgorithm
from zoo.training.problem import Problem
from zoo.training.swarm_search import Searched, SwarmSearch


class SwarmFit:
    """Optimizer of maps of features: the best place in the box ±reach of all weights that a swarm finds, by the sum of squared residuals.

    The weights belong to standardised features and errors, so that one box serves all data. A swarm that was killed begins again.
    """

    starts_from_init = False

    def __init__(self, algorithm: SwarmAlgorithm, particles: int = 400, steps: int = 300, reach: float = 2.0, **settings: Any) -> None:
        """Describe the search, see `zoo.training.swarm_search.SwarmSearch`."""
        self.search = SwarmSearch("optimizer", algorithm, particles, steps, reach, **settings)

    def most_steps(self, epochs: int) -> int:
        """The swarm's own number: its schedules are made for it."""
        return self.search.steps

    def start(self, problem: Problem, weights: Tensor | None, seeds: Iterable[int]) -> Searched:
        """Place one swarm a seed."""
        return self.search.start(problem, seeds)

    def step(self, problem: Problem, state: Searched) -> Searched:
        """One evaluation of all populations."""
        return self.search.step(problem, state)

    def evaluations(self, state: Searched) -> list[int]:
        """Of the network by each member."""
        return [self.search.particles * steps for steps in self.steps_of(state)]

    def steps_of(self, state: Searched) -> list[int]:
        """Evaluations of its whole population by each member."""
        return list(state.steps.tolist())

    def kept(self, state: Searched) -> None:
        """Nothing: a swarm's state is its algorithm's own."""

    def restored(self, problem: Problem, kept: dict[str, Any]) -> Searched:
        """Never asked for."""
        raise NotImplementedError
