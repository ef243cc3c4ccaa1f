"""Effects with amplitudes that a gyro does not call for."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from zoo.diagnosis.trimming import trimmed
from zoo.fitting.projection import project

PRICE = math.log(400.0)


def problem(amplitudes: list[float], seed: int = 1) -> tuple[Tensor, Tensor, Tensor]:
    """Two columns of a base, four of an effect, and two tangents: one that moves all of the effect, one that moves its last column only."""
    chance = torch.Generator().manual_seed(seed)
    columns = torch.randn(400, 6, generator=chance, dtype=torch.float64)
    tangents = torch.randn(400, 2, generator=chance, dtype=torch.float64)
    moves = torch.tensor([[0, 0, 1, 1, 1, 1], [0, 0, 0, 0, 0, 1]], dtype=torch.bool)
    target = columns @ torch.tensor([1.0, -1.0, *amplitudes], dtype=torch.float64) + torch.randn(400, generator=chance, dtype=torch.float64)
    return torch.cat([columns, tangents], dim=1), target, moves


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_only_what_was_planted_is_paid_for(seed) -> None:
    whitened, target, moves = problem([1.0, 0.0, 0.0, 0.0], seed)
    found = trimmed(whitened, target, moves, [[2, 3, 4, 5]], PRICE)
    assert len(found.left) == 4, "the base's two, one amplitude, and the parameter that moves it"
    assert found.choices == pytest.approx(math.log(4))
    less = whitened[:, [0, 1, 2, 6]]
    assert found.gain == pytest.approx(float(project(less, target).cost - project(whitened, target).cost), rel=1e-6)


def test_nothing_is_left_out_that_is_needed() -> None:
    whitened, target, moves = problem([1.0, -1.0, 1.0, -1.0])
    found = trimmed(whitened, target, moves, [[2, 3, 4, 5]], PRICE)
    assert (len(found.left), found.gain, found.choices) == (8, 0.0, 0.0)


def test_a_parameter_goes_with_the_last_column_that_it_moves() -> None:
    whitened, target, moves = problem([1.0, -1.0, 1.0, 0.0])
    found = trimmed(whitened, target, moves, [[2, 3, 4, 5]], PRICE)
    assert len(found.left) == 6, "an amplitude and a parameter less"


def test_of_every_effect_one_amplitude_stays() -> None:
    whitened, target, moves = problem([0.0, 0.0, 0.0, 0.0])
    found = trimmed(whitened, target, moves, [[2, 3], [4, 5]], PRICE)
    assert len(found.left) == 5, "the base's two, one of each effect, and the parameter of both"
    assert found.choices == pytest.approx(2 * math.log(2))


@pytest.mark.parametrize(("amplitudes", "left"), [([1.0, 0.0, 0.0, 1.0], {2, 5}), ([1.0, -1.0, 0.0, 0.0], {2, 3})])
def test_what_is_spare_stays_beside_what_is_worth_its_price(amplitudes, left) -> None:
    whitened, target, moves = problem(amplitudes)
    found = trimmed(whitened, target, moves, [[2, 3, 4, 5]], PRICE, spare=[5])
    assert {*found.left} & {2, 3, 4, 5} == left


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_what_is_spare_makes_no_effect_by_itself(seed) -> None:
    """All of χ² is lost that it explains: one of the others is left, which is not worth its price."""
    whitened, target, moves = problem([0.0, 0.0, 0.0, 1.0], seed)
    found = trimmed(whitened, target, moves, [[2, 3, 4, 5]], PRICE, spare=[5])
    assert len({*found.left} & {2, 3, 4}) == 1
    assert 5 not in found.left
    less = whitened[:, found.left]
    assert found.gain == pytest.approx(float(project(less, target).cost - project(whitened, target).cost), rel=1e-6)
    assert found.gain > 200.0


def test_what_may_not_be_trimmed_stays() -> None:
    whitened, target, moves = problem([0.0, 0.0, 0.0, 0.0])
    found = trimmed(whitened, target, moves, [], PRICE)
    assert (len(found.left), found.gain, found.choices) == (8, 0.0, 0.0)


def test_columns_without_anything_are_neither_kept_nor_chosen_among() -> None:
    """Those of a third and a fourth run, where there are two."""
    whitened, target, moves = problem([1.0, -1.0, 0.0, 0.0])
    whitened[:, [4, 5]] = 0.0
    found = trimmed(whitened, target, moves, [[2, 3, 4, 5]], PRICE)
    assert (found.gain, found.choices) == (0.0, 0.0)
    assert len(found.left) == 6, "four columns, and the parameters as far as they move one of these or another"
