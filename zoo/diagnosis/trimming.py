"""What an effect is worth with only those of its amplitudes that the runs call for."""

from __future__ import annotations

import math
from dataclasses import dataclass

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


def trimmed(whitened: Tensor, target: Tensor, moves: Tensor, given: list[list[int]], price: float) -> Trimmed:
    """Leave out, one at a time, the amplitudes that lower χ² by less than they cost, but one of each effect (backward elimination).

    A parameter of the shape goes when the last column does that depends on it. An effect with three lines in temperature, of which the gyro has
    one, is then judged as one line. Columns without anything in them, such as those of a third run where there are two, are no choice.

    Args:
        whitened: (N, K+P) columns and tangents.
        target: (N,) whitened.
        moves: (P, K) whether a column depends on a parameter.
        given: places of the amplitudes of each effect that may be trimmed.
        price: χ² that a parameter must be worth.
    """
    norm = whitened.norm(dim=0).clamp_min(1e-300)
    scaled = whitened / norm
    gram, right = scaled.mT @ scaled, scaled.mT @ target
    amplitudes = moves.shape[1]
    present = [i for i in range(whitened.shape[1]) if i < amplitudes or bool(moves[i - amplitudes].any())]
    effects = [[column for column in places if bool(whitened[:, column].any())] or places[:1] for places in given]
    dead = {column for places in given for column in places} - {column for places in effects for column in places}
    present = [i for i in present if i not in dead]
    kept, gain = [list(places) for places in effects], 0.0
    while True:
        trials = {column: _without(present, column, moves) for places in kept if len(places) > 1 for column in places}
        saved = {column: price * (len(present) - len(left)) - _loss(gram, right, present, left) for column, left in trials.items()}
        least = max(saved, key=lambda column: saved[column], default=None)
        if least is None or saved[least] <= 0:
            break
        gain += price * (len(present) - len(trials[least])) - saved[least]
        present = trials[least]
        kept = [[column for column in places if column != least] for places in kept]
    return Trimmed(gain, present, sum(math.log(math.comb(len(all_), len(left))) for all_, left in zip(effects, kept, strict=True)))


def _without(present: list[int], column: int, moves: Tensor) -> list[int]:
    """What is left without one amplitude: without the parameters, too, on which only its column depends."""
    amplitudes = moves.shape[1]
    left = [i for i in present if i != column]
    columns = [i for i in left if i < amplitudes]
    return [i for i in left if i < amplitudes or bool(moves[i - amplitudes, columns].any())]


def _loss(gram: Tensor, right: Tensor, present: list[int], left: list[int]) -> float:
    """Growth of χ² from one set of columns to a part of it."""
    return _explained(gram, right, present) - _explained(gram, right, left)


def _explained(gram: Tensor, right: Tensor, places: list[int]) -> float:
    part, along = gram[places][:, places], right[places]
    factor, _ = torch.linalg.cholesky_ex(part + ridge_of(part))
    return float((torch.linalg.solve_triangular(factor, along.unsqueeze(1), upper=False)).square().sum())
