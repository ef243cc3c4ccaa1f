"""The weights of a network as the unknowns of a standardised least-squares problem: what searches, steps and ensembles all work on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import torch
from torch import Tensor
from torch.linalg import vector_norm

from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel
from zoo.models.prediction import block_features
from zoo.training.population import Population
from zoo.training.weights import ROWS_AT_ONCE, outputs_and_slopes, weight_vector


class Problem:
    """Loss of a network as a function of its weights: squared error over the error's variance.

    Attributes:
        model: lends its structure and its buffers, standardised already.
        features: (M, F).
        error: (M,) [output's unit].
        scale: the error's standard deviation [output's unit]; 1 where it never changes.
        size: D, number of weights.
    """

    def __init__(self, model: FeatureModel, features: Tensor, error: Tensor) -> None:
        self.model, self.features, self.error = model, features, error
        self.scale = spread(error)
        self.size = len(weight_vector(model))
        self.population = Population(model, features)

    @classmethod
    def of_runs(cls, model: FeatureModel, runs: Sequence[Run], device: str = "cpu") -> Problem:
        """The block means of some runs as a problem on a device, where the model is standardised on them and moved to.

        Raises:
            InputError: no block to fit.
        """
        features, error = RunsDataModule(runs, [], lambda run: block_features(model, run)).fitted
        model.standardise(features, error)
        model.to(device)
        return cls(model, features.to(device), error.to(device))

    def losses(self, weights: Tensor) -> Tensor:
        """(..., D) weights -> (...) losses; memory does not grow with their number."""
        lengths = self.population.costs(weights.reshape(-1, self.size), lambda some: vector_norm(self.error - some, dim=-1)) / self.scale
        return (lengths.square() / len(self.error)).view(weights.shape[:-1])

    def normal_equations(self, weights: Tensor) -> tuple[Tensor, Tensor]:
        """JᵀJ and Jᵀr of the mean squared residual, so that they go with `losses`; in bounded memory.

        Args:
            weights: (E, D).

        Returns:
            (E, D, D) and (E, D), J being the derivative of the outputs and r the residual, both in units of the error's spread and over √M.
        """
        found = [self._normal_equations(some) for some in chunks(weights, self.features)]
        return torch.cat([one for one, _ in found]), torch.cat([one for _, one in found])

    def _normal_equations(self, weights: Tensor) -> tuple[Tensor, Tensor]:
        count, unit = len(weights), self.scale * len(self.error) ** 0.5
        normal, slope = weights.new_zeros(count, self.size, self.size), weights.new_zeros(count, self.size)
        for features, error in zip(self.features.split(ROWS_AT_ONCE), self.error.split(ROWS_AT_ONCE), strict=True):
            rows = weights.repeat_interleave(len(features), dim=0)
            outputs, slopes = outputs_and_slopes(self.model, rows, features.repeat(count, 1))
            jacobian = slopes.view(count, -1, self.size) / unit
            normal += jacobian.mT @ jacobian
            slope += (jacobian.mT @ ((error - outputs.view(count, -1)) / unit).unsqueeze(-1)).squeeze(-1)
        return normal, slope


def spread(error: Tensor) -> float:
    """Unit of the loss: standard deviation of (M,) errors [output's unit], or 1 where they never change."""
    return float(error.std(correction=0)) or 1.0


def chunks(weights: Tensor, features: Tensor) -> Iterator[Tensor]:
    """(P, D) weights in pieces of as many as are best evaluated on (..., M, F) features at once."""
    return iter(weights.split(max(ROWS_AT_ONCE // max(features.shape[-2], 1), 1)))
