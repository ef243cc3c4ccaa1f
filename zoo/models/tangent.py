"""What a trained model predicts, and what it could predict if its weights moved a little."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor
from torch.func import jvp, vmap

from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.head import Head, weights_of
from zoo.models.prediction import raw_columns

WEAKEST = 1e-3
"""Singular value of a direction over the largest, below which it is left out: weights would have to move by hundreds to matter."""
MOST = 30
"""Directions for each set of weights."""
VALUES_AT_ONCE = 4_000_000


class Tangent:
    """A model's prediction and the leading directions in which it can change.

    With J = ∂p/∂w over some runs' block means, less its part along p, and J = U·diag(s)·Vᵀ, direction k moves the weights along v_k. Each direction
    is scaled to an RMS of 1 over those runs and stands at right angles to the prediction and to the others there. Where the same model is known
    with other weights w' as well, J = (∂p/∂w, p', ∂p'/∂w'): what it can become near here, near there and between.

    Attributes:
        model: a copy, on the CPU, that never changes.
        directions: (M, K) steps, along the columns of J.
        along: (K,) what each direction has of the prediction, taken out of it again.
    """

    def __init__(self, model: Model, runs: Sequence[Run], also: Sequence[Model] = ()) -> None:
        """Find the directions that matter.

        Args:
            model: trained.
            runs: where they matter.
            also: the same model with other weights.

        Raises:
            InputError: a run lacks a column that the model takes.
        """
        self.model = copy.deepcopy(model).cpu().eval()
        self.weights = [weights_of(one).cpu() for one in (self.model, *also)]
        self._known: dict[tuple[int, int], tuple[Tensor, Tensor]] = {}
        every = torch.eye(sum(len(one) for one in self.weights) + len(also), dtype=torch.float64)
        parts = [run.to("cpu") for run in runs]
        tables = [raw_columns(model, run) for run in parts]
        predicted = torch.cat([run.block_mean(self.predict(table)) for run, table in zip(parts, tables, strict=True)])
        jacobian = torch.cat([self._block_means(run, table, every) for run, table in zip(parts, tables, strict=True)])
        share = predicted @ jacobian / predicted.square().sum().clamp_min(1e-300)
        _, values, right = torch.linalg.svd(jacobian - predicted.unsqueeze(1) * share, full_matrices=False)
        kept = values[: MOST * len(self.weights)]
        kept = kept[kept > WEAKEST * values[:1]]
        self.directions = right[: len(kept)].mT * (len(predicted) ** 0.5 / kept)
        self.along = share @ self.directions

    def __deepcopy__(self, memo: dict[int, Any]) -> Tangent:
        """Itself: nothing in it changes, and all copies shall know what one has computed."""
        return self

    @property
    def size(self) -> int:
        """K, the number of directions."""
        return self.directions.shape[1]

    def predict(self, table: Tensor) -> Tensor:
        """(T, C) raw columns `model.inputs` of one run -> (T,) predicted error [output's unit]."""
        with torch.no_grad():
            predicted: Tensor = self.model(table)
        return predicted

    def columns(self, table: Tensor, run: int) -> Tensor:
        """Prediction and directions, remembered for each run.

        Args:
            table: (T, C) raw columns `model.inputs` of one run.
            run: its number.

        Returns:
            (T, 1+K) [output's unit], where the table is.
        """
        key = (run, len(table))
        if key not in self._known or not torch.equal(self._known[key][0], table):
            here = table.cpu()
            predicted = self.predict(here).unsqueeze(1)
            moved = self._moved(here, self.directions) - predicted * self.along
            self._known[key] = table, torch.cat([predicted, moved], dim=1).to(table.device)
        return self._known[key][1]

    def _block_means(self, run: Run, table: Tensor, directions: Tensor) -> Tensor:
        """(N, D) block means of what each of some directions (…, D) changes."""
        size = max(VALUES_AT_ONCE // len(table), 1)
        return torch.cat([run.block_mean_columns(self._moved(table, part)) for part in directions.split(size, dim=1)], dim=1)

    @torch.no_grad()
    def _moved(self, table: Tensor, directions: Tensor) -> Tensor:
        """(T, K) change of the prediction along each direction (M, K)."""
        head = Head(self.model)
        given = self.model.features(table) if isinstance(self.model, FeatureModel) else table
        size = len(self.weights[0])
        moved = _derivative(head, given, self.weights[0], directions[:size])
        for k, weights in enumerate(self.weights[1:]):
            own = directions[size + k * (size + 1) :][: size + 1]
            there = head.outputs(weights, given).unsqueeze(1)
            moved = moved + there * own[0] + _derivative(head, given, weights, own[1:])
        return moved


def _derivative(head: Head, given: Tensor, weights: Tensor, directions: Tensor) -> Tensor:
    """(T, K) derivative of the prediction along each direction (D, K) of the weights."""
    if not directions.numel():
        return given.new_zeros(len(given), directions.shape[1])

    def one(direction: Tensor) -> Tensor:
        change: Tensor = jvp(lambda vector: head.outputs(vector, given), (weights,), (direction,))[1]
        return change

    size = max(VALUES_AT_ONCE // max(given.numel(), 1), 1)
    return vmap(one, in_dims=1, out_dims=1, chunk_size=size)(directions)
