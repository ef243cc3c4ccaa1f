"""Laws that every swarm algorithm obeys."""

import math

import pytest
import torch

from zoo.errors import InputError
from zoo.swarm import aco, pheromone, pso

ALGORITHMS = [pso, aco, pheromone]
LOW = torch.tensor([100.0, 100.0, 0.5, 1000.0, 20.0], dtype=torch.float64)
HIGH = torch.tensor([140.0, 102.0, 0.6, 5000.0, 21.0], dtype=torch.float64)
OPTIMUM = torch.tensor([104.0, 101.7, 0.59, 3200.0, 20.2], dtype=torch.float64)

pytestmark = pytest.mark.parametrize("algorithm", ALGORITHMS, ids=lambda module: module.__name__.rsplit(".", 1)[-1])


def generator(seed: int = 1) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def from_optimum(x: torch.Tensor) -> torch.Tensor:
    """Offset from the optimum in box widths, times 10."""
    return 10 * (x - OPTIMUM) / (HIGH - LOW)


def sphere(x: torch.Tensor) -> torch.Tensor:
    return from_optimum(x).square().sum(-1)


def rosenbrock(x: torch.Tensor) -> torch.Tensor:
    z = 1 + from_optimum(x)
    return (100 * (z[..., 1:] - z[..., :-1] ** 2) ** 2 + (1 - z[..., :-1]) ** 2).sum(-1)


def rastrigin(x: torch.Tensor) -> torch.Tensor:
    z = from_optimum(x)
    return (z**2 + 10 * (1 - torch.cos(2 * math.pi * z))).sum(-1)


def search(algorithm, cost=sphere, low=LOW, high=HIGH, particles=20, steps=150, seed=1):
    """The last state, and the best cost after every step."""
    chance = generator(seed)
    state = algorithm.init(low, high, particles, chance, steps=steps)
    curve = []
    for _ in range(steps):
        x = algorithm.ask(state)
        assert bool(((x >= low.unsqueeze(-2)) & (x <= high.unsqueeze(-2))).all())
        state = algorithm.tell(state, cost(x), chance)
        curve.append(state.leader_cost)
    return state, torch.stack(curve)


@pytest.mark.parametrize("seed", range(5))
def test_it_finds_a_shifted_optimum_in_an_asymmetric_box_of_positive_bounds(algorithm, seed: int) -> None:
    state, _ = search(algorithm, seed=seed, steps=300)
    assert float(((state.leader - OPTIMUM) / (HIGH - LOW)).abs().max()) < 0.01


def test_the_best_never_rises_and_is_the_cost_of_the_leader(algorithm) -> None:
    state, curve = search(algorithm, rastrigin, steps=60)
    assert bool((curve.diff(dim=0) <= 0).all())
    assert curve[0] > 2 * curve[-1]
    torch.testing.assert_close(state.leader_cost, rastrigin(state.leader))
    assert state.evaluations == 60 * 20


@pytest.mark.parametrize("cost", [sphere, rosenbrock, rastrigin])
def test_it_beats_random_search_at_equal_evaluations(algorithm, cost) -> None:
    found, drawn = [], []
    for seed in range(5):
        state, _ = search(algorithm, cost, seed=seed)
        found.append(float(state.leader_cost))
        drawn.append(float(cost(LOW + (HIGH - LOW) * torch.rand(state.evaluations, 5, generator=generator(seed), dtype=torch.float64)).min()))
    assert sorted(found)[2] < 0.5 * sorted(drawn)[2]


def test_an_optimum_in_a_corner_is_reached(algorithm) -> None:
    slope = torch.tensor([1.0, -1.0, 1.0, -1.0, -1.0], dtype=torch.float64)
    state, _ = search(algorithm, lambda x: from_optimum(x) @ slope, steps=300)
    corner = torch.where(slope < 0, HIGH, LOW)
    assert float(((state.leader - corner) / (HIGH - LOW)).abs().max()) < 0.02


def test_nan_is_infinitely_bad(algorithm) -> None:
    def holed(x: torch.Tensor) -> torch.Tensor:
        return torch.where(x[..., 0] > 110, torch.nan, sphere(x))

    state, curve = search(algorithm, holed, steps=300)
    assert bool(torch.isfinite(curve[-1]))
    assert float(((state.leader - OPTIMUM) / (HIGH - LOW)).abs().max()) < 0.02


def test_a_swarm_that_learns_nothing_stays_in_the_box(algorithm) -> None:
    for useless in (torch.nan, torch.inf, 7.0):
        state, _ = search(algorithm, lambda x, useless=useless: torch.full_like(x[..., 0], useless), steps=10)
        assert bool(algorithm.ask(state).isfinite().all())
        assert torch.equal(state.leader_cost, torch.tensor(torch.inf if useless != 7.0 else 7.0, dtype=torch.float64))


