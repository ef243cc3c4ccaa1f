"""Initial weights by a swarm: the search of ACO-BP and PSO-BP before the gradient takes over."""

from __future__ import annotations

from typing import Any

from torch import Tensor

from zoo.errors import WorkError
from zoo.given import check_seed
from zoo.progress import progress
from zoo.swarm.algorithm import SwarmAlgorithm
from zoo.training.init import Init, Log
from zoo.training.problem import Problem
from zoo.training.swarm_search import SwarmSearch


class SwarmInit(Init):
    """Searches the box ±reach of all weights for the lowest training loss, which training starts from."""

    def __init__(self, algorithm: SwarmAlgorithm, particles: int = 30, steps: int = 100, reach: float = 1.0, seed: int = 1, **settings: Any) -> None:
        """Describe the search.

        Args:
            algorithm: a module such as `zoo.swarm.pso`.
            particles: P.
            steps: evaluations of the whole population.
            reach: the box in every dimension is −reach…reach (features and error are standardised).
            seed: of the search alone.
            **settings: passed on to the algorithm's `init`.
        """
        check_seed("init.seed", seed)
        self.search = SwarmSearch("init", algorithm, particles, steps, reach, **settings)
        self.seed = seed

    def weights(self, problem: Problem, members: int, log: Log) -> Tensor:
        """See `Init.weights`; of blocks, their mean features will do for a place to start from."""
        problem = problem.of_means
        state = self.search.start(problem, range(self.seed, self.seed + members))
        with progress("swarm", self.search.steps) as advance:
            for step in range(self.search.steps):
                state = self.search.step(problem, state)
                log({"swarm/best": float(state.losses.median())}, step)
                advance()
        if not state.losses.isfinite().any():
            raise WorkError(f"init: the swarm found no weights with a finite loss within ±{self.search.reach:g}")
        self.evaluations = self.search.particles * self.search.steps
        return state.weights
