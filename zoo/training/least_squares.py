"""Closed form for models that are linear in their weights."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.prediction import block_features
from zoo.training.weights import population_outputs, set_weights, weight_vector


class LeastSquares:
    """Exact fit of the block means, by singular values with columns scaled to one length.

    The design matrix is read off the model itself: its outputs for the unit vectors of weights, less its output for none.
    """

    def fit(self, model: Model, runs: Sequence[Run], generator: Generator) -> int:
        """Fit a model in place.

        Args:
            model: a `FeatureModel` that is linear in its weights.
            runs: fitted.
            generator: source of chance, to test linearity with.

        Returns:
            Evaluations of the model.

        Raises:
            InputError: the model is no such model.
        """
        if not isinstance(model, FeatureModel):
            raise InputError(f"optimizer=least_squares cannot fit {type(model).__name__}, which is no map of features; leave optimizer=auto")
        features, error = RunsDataModule(runs, [], lambda run: block_features(model, run)).fitted
        model.standardise(features, error)
        size = len(weight_vector(model))
        offset, design = _affine(model, features, size)
        _check_linear(model, features, offset, design, generator)
        set_weights(model, solve(design, error - offset))
        return size + 2


def solve(design: Tensor, target: Tensor) -> Tensor:
    """Least squares of smallest norm.

    Args:
        design: (M, D), of any rank.
        target: (M,).

    Returns:
        (D,).
    """
    length = design.norm(dim=0)
    length = torch.where(length > 0, length, torch.ones_like(length))
    # gelsd is LAPACK's only driver that is at ease with dependent columns (a hold has no temperature rate).
    solution = torch.linalg.lstsq((design / length).cpu(), target.cpu().unsqueeze(-1), driver="gelsd", rcond=1e-12).solution
    return solution.squeeze(-1).to(design.device) / length


def _affine(model: FeatureModel, features: Tensor, size: int) -> tuple[Tensor, Tensor]:
    """(M,) output without weights and (M, D) what each weight adds."""
    zero = torch.zeros(1, size, dtype=features.dtype, device=features.device)
    unit = torch.eye(size, dtype=features.dtype, device=features.device)
    outputs = population_outputs(model, torch.cat([zero, unit]), features)
    return outputs[0], (outputs[1:] - outputs[0]).T


def _check_linear(model: FeatureModel, features: Tensor, offset: Tensor, design: Tensor, generator: Generator) -> None:
    trial = torch.randn(design.shape[1], generator=generator, dtype=design.dtype).to(design.device)
    expected = offset + design @ trial
    found = population_outputs(model, trial.unsqueeze(0), features)[0]
    if not torch.allclose(found, expected, rtol=1e-6, atol=1e-6 * float(expected.abs().max())):
        raise InputError(f"optimizer=least_squares cannot fit {type(model).__name__}, which is not linear in its weights; use adam or lbfgs")
