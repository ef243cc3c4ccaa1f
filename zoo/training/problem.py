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
from zoo.training.weights import ROWS_AT_ONCE, VALUES_AT_ONCE, member_outputs, outputs_and_slopes, population_outputs, weight_vector

LINEAR = "least_squares"
"""What models that are linear in their weights say they are fitted by."""


class Problem:
    """Loss of a network as a function of its weights: squared error over the error's variance.

    Attributes:
        model: lends its structure and its buffers, standardised already.
        features: (M, F).
        error: (M,) [output's unit].
        scale: the error's standard deviation [output's unit]; 1 where it never changes.
        size: D, number of weights.
        places: (S, D/S) the groups of weights of which each sample sees one, see `FeatureModel.parts`.
        member: (M, S) 1 where a sample belongs to a group.
    """

    def __init__(self, model: FeatureModel, features: Tensor, error: Tensor) -> None:
        self.model, self.features, self.error = model, features, error
        self.scale = spread(error)
        self.size = len(weight_vector(model))
        self.places, part = model.parts(features)
        self.member = torch.nn.functional.one_hot(part, len(self.places)).to(error)
        self._linear = self._affine() if getattr(model, "fitted_by", "") == LINEAR and features.shape[0] * self.size <= VALUES_AT_ONCE else None

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

    def _affine(self) -> tuple[Tensor, Tensor]:
        """(M,) output without weights and (D, M) what each weight adds."""
        unit = torch.eye(self.size + 1, self.size, dtype=self.features.dtype, device=self.features.device).roll(1, dims=0)
        outputs = population_outputs(self.model, unit, self.features)
        return outputs[0], outputs[1:] - outputs[0]

    def outputs(self, weights: Tensor) -> Tensor:
        """(P, D) weights -> (P, M) predicted errors [output's unit]; one product where the model is linear in its weights."""
        if self._linear is None:
            return population_outputs(self.model, weights, self.features)
        return torch.addmm(self._linear[0], weights, self._linear[1])

    def losses(self, weights: Tensor) -> Tensor:
        """(..., D) weights -> (...) losses; memory does not grow with their number."""
        pieces = chunks(weights.reshape(-1, self.size), self.features)
        lengths = torch.cat([vector_norm(self.error - self.outputs(some), dim=-1) for some in pieces]) / self.scale
        return (lengths.square() / len(self.error)).view(weights.shape[:-1])

    def losses_of_parts(self, weights: Tensor) -> Tensor:
        """What the samples of each group of weights add to the loss, so that the groups can be searched for side by side.

        Args:
            weights: (..., S, P, D/S), group by group.

        Returns:
            (..., S, P).
        """
        joined = torch.empty((*weights.shape[:-3], weights.shape[-2], self.size), dtype=weights.dtype, device=weights.device)
        joined[..., self.places] = weights.movedim(-3, -2)
        if len(self.places) == 1:
            return self.losses(joined).unsqueeze(-2)
        pieces = chunks(joined.reshape(-1, self.size), self.features)
        squares = [((self.error - self.outputs(some)) / self.scale).square() @ self.member for some in pieces]
        return (torch.cat(squares) / len(self.error)).view(*joined.shape[:-1], -1).movedim(-1, -2)

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
