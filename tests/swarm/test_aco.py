"""ACO_R: the archive and the law of its Gaussians."""

import math

import pytest
import torch

from zoo.errors import InputError
from zoo.swarm import aco

LOW, HIGH = torch.full((2,), -1e6, dtype=torch.float64), torch.full((2,), 1e6, dtype=torch.float64)


def generator(seed: int = 1) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def test_the_archive_holds_the_best_ever_told_in_order() -> None:
    chance = generator()
    state = aco.init(LOW, HIGH, 7, chance, archive=12)
    told = []
    for step in range(20):
        cost = torch.rand(7, generator=chance, dtype=torch.float64)
        told.append(cost)
        state = aco.tell(state, cost, chance)
        best = torch.cat(told).sort().values[:12]
        torch.testing.assert_close(state.archive_cost[: len(best)], best, rtol=0, atol=0)
        assert bool(state.archive_cost[len(best) :].isinf().all()), step


def test_ants_are_drawn_from_the_archives_gaussians() -> None:
    # Two solutions, (0, 0) and (3, 30): Σω = 1 + exp(−1/(2 q² k²)), and each deviation is ξ |Δ| / (k − 1) whichever is picked.
    chance, q, xi = generator(), 0.5, 0.2
    state = aco.init(LOW, HIGH, 200_000, chance, archive=2, locality=q, deviation=xi)
    cost = torch.full((200_000,), 9.0, dtype=torch.float64)
    cost[0], cost[1] = 1.0, 2.0
    state.position[0], state.position[1] = torch.tensor([0.0, 0.0]), torch.tensor([3.0, 30.0])
    ants = aco.ask(aco.tell(state, cost, chance))
    first = 1 / (1 + math.exp(-1 / (2 * q**2 * 4)))
    apart = torch.tensor([3.0, 30.0], dtype=torch.float64)
    torch.testing.assert_close(ants.mean(0), (1 - first) * apart, rtol=0.01, atol=0)
    torch.testing.assert_close(ants.std(0), apart * math.sqrt(xi**2 + first * (1 - first)), rtol=0.01, atol=0)
    # One solution is picked for all dimensions: both coordinates come from the same one.
    correlation = torch.corrcoef(ants.T)[0, 1]
    torch.testing.assert_close(float(correlation), first * (1 - first) / (first * (1 - first) + xi**2), rtol=0.01, atol=0)


def test_a_small_q_follows_the_best_alone() -> None:
    # Three solutions, the best at (3, 30): each deviation is ξ (|Δ1| + |Δ2|) / (k − 1) around it.
    chance, xi = generator(), 0.2
    state = aco.init(LOW, HIGH, 200_000, chance, archive=3, locality=1e-4, deviation=xi)
    torch.testing.assert_close(state.ranks, torch.ones(1, dtype=torch.float64), rtol=0, atol=0)
    cost = torch.full((200_000,), 9.0, dtype=torch.float64)
    cost[0], cost[1], cost[2] = 2.0, 1.0, 3.0
    state.position[:3] = torch.tensor([[0.0, 0.0], [3.0, 30.0], [4.0, 80.0]])
    ants = aco.ask(aco.tell(state, cost, chance))
    deviation = xi * torch.tensor([3.0 + 1.0, 30.0 + 50.0], dtype=torch.float64) / 2
    torch.testing.assert_close(ants.mean(0), torch.tensor([3.0, 30.0], dtype=torch.float64), rtol=0, atol=4 * float(deviation[1]) / 200_000**0.5)
    torch.testing.assert_close(ants.std(0), deviation, rtol=0.01, atol=0)
    assert abs(float(torch.corrcoef(ants.T)[0, 1])) < 0.01


def test_what_nobody_ever_picks_is_not_ranked() -> None:
    ranks = aco.init(LOW, HIGH, 3, generator(), archive=50, locality=0.01).ranks
    assert 1 < len(ranks) < 50
    assert float(ranks[-1]) == 1
    assert bool((ranks.diff() > 0).all())


@pytest.mark.parametrize("setting", [{"archive": 1}, {"locality": 0.0}, {"deviation": -0.1}])
def test_what_makes_no_colony_is_refused(setting: dict[str, float]) -> None:
    with pytest.raises(InputError, match=rf"^{next(iter(setting))}="):
        aco.init(LOW, HIGH, 3, generator(), **setting)
