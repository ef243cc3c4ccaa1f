"""A swarm over the weights of a network, once for each member of an ensemble."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import torch
from torch import Generator, Tensor

from zoo.swarm.algorithm import SwarmAlgorithm
from zoo.training.problem import Problem


class Searched(NamedTuple):
    """Swarms on their way.

    Attributes:
        swarms: the state of each member's swarms, S at once.
        chance: source of chance of each.
        settled: (E,) bool: need not go on.
        order: (D,) place of each weight among those of all S groups, one group after the other.
    """

    swarms: list[Any]
    chance: list[Generator]
    settled: Tensor
    order: Tensor

    @property
    def weights(self) -> Tensor:
        """(E, D) the best that each has found."""
        return torch.stack([one.leader.flatten()[self.order] for one in self.swarms])

    @property
    def losses(self) -> Tensor:
        """(E,) and their losses."""
        return torch.stack([one.leader_cost.sum() for one in self.swarms])

    @property
    def evaluations(self) -> int:
        """Of the network, by each."""
        return int(self.swarms[0].evaluations)


class SwarmSearch:
    """A search of the box ±reach of all weights; of weights in groups of which each sample sees one, a swarm for each group (tong2019: a segment).

    Swarms of separate groups are evaluated together and cost no more than one, and what one finds does not blur what another does.
    All members' populations are evaluated together. What little else there is to a swarm's step is done one member after another, each with its
    own source of chance, so that a member finds what it would find alone.
    """

    def __init__(self, algorithm: SwarmAlgorithm, particles: int, steps: int, reach: float, **settings: Any) -> None:
        """Describe it, see `zoo.training.swarm_init.SwarmInit`."""
        self.algorithm, self.particles, self.steps, self.reach = algorithm, particles, steps, reach
        self.settings = {"steps": steps} | settings

    def start(self, problem: Problem, seeds: Iterable[int]) -> Searched:
        """Place the swarms of each seed."""
        edge = problem.features.new_full(problem.places.shape, self.reach)
        chance = [torch.Generator().manual_seed(seed) for seed in seeds]
        swarms = [self.algorithm.init(-edge, edge, self.particles, one, **self.settings) for one in chance]
        return Searched(swarms, chance, torch.zeros(len(swarms), dtype=torch.bool, device=edge.device), problem.places.flatten().argsort())

    def step(self, problem: Problem, state: Searched) -> Searched:
        """One evaluation of all populations but those that are settled."""
        active = (~state.settled).nonzero().squeeze(-1).tolist()
        swarms = list(state.swarms)
        with torch.no_grad():
            costs = problem.losses_of_parts(torch.stack([self.algorithm.ask(swarms[k]) for k in active]))
            for k, cost in zip(active, costs.unbind(), strict=True):
                swarms[k] = self.algorithm.tell(swarms[k], cost, state.chance[k])
        return state._replace(swarms=swarms)
