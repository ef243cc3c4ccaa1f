"""Linear least squares on a batch of column sets: the inner half of variable projection."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

RIDGE = 1e-10


class Projection(NamedTuple):
    """Result of projecting a target on columns.

    Attributes:
        amplitudes: (..., K).
        residual: (..., N).
        cost: (...) sum of squared residuals.
    """

    amplitudes: Tensor
    residual: Tensor
    cost: Tensor


def project(columns: Tensor, target: Tensor) -> Projection:
    """Least-squares amplitudes of each column set.

    As if columns had unit norm, a ridge of 1e-10 keeps collinear columns harmless (their common amplitude is split between them).

    Args:
        columns: (..., N, K).
        target: (N,) or (..., N).
    """
    gram, right = columns.mT @ columns, (columns.mT @ target.unsqueeze(-1)).squeeze(-1)
    norm = gram.diagonal(dim1=-2, dim2=-1).sqrt().clamp_min(torch.finfo(gram.dtype).tiny)
    gram = gram / norm.unsqueeze(-1) / norm.unsqueeze(-2)
    gram.diagonal(dim1=-2, dim2=-1).add_(RIDGE)
    factor, _ = torch.linalg.cholesky_ex(gram)
    weights = torch.cholesky_solve((right / norm).unsqueeze(-1), factor).squeeze(-1) / norm
    residual = target - (columns @ weights.unsqueeze(-1)).squeeze(-1)
    return Projection(weights, residual, residual.square().sum(-1))


def orthonormal(columns: Tensor, tolerance: float = 1e-7) -> Tensor:
    """An orthonormal basis of the span of columns (N, K) -> (N, R), directions weaker than `tolerance` dropped."""
    scaled = columns / columns.norm(dim=-2, keepdim=True).clamp_min(1e-300)
    left, values, _ = torch.linalg.svd(scaled, full_matrices=False)
    return left[:, values > tolerance * values.max()] if values.numel() else left


def complement(columns: Tensor, basis: Tensor) -> Tensor:
    """What is left of columns (..., N, K) outside the span of an orthonormal basis (N, R)."""
    apart = columns.movedim(-2, 0)
    wide = apart.reshape(len(apart), -1)  # two matrix products, whatever the batch
    return (wide - basis @ (basis.mT @ wide)).reshape(apart.shape).movedim(0, -2)
