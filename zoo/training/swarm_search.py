"""A swarm over the weights of a network, once for each member of an ensemble."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.given import check_number
from zoo.swarm.algorithm import SwarmAlgorithm
from zoo.training.problem import Problem

SMALLEST_REACH = 1e-6
"""Of a box that is searched."""


class Searched(NamedTuple):
    """Swarms on their way.

    Attributes:
        swarms: state of all swarms, members along the first axis, their S groups of weights along the second.
        chance: source of chance of each member.
        settled: (E,) bool: need not go on.
        weights: (E, D) the best that each has found before it was settled.
        losses: (E,) and their losses.
        steps: (E,) evaluations of its whole population by each.
    """

    swarms: Any
    chance: list[Generator]
    settled: Tensor
    weights: Tensor
    losses: Tensor
    steps: Tensor


class SwarmSearch:
    """A search of the box ±reach of all weights; of weights in groups of which each sample sees one, a swarm for each group (tong2019: a segment).

    Swarms of separate groups are evaluated together and cost no more than one, and what one finds does not blur what another does. All members'
    swarms move together, each member with its own source of chance, so that it finds what it would find alone.
    """

    def __init__(self, group: str, algorithm: SwarmAlgorithm, particles: int, steps: int, reach: float, **settings: Any) -> None:
        """Describe it, see `zoo.training.swarm_init.SwarmInit`; `group` is what the settings are typed after, for messages."""
        self.group, self.algorithm, self.particles, self.steps, self.reach = group, algorithm, particles, steps, reach
        self.settings = {"steps": steps} | settings

    def start(self, problem: Problem, seeds: Iterable[int]) -> Searched:
        """Place the swarms of each seed.

        Raises:
            InputError: settings that make no swarm.
        """
        chance = [torch.Generator().manual_seed(seed) for seed in seeds]
        try:
            check_number("steps", self.steps, 1, whole=True)
            check_number("reach", self.reach, SMALLEST_REACH)
            edge = problem.features.new_full((len(chance), *problem.places.shape), self.reach)
            swarms = self.algorithm.init(-edge, edge, self.particles, chance, **self.settings)
        except InputError as error:
            raise InputError(f"{self.group}.{error}") from error
        settled = torch.zeros(len(chance), dtype=torch.bool, device=edge.device)
        return Searched(swarms, chance, settled, *_best(problem, swarms), torch.zeros_like(settled, dtype=torch.int64))

    def step(self, problem: Problem, state: Searched) -> Searched:
        """One evaluation of all populations but those that are settled, which move on unseen."""
        asked, settled = self.algorithm.ask(state.swarms), state.settled
        active = (~settled).nonzero().squeeze(-1)
        losses = asked.new_full(asked.shape[:-1], torch.inf).index_copy(0, active, problem.losses_of_parts(asked[active]))
        swarms = self.algorithm.tell(state.swarms, losses, state.chance)
        weights, best = _best(problem, swarms)
        return state._replace(
            swarms=swarms,
            weights=torch.where(settled.unsqueeze(-1), state.weights, weights),
            losses=torch.where(settled, state.losses, best),
            steps=state.steps + ~settled,
        )


def _best(problem: Problem, swarms: Any) -> tuple[Tensor, Tensor]:
    """(E, D) the best weights of each member, put together from those of its groups, and (E,) their losses."""
    return swarms.leader.flatten(1)[:, problem.places.flatten().argsort()], swarms.leader_cost.sum(-1)
