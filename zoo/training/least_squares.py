"""Closed form for models that are linear in their weights."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.training.fine_blocks import standardised
from zoo.training.population import Population
from zoo.training.weights import set_weights, weight_vector


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
        size = len(weight_vector(model))
        whole, rows, error = standardised(model, runs)
        population = Population(whole, rows)
        offset, columns = population.affine()
        if not _is_linear(population, offset, columns, generator):
            raise InputError(f"optimizer=least_squares cannot fit {type(model).__name__}, which is not linear in its weights; use adam or lbfgs")
        set_weights(model, solve(columns.T, error - offset))
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


def _is_linear(population: Population, offset: Tensor, columns: Tensor, generator: Generator) -> bool:
    trial = torch.randn(len(columns), generator=generator, dtype=columns.dtype).to(columns.device)
    expected = offset + trial @ columns
    return torch.allclose(population.outputs(trial.unsqueeze(0))[0], expected, rtol=1e-6, atol=1e-6 * float(expected.abs().max()))
