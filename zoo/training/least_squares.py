"""Closed form for models that are linear in their weights."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.prediction import block_features, raw_columns
from zoo.training.weights import VALUES_AT_ONCE, population_outputs, set_weights, weight_vector

Grids = Sequence[tuple[Run, Tensor]]
"""Runs and their features (T, F) on the fine grid."""


class LeastSquares:
    """Exact fit of the block means, by singular values with columns scaled to one length.

    The design matrix is read off the model itself: its outputs for the unit vectors of weights, less its output for none. They are computed on the
    fine grid and averaged then, as they are when the model is judged: the mean of a power is not the power of a mean, least of all of a rate.
    """

    follows_device = True

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
        grids = [(run, _fine_features(model, run)) for run in runs]
        size = len(weight_vector(model))
        offset, design = _affine(model, grids, size)
        _check_linear(model, grids, offset, design, generator)
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


def _fine_features(model: FeatureModel, run: Run) -> Tensor:
    with torch.no_grad():
        return model.features(raw_columns(model, run))


def _outputs(model: FeatureModel, weights: Tensor, grids: Grids) -> Tensor:
    """(P, M) block means of all runs for weights (P, D)."""
    every = []
    for run, features in grids:
        some = weights.split(max(VALUES_AT_ONCE // max(features.numel(), 1), 1))
        every.append(torch.cat([run.block_mean(population_outputs(model, part, features)) for part in some]))
    return torch.cat(every, dim=1)


def _affine(model: FeatureModel, grids: Grids, size: int) -> tuple[Tensor, Tensor]:
    """(M,) output without weights and (M, D) what each weight adds."""
    like = grids[0][1]
    zero = torch.zeros(1, size, dtype=like.dtype, device=like.device)
    unit = torch.eye(size, dtype=like.dtype, device=like.device)
    outputs = _outputs(model, torch.cat([zero, unit]), grids)
    return outputs[0], (outputs[1:] - outputs[0]).T


def _check_linear(model: FeatureModel, grids: Grids, offset: Tensor, design: Tensor, generator: Generator) -> None:
    trial = torch.randn(design.shape[1], generator=generator, dtype=design.dtype).to(design.device)
    expected = offset + design @ trial
    found = _outputs(model, trial.unsqueeze(0), grids)[0]
    if not torch.allclose(found, expected, rtol=1e-6, atol=1e-6 * float(expected.abs().max())):
        raise InputError(f"optimizer=least_squares cannot fit {type(model).__name__}, which is not linear in its weights; use adam or lbfgs")
