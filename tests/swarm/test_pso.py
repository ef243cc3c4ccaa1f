"""Particle swarm: laws that a wrong velocity limit, a wrong sign or a leaked random state would break."""

import math

import pytest
import torch

from zoo.errors import InputError
from zoo.swarm import pso

BOX = (torch.full((5,), 100.0, dtype=torch.float64), torch.full((5,), 140.0, dtype=torch.float64))
OPTIMUM = torch.tensor([104.0, 117.0, 139.0, 125.5, 101.5], dtype=torch.float64)


def generator(seed: int = 1) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def sphere(x: torch.Tensor) -> torch.Tensor:
    return ((x - OPTIMUM) ** 2).sum(-1)


def search(cost, low, high, particles=30, steps=200, seed=1, **settings):
    chance = generator(seed)
    state = pso.init(low, high, particles, chance, steps=steps, **settings)
    curve = []
    for _ in range(steps):
        state = pso.tell(state, cost(pso.ask(state)), chance)
        curve.append(state.leader_cost)
    return state, torch.stack(curve)


@pytest.mark.parametrize("seed", range(12))
def test_it_finds_a_shifted_optimum_in_a_box_of_positive_bounds(seed: int) -> None:
    state, _ = search(sphere, *BOX, seed=seed)
    torch.testing.assert_close(state.leader, OPTIMUM, atol=1e-3, rtol=0)


def test_it_finds_a_shifted_optimum_with_constant_inertia_and_constriction() -> None:
    state, _ = search(sphere, *BOX, inertia_start=1.0, inertia_end=1.0, pull_own=2.05, pull_leader=2.05, constriction=0.7298)
    torch.testing.assert_close(state.leader, OPTIMUM, atol=1e-3, rtol=0)


def test_positions_stay_in_the_box_and_speeds_below_the_limit() -> None:
    low, high = BOX
    chance = generator()
    slope = torch.tensor([1.0, -1.0, 2.0, -3.0, 1.0], dtype=torch.float64)
    state = pso.init(low, high, 25, chance, velocity=0.2, steps=60)
    for _ in range(100):
        x = pso.ask(state)
        assert bool(((x >= low) & (x <= high)).all())
        assert bool((state.speed.abs() <= 0.2 * (high - low) + 1e-12).all())
        state = pso.tell(state, x @ slope, chance)  # pushes the swarm into a corner
    torch.testing.assert_close(state.leader, torch.where(slope < 0, high, low), atol=0.5, rtol=0)


@pytest.mark.parametrize("name", ["inertia_start", "inertia_end", "pull_own", "pull_leader", "constriction"])
@pytest.mark.parametrize("value", [-1.0, math.inf, "abc"])
def test_what_steers_it_is_a_number_from_0_up(name: str, value: object) -> None:
    with pytest.raises(InputError, match=name):
        pso.Settings(**{name: value})  # type: ignore[arg-type]
