"""What an effect is worth with only those of its amplitudes that the runs call for."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import torch
from torch import Tensor

from zoo.fitting.projection import ridge_of


@dataclass(frozen=True)
class Trimmed:
    """A least-squares problem with some columns left out.

    Attributes:
        gain: by how much χ² grew.
        left: places of the columns and tangents that are left.
        choices: logarithm of the number of ways to keep as many amplitudes of each effect.
    """

    gain: float
    left: list[int]
    choices: float


def trimmed(whitened: Tensor, target: Tensor, moves: Tensor, given: list[list[int]], price: float, spare: Collection[int] = ()) -> Trimmed:
    """Leave out, one at a time, the amplitudes that lower χ² by less than they cost, but one of each effect (backward elimination).

    A parameter of the shape goes when the last column does that depends on it. An effect with three lines in temperature, of which the gyro has
    one, is then judged as one line. Columns without anything in them, such as those of a third run where there are two, are no choice.

    Args:
        whitened: (N, K+P) columns and tangents.
        target: (N,) whitened.
        moves: (P, K) whether a column depends on a parameter.
        given: places of the amplitudes of each effect that may be trimmed.
        price: χ² that a parameter must be worth.
        spare: places of amplitudes that make no effect by themselves: another one of the same effect is left, and goes with them only where it is
            worth its price.
    """
    norm = whitened.norm(dim=0).clamp_min(1e-300)
    scaled = whitened / norm
    amplitudes = moves.shape[1]
    present = [i for i in range(whitened.shape[1]) if i < amplitudes or bool(moves[i - amplitudes].any())]
    effects = [[column for column in places if bool(whitened[:, column].any())] or places[:1] for places in given]
    dead = {column for places in given for column in places} - {column for places in effects for column in places}
    here = whole = _Columns(scaled.mT @ scaled, scaled.mT @ target, moves, [i for i in present if i not in dead])
    kept = [list(places) for places in effects]
    while True:
        less = {column: here.without(column) for places in kept for column in places if _an_effect(places, column, spare)}
        least = min(less, key=lambda column: here.worth(less[column], price), default=None)
        if least is None or here.worth(less[least], price) >= 0:
            least = next((one for places in kept for one in _all_there_is(here, places, spare, price)), None)
        if least is None:
            break
        here = here.without(least)
        kept = [[column for column in places if column != least] for places in kept]
    choices = sum(math.log(math.comb(len(all_), len(left))) for all_, left in zip(effects, kept, strict=True))
    return Trimmed(whole.explained - here.explained, here.places, choices)


@dataclass(frozen=True)
class _Columns:
    """Some columns and tangents of a least-squares problem, by their places."""

    gram: Tensor
    right: Tensor
    moves: Tensor
    places: list[int]

    def without(self, column: int) -> _Columns:
        """What is left without one amplitude: without the parameters, too, on which only its column depends."""
        amplitudes = self.moves.shape[1]
        left = [i for i in self.places if i != column]
        columns = [i for i in left if i < amplitudes]
        return replace(self, places=[i for i in left if i < amplitudes or bool(self.moves[i - amplitudes, columns].any())])

    @cached_property
    def explained(self) -> float:
        """χ² that they explain."""
        part, along = self.gram[self.places][:, self.places], self.right[self.places]
        factor, _ = torch.linalg.cholesky_ex(part + ridge_of(part))
        return float((torch.linalg.solve_triangular(factor, along.unsqueeze(1), upper=False)).square().sum())

    def worth(self, less: _Columns, price: float) -> float:
        """By how much χ² grows when only a part of them is left, less what the others cost."""
        return self.explained - less.explained - price * (len(self.places) - len(less.places))


def _an_effect(places: list[int], column: int, spare: Collection[int]) -> bool:
    """Whether the amplitudes of an effect are one without one of them."""
    return any(other not in spare for other in places if other != column)


def _all_there_is(here: _Columns, places: list[int], spare: Collection[int], price: float) -> list[int]:
    """The spare amplitudes of an effect whose last other one is not worth its price."""
    own = [column for column in places if column not in spare]
    idle = len(own) == 1 and len(places) > 1 and here.worth(here.without(own[0]), price) < 0
    return [column for column in places if column in spare] if idle else []
