"""Ant colony with a pheromone on each ant's place, as ask/tell on a tuple of tensors: the colony of qiu2023.

Every ant i stands at x_i with cost f_i and pheromone τ_i. One step, with uniform u in [0, 1) for every ant and dimension and w the box's width:

    P_i = (τ_best − τ_i) / τ_best                                        the transition probability
    x_i' = x_i + (2u − 1)·λ·w / n  where P_i < P0,  else  x_i + (u − 1/2)·w      locally in step n, or across the box
    x_i <- x_i' where f(x_i') < f_i                                      a move is kept only if it is better
    τ_i <- (1 − ρ)·τ_i + Δ_i                                             evaporation, and what the ant adds

Source: qiu2023 names these steps (random placement of the ants, pheromone from position, best found, transition probability, move, repeat) and two
numbers, 10 ants and an evaporation of 0.9. It prints no equation; the form above is the usual one of continuous colonies. P0, λ and Δ are engineering
priors:

    Δ_i = exp(−(f_i − f_best) / (f̄ − f_best)),  f̄ the mean of the ants' finite costs,

so that neither the unit of the cost nor its zero matters; a position without a finite cost gets no pheromone.
All functions work on any number of leading axes: several colonies at once.
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
    """The numbers that steer a colony.

    Attributes:
        evaporation: ρ, share of the pheromone lost in a step (qiu2023: 0.9).
        threshold: P0; ants whose transition probability is below move locally.
        local: λ, half-width of the first local step, as a share of the box's width; step n has 1/n of it.
    """

    evaporation: float = 0.9
    threshold: float = 0.2
    local: float = 0.5

    def __post_init__(self) -> None:
        """Refuse what makes no colony."""
        for name in ("evaporation", "threshold", "local"):
            within(self, name, 0, 1)


class PheromoneState(NamedTuple):
    """A colony of P ants in D dimensions, (...) colonies at once.

    Attributes:
        low: (..., D) lower bounds.
        high: (..., D) upper bounds.
        position: (..., P, D) where the ants look next.
        ant: (..., P, D) where they stand.
        ant_cost: (..., P) its cost, infinite before the first `tell`.
        pheromone: (..., P) τ.
        leader: (..., D) the best position.
        leader_cost: (...) its cost.
        step: n, steps taken.
        evaluations: costs told so far, per colony.
        settings: see `Settings`.
    """

    low: Tensor
    high: Tensor
    position: Tensor
    ant: Tensor
    ant_cost: Tensor
    pheromone: Tensor
    leader: Tensor
    leader_cost: Tensor
    step: int
    evaluations: int
    settings: Settings


def init(low: Tensor, high: Tensor, particles: int, generator: Chance, steps: int = 100, **settings: Any) -> PheromoneState:
    """Place a colony at random in a box.

    Args:
        low: (..., D) lower bounds.
        high: (..., D) upper bounds, above `low`.
        particles: P ants.
        generator: source of chance.
        steps: of the search; the local steps shrink with the steps taken, whatever is to come.
        **settings: see `Settings`.

    Raises:
        InputError: an empty colony or box, or settings that make no sense.
    """
    s = chosen(Settings, settings)
    ant = place(low, high, particles, generator)
    infinite = low.new_full(ant.shape[:-1], torch.inf)
    return PheromoneState(low, high, ant, ant, infinite, torch.zeros_like(infinite), ant[..., 0, :], infinite[..., 0], 0, 0, s)


def ask(state: PheromoneState) -> Tensor:
    """(..., P, D) positions whose cost is wanted, all inside the box."""
    return state.position


def tell(state: PheromoneState, cost: Tensor, generator: Chance) -> PheromoneState:
    """Move the ants, given the costs of the positions asked for.

    Args:
        state: the colony.
        cost: (..., P); NaN counts as infinitely bad.
        generator: source of chance.
    """
    cost = comparable(cost, state.ant_cost)
    better = cost < state.ant_cost
    ant = torch.where(better.unsqueeze(-1), state.position, state.ant)
    ant_cost = torch.where(better, cost, state.ant_cost)
    # No ant ever gives up a better place, so the best of all is where an ant stands.
    leader, leader_cost = best_of(ant, ant_cost)
    pheromone = (1 - state.settings.evaporation) * state.pheromone + _added(ant_cost, leader_cost)
    told = state._replace(ant=ant, ant_cost=ant_cost, pheromone=pheromone, leader=leader, leader_cost=leader_cost)
    told = told._replace(step=state.step + 1, evaluations=state.evaluations + cost.shape[-1])
    return told._replace(position=_moved(told, generator))


def _added(cost: Tensor, best: Tensor) -> Tensor:
    """(..., P) Δ."""
    finite = cost.isfinite()
    excess = cost - best.unsqueeze(-1)
    mean = torch.where(finite, excess, 0.0).sum(-1, keepdim=True) / finite.sum(-1, keepdim=True).clamp(min=1)
    return torch.where(finite, torch.exp(-excess / mean.clamp(min=torch.finfo(cost.dtype).tiny)), 0.0)


def _moved(state: PheromoneState, generator: Chance) -> Tensor:
    s, width = state.settings, (state.high - state.low).unsqueeze(-2)
    # P_i < P0, free of a division by a pheromone that is zero where no cost was finite.
    nearby = state.pheromone > (1 - s.threshold) * state.pheromone.amax(-1, keepdim=True)
    reach = torch.where(nearby.unsqueeze(-1), s.local / state.step, 0.5) * width
    sway = uniform(state.ant.shape, state.ant, generator).mul_(2).sub_(1)
    return reflected(torch.addcmul(state.ant, reach, sway), state.low, state.high)
