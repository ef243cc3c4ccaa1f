"""The weights of a network as the unknowns of a standardised least-squares problem: what searches, steps and ensembles all work on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import torch
from torch import Tensor

from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel
from zoo.models.prediction import block_features
from zoo.training.weights import member_outputs, population_outputs, weight_vector

ROWS_AT_ONCE = 32_768
"""Outputs computed at once: from here on what a small net makes of them no longer fits a core's cache, and more memory is all that is gained."""


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

    def residuals(self, weights: Tensor) -> Tensor:
        """(..., D) weights -> (..., M) what they leave of the error, in units of its spread."""
        flat = weights.reshape(-1, self.size)
        outputs = population_outputs(self.model, flat, self.features)
        return ((self.error - outputs) / self.scale).view(*weights.shape[:-1], -1)

    def losses(self, weights: Tensor) -> Tensor:
        """(..., D) weights -> (...) losses; memory does not grow with their number."""
        pieces = [self.residuals(some).square().mean(-1) for some in chunks(weights.reshape(-1, self.size), self.features)]
        return torch.cat(pieces).view(weights.shape[:-1])


def spread(error: Tensor) -> float:
    """Unit of the loss: standard deviation of (M,) errors [output's unit], or 1 where they never change."""
    return float(error.std(correction=0)) or 1.0


def chunks(weights: Tensor, features: Tensor) -> Iterator[Tensor]:
    """(P, D) weights in pieces of as many as are best evaluated on (..., M, F) features at once."""
    return iter(weights.split(max(ROWS_AT_ONCE // max(features.shape[-2], 1), 1)))


def losses_and_slopes(model: FeatureModel, weights: Tensor, features: Tensor, error: Tensor, scale: float) -> tuple[Tensor, Tensor]:
    """Losses of several members of an ensemble and their gradients, in bounded memory.

    Args:
        model: lends its structure and its buffers.
        weights: (E, D).
        features: (M, F) of all members, or (E, M, F) of each.
        error: (M,) or (E, M) [output's unit].
        scale: unit of the loss [output's unit].

    Returns:
        (E,) mean squared errors and (E, D) their derivatives.
    """
    found, start = [], 0
    for some in chunks(weights.detach(), features):
        own = slice(start, start + len(some))
        here = some.clone().requires_grad_()
        with torch.enable_grad():
            predicted = member_outputs(model, here, features[own] if features.ndim == 3 else features)
            losses = ((predicted - (error[own] if error.ndim == 2 else error)) / scale).square().mean(-1)
            (slopes,) = torch.autograd.grad(losses.sum(), here)
        found.append((losses.detach(), slopes))
        start = own.stop
    return torch.cat([one for one, _ in found]), torch.cat([one for _, one in found])
