"""Particle swarm as ask/tell on a tuple of tensors.

v <- K·(w·v + c1·r1·(own best − x) + c2·r2·(leader − x)),  x <- x + v,  r1, r2 uniform in [0, 1) for every particle and dimension.
The inertia w falls linearly over `steps` (Shi & Eberhart 1998); c1 = c2 = 1.49445 and the optional factor K are those of Clerc's constriction
(Eberhart & Shi 2000). All functions work on any number of leading axes: several swarms at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import torch
from torch import Tensor

from zoo.swarm.box import Chance, best_of, comparable, place, reflected, uniform
from zoo.swarm.settings import chosen, within


@dataclass(frozen=True)
class Settings:
    """The numbers that steer a swarm.

    Attributes:
        inertia_start: w at the first step.
        inertia_end: w after `steps` steps and ever after.
        steps: length of the inertia's fall.
        pull_own: c1, towards a particle's own best.
        pull_leader: c2, towards the swarm's best.
        velocity: largest velocity, as a fraction of the box's width.
        constriction: K; 1 leaves the velocity as it is.
    """

    inertia_start: float = 0.9
    inertia_end: float = 0.4
    steps: int = 100
    pull_own: float = 1.49445
    pull_leader: float = 1.49445
    velocity: float = 0.15
    constriction: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what makes no swarm."""
        within(self, "steps", 1)
        within(self, "velocity", 1e-6, 1)
        for name in ("inertia_start", "inertia_end", "pull_own", "pull_leader", "constriction"):
            within(self, name, 0)


class PSOState(NamedTuple):
    """A swarm of P particles in D dimensions, (...) swarms at once.

    Attributes:
        low: (..., D) lower bounds.
        high: (..., D) upper bounds.
        position: (..., P, D).
        speed: (..., P, D) per step.
        own: (..., P, D) each particle's best position.
        own_cost: (..., P) its cost, infinite before the first `tell`.
        leader: (..., D) the swarm's best position.
        leader_cost: (...) its cost.
        step: steps taken.
        evaluations: costs told so far, per swarm.
        settings: see `Settings`.
    """

    low: Tensor
    high: Tensor
    position: Tensor
    speed: Tensor
    own: Tensor
    own_cost: Tensor
    leader: Tensor
    leader_cost: Tensor
    step: int
    evaluations: int
    settings: Settings


def init(low: Tensor, high: Tensor, particles: int, generator: Chance, **settings: Any) -> PSOState:
    """Place a swarm at random in a box.

    Args:
        low: (..., D) lower bounds.
        high: (..., D) upper bounds, above `low`.
        particles: P.
        generator: source of chance.
        **settings: see `Settings`.

    Raises:
        InputError: an empty swarm or box, or settings that make no sense.
    """
    s = chosen(Settings, settings)
    position = place(low, high, particles, generator)
    speed = s.velocity * (high - low).unsqueeze(-2) * (2 * uniform(position.shape, low, generator) - 1)
    infinite = low.new_full(position.shape[:-1], torch.inf)
    return PSOState(low, high, position, speed, position, infinite, position[..., 0, :], infinite[..., 0], 0, 0, s)


def ask(state: PSOState) -> Tensor:
    """(..., P, D) positions whose cost is wanted, all inside the box."""
    return state.position


def tell(state: PSOState, cost: Tensor, generator: Chance) -> PSOState:
    """Move the swarm, given the costs of the positions asked for.

    Args:
        state: the swarm.
        cost: (..., P); NaN counts as infinitely bad.
        generator: source of chance.
    """
    cost = comparable(cost, state.own_cost)
    better = cost < state.own_cost
    own = torch.where(better.unsqueeze(-1), state.position, state.own)
    own_cost = torch.where(better, cost, state.own_cost)
    leader, leader_cost = best_of(own, own_cost)
    position, speed = _moved(state, own, leader, generator)
    best = state._replace(own=own, own_cost=own_cost, leader=leader, leader_cost=leader_cost)
    return best._replace(position=position, speed=speed, step=state.step + 1, evaluations=state.evaluations + cost.shape[-1])


def _moved(state: PSOState, own: Tensor, leader: Tensor, generator: Chance) -> tuple[Tensor, Tensor]:
    s, x = state.settings, state.position
    inertia = s.inertia_start + (s.inertia_end - s.inertia_start) * min(state.step / s.steps, 1.0)
    own_draws, leader_draws = uniform((*x.shape[:-2], 2, *x.shape[-2:]), x, generator).unbind(-3)
    speed = state.speed * (s.constriction * inertia)
    speed.addcmul_(own_draws, own - x, value=s.constriction * s.pull_own)
    speed.addcmul_(leader_draws, leader.unsqueeze(-2) - x, value=s.constriction * s.pull_leader)
    # Limited by the box's width: limits taken from its bounds would forbid a box of positive bounds any negative speed.
    limit = s.velocity * (state.high - state.low).unsqueeze(-2)
    speed.clamp_(-limit, limit)
    moved = x + speed
    position = reflected(moved, state.low, state.high)
    return position, torch.where(moved == position, speed, -0.5 * speed)
