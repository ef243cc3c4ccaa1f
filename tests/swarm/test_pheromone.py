"""The pheromone colony: evaporation, what is added, and who moves how far."""

import math

import pytest
import torch

from zoo.errors import InputError
from zoo.swarm import pheromone

LOW, HIGH = torch.full((3,), 10.0, dtype=torch.float64), torch.full((3,), 50.0, dtype=torch.float64)
COSTS = torch.tensor([1.0, 2.0, 4.0, 5.0, torch.nan], dtype=torch.float64)
ADDED = torch.tensor([1.0, math.exp(-0.5), math.exp(-1.5), math.exp(-2.0), 0.0], dtype=torch.float64)
"""Excesses over the best 0, 1, 3, 4 with their mean 2."""


def generator(seed: int = 1) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


@pytest.mark.parametrize("evaporation", [0.0, 0.3, 0.9, 1.0])
def test_pheromone_evaporates_and_is_added_to(evaporation: float) -> None:
    # No ant improves after the first step, so that each adds the same every time: τ_n = Δ (1 − (1 − ρ)^n) / ρ.
    chance = generator()
    state = pheromone.init(LOW, HIGH, 5, chance, evaporation=evaporation)
    for n in range(1, 6):
        state = pheromone.tell(state, COSTS, chance)
        series = sum((1 - evaporation) ** i for i in range(n))
        torch.testing.assert_close(state.pheromone, series * ADDED)


def test_ants_near_the_best_in_pheromone_move_locally_and_the_others_across_the_box() -> None:
    chance = generator()
    state = pheromone.init(LOW, HIGH, 5, chance, threshold=0.5, local=0.1)  # P = 0, 0.39, 0.78, 0.86, 1
    far = torch.zeros(5, dtype=torch.float64)
    for n in range(1, 200):
        state = pheromone.tell(state, COSTS, chance)
        away = (pheromone.ask(state) - state.ant).abs().amax(-1)
        assert bool((away[:2] <= 0.1 * 40 / n).all())
        far = torch.maximum(far, away)
    assert bool((far[2:] > 15).all())
    assert bool((far[2:] <= 20).all())


def test_a_move_is_kept_only_if_it_is_better() -> None:
    chance = generator()
    first = pheromone.tell(pheromone.init(LOW, HIGH, 5, chance), COSTS, chance)
    second = pheromone.tell(first, torch.tensor([1.5, 1.9, 3.0, 5.0, 9.0], dtype=torch.float64), chance)
    moved = torch.tensor([False, True, True, False, True])
    torch.testing.assert_close(second.ant, torch.where(moved.unsqueeze(-1), first.position, first.ant), rtol=0, atol=0)
    torch.testing.assert_close(second.ant_cost, torch.tensor([1.0, 1.9, 3.0, 5.0, 9.0], dtype=torch.float64))


@pytest.mark.parametrize("name", ["evaporation", "threshold", "local"])
def test_what_is_no_share_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=rf"^{name}=1.5: a number from 0 to 1"):
        pheromone.init(LOW, HIGH, 3, generator(), **{name: 1.5})
