"""Linear least squares on a batch of column sets: the inner half of variable projection."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

RIDGE, LEAST = 1e-10, 4.0
"""On the diagonal of a Gram matrix of unit norms, and how many times the precision of its numbers it is at least."""


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

    Columns count as scaled to unit norm; a ridge of 1e-10, in single precision 5e-7, keeps collinear columns harmless (their common amplitude is
    split between them).

    Args:
        columns: (..., N, K).
        target: (N,) or (..., N).
    """
    gram, right = columns.mT @ columns, columns.mT @ target.unsqueeze(-1)
    squares = gram.diagonal(dim1=-2, dim2=-1)
    norm = torch.where(squares > 0, squares, 1.0).sqrt().unsqueeze(-1)  # (..., K, 1)
    gram = gram / norm / norm.mT + ridge_of(gram)
    factor, _ = torch.linalg.cholesky_ex(gram)
    weights = torch.cholesky_solve(right / norm, factor) / norm
    residual = target - (columns @ weights).squeeze(-1)
    return Projection(weights.squeeze(-1), residual, residual.square().sum(-1))


def ridge_of(gram: Tensor) -> Tensor:
    """(K, K) for a Gram matrix (..., K, K) of columns of unit norm."""
    ridge = max(RIDGE, LEAST * torch.finfo(gram.dtype).eps)
    return ridge * torch.eye(gram.shape[-1], dtype=gram.dtype, device=gram.device)


def log_volume(columns: Tensor, scale: Tensor) -> tuple[float, int]:
    """Logarithm of the Gram determinant of columns, and how many there are that are not zero.

    Args:
        columns: (N, K), about as large as those that scale them: a ridge bounds what collinear ones add.
        scale: (N, K), by whose norms they are divided.
    """
    norm = scale.norm(dim=0)
    scaled = columns[:, norm > 0] / norm[norm > 0]
    gram = scaled.mT @ scaled
    return float(torch.logdet(gram + ridge_of(gram))), len(gram)


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
