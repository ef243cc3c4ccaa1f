"""Particle swarm: laws that a wrong velocity limit, a wrong sign or a leaked random state would break."""

import pytest
import torch

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


def test_it_beats_random_search_at_equal_evaluations() -> None:
    def rugged(x: torch.Tensor) -> torch.Tensor:
        return (((x - OPTIMUM) / 4) ** 2 + 2 * (1 - torch.cos(2 * (x - OPTIMUM)))).sum(-1)

    low, high = BOX
    for seed in range(5):
        state, _ = search(rugged, low, high, particles=20, steps=50, seed=seed)
        drawn = low + (high - low) * torch.rand(state.evaluations, 5, generator=generator(seed), dtype=torch.float64)
        assert state.leader_cost < 0.5 * rugged(drawn).min()


def test_shifting_the_box_shifts_the_path() -> None:
    low, high = BOX
    here, curve = search(sphere, low, high, steps=40)
    shift = torch.tensor([-100.0, -120.0, 0.0, 500.0, -140.0], dtype=torch.float64)
    there, shifted_curve = search(lambda x: sphere(x - shift), low + shift, high + shift, steps=40)
    torch.testing.assert_close(there.leader, here.leader + shift, atol=1e-6, rtol=0)
    torch.testing.assert_close(shifted_curve, curve, atol=1e-6, rtol=1e-6)


def test_the_generator_alone_decides_the_path() -> None:
    one, _ = search(sphere, *BOX, steps=20, seed=7)
    torch.manual_seed(99)
    two, _ = search(sphere, *BOX, steps=20, seed=7)
    other, _ = search(sphere, *BOX, steps=20, seed=8)
    assert torch.equal(one.position, two.position)
    assert not torch.equal(one.position, other.position)


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


def test_the_best_never_gets_worse_and_is_the_cost_of_the_leader() -> None:
    state, curve = search(sphere, *BOX, steps=30)
    assert bool((curve.diff() <= 0).all())
    assert curve[0] > 10 * curve[-1]
    torch.testing.assert_close(state.leader_cost, sphere(state.leader))
    assert state.evaluations == 30 * 30


def test_nan_is_infinitely_bad() -> None:
    def cost(x: torch.Tensor) -> torch.Tensor:
        return torch.where(x[..., 0] > 110, torch.nan, sphere(x))

    state, curve = search(cost, *BOX, steps=200)
    assert bool(torch.isfinite(curve[-1]))
    torch.testing.assert_close(state.leader, OPTIMUM, atol=1e-2, rtol=0)
    chance = generator()
    lost = pso.tell(pso.init(*BOX, 4, chance), torch.full((4,), torch.nan, dtype=torch.float64), chance)
    assert torch.isinf(lost.leader_cost)
    assert bool(torch.isfinite(lost.position).all())


def test_several_swarms_search_at_once() -> None:
    low = torch.stack([BOX[0], BOX[0] - 10, BOX[0]])
    high = torch.stack([BOX[1], BOX[1], BOX[1] + 30])
    state, _ = search(sphere, low, high)
    assert state.leader.shape == (3, 5)
    torch.testing.assert_close(state.leader, OPTIMUM.expand(3, 5), atol=1e-2, rtol=0)


@pytest.mark.parametrize(("particles", "low", "high"), [(0, 0.0, 1.0), (3, 1.0, 1.0), (3, 2.0, 1.0)])
def test_an_empty_swarm_or_box_is_refused(particles: int, low: float, high: float) -> None:
    with pytest.raises(ValueError, match="swarm"):
        pso.init(torch.tensor([low]), torch.tensor([high]), particles, generator())
