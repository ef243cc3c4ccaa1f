"""Closed form for models that are linear in their weights."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.training.fine_blocks import standardised
from zoo.training.weights import VALUES_AT_ONCE, population_outputs, set_weights, weight_vector


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
        offset, design = _affine(whole, rows)
        if not _is_linear(whole, rows, offset, design, generator):
            raise InputError(f"optimizer=least_squares cannot fit {type(model).__name__}, which is not linear in its weights; use adam or lbfgs")
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


def _affine(whole: FeatureModel, rows: Tensor) -> tuple[Tensor, Tensor]:
    """(M,) output without weights and (M, D) what each weight adds."""
    size = len(weight_vector(whole))
    unit = torch.eye(size + 1, size, dtype=rows.dtype, device=rows.device).roll(1, dims=0)
    outputs = torch.cat([population_outputs(whole, some, rows) for some in unit.split(max(VALUES_AT_ONCE // max(rows.numel(), 1), 1))])
    return outputs[0], (outputs[1:] - outputs[0]).T


def _is_linear(whole: FeatureModel, rows: Tensor, offset: Tensor, design: Tensor, generator: Generator) -> bool:
    trial = torch.randn(design.shape[1], generator=generator, dtype=design.dtype).to(design.device)
    expected = offset + design @ trial
    found = population_outputs(whole, trial.unsqueeze(0), rows)[0]
    return torch.allclose(found, expected, rtol=1e-6, atol=1e-6 * float(expected.abs().max()))