def test_moving_and_stretching_the_box_moves_and_stretches_the_path(algorithm) -> None:
    shift, stretch = torch.tensor([-100.0, 7.0, 0.0, -3000.0, 1.0]), torch.tensor([0.5, 3.0, 100.0, 1e-3, 1.0])
    here, curve = search(algorithm, steps=30)
    there, same = search(algorithm, lambda x: sphere((x - shift) / stretch), LOW * stretch + shift, HIGH * stretch + shift, steps=30)
    torch.testing.assert_close((there.leader - shift) / stretch, here.leader, rtol=1e-6, atol=1e-8)
    torch.testing.assert_close(same, curve, rtol=1e-4, atol=1e-9)


def test_the_unit_and_the_zero_of_the_cost_do_not_matter(algorithm) -> None:
    here, _ = search(algorithm, steps=20)
    there, _ = search(algorithm, lambda x: 1024 * sphere(x) - 4096, steps=20)
    torch.testing.assert_close(there.leader, here.leader, rtol=1e-6, atol=1e-6)


def test_the_generator_alone_decides_the_path(algorithm) -> None:
    one, _ = search(algorithm, steps=10, seed=7)
    torch.manual_seed(99)
    two, _ = search(algorithm, steps=10, seed=7)
    other, _ = search(algorithm, steps=10, seed=8)
    assert torch.equal(algorithm.ask(one), algorithm.ask(two))
    assert not torch.equal(algorithm.ask(one), algorithm.ask(other))


def test_leading_axes_are_swarms_of_their_own(algorithm) -> None:
    # Swarm 1 is told nonsense: that must not reach swarms 0 and 2, which search boxes of their own.
    low = torch.stack([LOW, LOW, LOW - 0.1 * (HIGH - LOW)])

    def cost(x: torch.Tensor) -> torch.Tensor:
        return torch.stack([sphere(x[0]), torch.full_like(x[1, :, 0], torch.nan), sphere(x[2])])

    state, curve = search(algorithm, cost, low, HIGH.expand(3, 5), steps=300)
    assert state.leader.shape == (3, 5)
    assert bool(curve[:, 1].isinf().all())
    assert float(((state.leader[[0, 2]] - OPTIMUM) / (HIGH - LOW)).abs().max()) < 0.01
    # Of as good a kind as alone: medians over 24 swarms in one batch and 24 one after another.
    together, _ = search(algorithm, rastrigin, LOW.expand(24, 5), HIGH.expand(24, 5), steps=60)
    alone = torch.stack([search(algorithm, rastrigin, steps=60, seed=seed)[0].leader_cost for seed in range(24)])
    assert 0.5 < float(together.leader_cost.median() / alone.median()) < 2


def test_swarms_with_a_generator_each_take_the_paths_that_they_take_alone(algorithm) -> None:
    """More particles than the archive of ACO holds, so that its ants are drawn from the first step on, and fewer."""
    for particles in (60, 7):
        chance = [generator(seed) for seed in (3, 4, 5)]
        alone = [(algorithm.init(LOW, HIGH, particles, one, steps=12), one) for one in map(generator, (3, 4, 5))]
        state = algorithm.init(LOW.expand(3, 5), HIGH.expand(3, 5), particles, chance, steps=12)
        for _ in range(12):
            state = algorithm.tell(state, rastrigin(algorithm.ask(state)), chance)
            alone = [(algorithm.tell(one, rastrigin(algorithm.ask(one)), own), own) for one, own in alone]
        torch.testing.assert_close(algorithm.ask(state), torch.stack([algorithm.ask(one) for one, _ in alone]), rtol=1e-9, atol=1e-9)
        torch.testing.assert_close(state.leader_cost, torch.stack([one.leader_cost for one, _ in alone]), rtol=1e-9, atol=1e-9)


def test_a_step_leaves_the_state_before_it_as_it_was(algorithm) -> None:
    chance = generator()
    state = algorithm.init(LOW, HIGH, 6, chance, steps=10)
    for _ in range(12):
        before = [one.clone() if isinstance(one, torch.Tensor) else one for one in state]
        after = algorithm.tell(state, sphere(algorithm.ask(state)), chance)
        for was, now in zip(before, state, strict=True):
            assert torch.equal(was, now) if isinstance(was, torch.Tensor) else was == now
        state = after


@pytest.mark.parametrize(("particles", "low", "high"), [(0, 0.0, 1.0), (3, 1.0, 1.0), (3, 2.0, 1.0)])
def test_an_empty_swarm_or_box_is_refused(algorithm, particles: int, low: float, high: float) -> None:
    with pytest.raises(InputError, match=r"particles=0: a whole number from 1 up|a swarm's box"):
        algorithm.init(torch.tensor([low]), torch.tensor([high]), particles, generator())


def test_a_setting_that_nobody_knows_is_refused(algorithm) -> None:
    with pytest.raises(InputError, match=r"^warmth: .*nown: "):
        algorithm.init(LOW, HIGH, 3, generator(), warmth=1)
