"""Ant colony for continuous domains, ACO_R, as ask/tell on a tuple of tensors.

An archive keeps the k best solutions found, s_1 the best. Each ant picks one of them, s_l with probability ω_l / Σω, and steps away from it:

    ω_l = exp(−(l − 1)² / (2 q² k²)) / (q k √(2π)),    x_i ~ N(s_l,i, σ_i),    σ_i = ξ · Σ_e |s_e,i − s_l,i| / (k − 1)

Source: Socha & Dorigo 2008, doi 10.1016/j.ejor.2006.06.046, without their rotation of the axes. Until k costs are told the ants are placed at random.
All functions work on any number of leading axes: several colonies at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import torch
from torch import Tensor

from zoo.swarm.box import Chance, comparable, normal, picked, place, reflected, uniform
from zoo.swarm.settings import chosen, within


@dataclass(frozen=True)
class Settings:
    """The numbers that steer a colony; those of the source.

    Attributes:
        archive: k, solutions kept.
        locality: q; the smaller, the more the ants follow the best few: at 1e-4 the best alone.
        deviation: ξ; the larger, the wider the steps and the slower the search.
    """

    archive: int = 50
    locality: float = 1e-4
    deviation: float = 0.85

    def __post_init__(self) -> None:
        """Refuse what makes no colony."""
        within(self, "archive", 2)
        within(self, "locality", 1e-6)
        within(self, "deviation", 0)


class ACOState(NamedTuple):
    """A colony of P ants in D dimensions, (...) colonies at once.

    Attributes:
        low: (..., D) lower bounds.
        high: (..., D) upper bounds.
        position: (..., P, D) where the ants are.
        archive: (..., k, D) the best solutions, the best first.
        archive_cost: (..., k) their costs, ascending; infinite where none has been told.
        ranks: (m,) probability that an ant picks this solution or a better one, up to the first that makes it certain: m = 1 at a small q.
        evaluations: costs told so far, per colony.
        settings: see `Settings`.
    """

    low: Tensor
    high: Tensor
    position: Tensor
    archive: Tensor
    archive_cost: Tensor
    ranks: Tensor
    evaluations: int
    settings: Settings

    @property
    def leader(self) -> Tensor:
        """(..., D) the best position."""
        return self.archive[..., 0, :]

    @property
    def leader_cost(self) -> Tensor:
        """(...) its cost."""
        return self.archive_cost[..., 0]


def init(low: Tensor, high: Tensor, particles: int, generator: Chance, steps: int = 100, **settings: Any) -> ACOState:
    """Place a colony at random in a box.

    Args:
        low: (..., D) lower bounds.
        high: (..., D) upper bounds, above `low`.
        particles: P ants.
        generator: source of chance.
        steps: of the search; ACO_R has no schedule and needs none.
        **settings: see `Settings`.

    Raises:
        InputError: an empty colony or box, or settings that make no sense.
    """
    s = chosen(Settings, settings)
    position, archive = place(low, high, particles, generator), place(low, high, s.archive, generator)
    return ACOState(low, high, position, archive, low.new_full(archive.shape[:-1], torch.inf), _ranks(s, low), 0, s)


def ask(state: ACOState) -> Tensor:
    """(..., P, D) positions whose cost is wanted, all inside the box."""
    return state.position


def tell(state: ACOState, cost: Tensor, generator: Chance) -> ACOState:
    """Keep the best and send the ants out again, given the costs of the positions asked for.

    Args:
        state: the colony.
        cost: (..., P); NaN counts as infinitely bad.
        generator: source of chance.
    """
    k = state.settings.archive
    costs = torch.cat([state.archive_cost, comparable(cost, state.archive_cost)], dim=-1)
    archive_cost, which = costs.topk(k, dim=-1, largest=False)
    archive = picked(torch.cat([state.archive, state.position], dim=-2), which)
    evaluations = state.evaluations + cost.shape[-1]
    position = _sampled(archive, state, generator) if evaluations >= k else place(state.low, state.high, state.position.shape[-2], generator)
    return ACOState(state.low, state.high, position, archive, archive_cost, state.ranks, evaluations, state.settings)


def _sampled(archive: Tensor, state: ACOState, generator: Chance) -> Tensor:
    if len(state.ranks) == 1:  # All step away from the best: nobody needs to draw whom to follow, and one distance serves all.
        mean = archive.narrow(-2, 0, 1)
        distance = (archive - mean).abs_().sum(-2, keepdim=True)
    else:
        mean = picked(archive, torch.searchsorted(state.ranks, uniform(state.position.shape[:-1], archive, generator)))
        distance = (archive.unsqueeze(-3) - mean.unsqueeze(-2)).abs_().sum(-2)
    drawn = normal(state.position.shape, archive, generator)
    step = state.settings.deviation / (state.settings.archive - 1)
    return reflected(torch.addcmul(mean, distance, drawn, value=step), state.low, state.high)


def _ranks(settings: Settings, like: Tensor) -> Tensor:
    rank = torch.arange(settings.archive, dtype=like.dtype, device=like.device)
    weight = torch.exp(-(rank**2) / (2 * (settings.locality * settings.archive) ** 2)) / (
        settings.locality * settings.archive * math.sqrt(2 * math.pi)
    )
    # Divided by its own last entry: rounding must not leave a gap below 1, in which a draw would find no solution.
    total = weight.cumsum(0)
    ranks = total / total[-1]
    return ranks[: int((ranks < 1).sum()) + 1]
