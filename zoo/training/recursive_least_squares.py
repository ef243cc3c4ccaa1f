"""Recursive least squares: rows of a linear problem one after the other, or many at a time, in bounded memory."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor


class Information(NamedTuple):
    """What some rows say of θ (D,): P⁻¹ = RᵀR and R·θ = z.

    Attributes:
        triangle: (D+1, D+1) upper triangular [R z; 0 ρ], where ρ² is what the rows leave, ‖y − Φ·θ‖² + ‖θ‖²/α.
    """

    triangle: Tensor

    @property
    def estimate(self) -> Tensor:
        """(D,) θ."""
        return torch.linalg.solve_triangular(self.triangle[:-1, :-1], self.triangle[:-1, -1:], upper=True).squeeze(-1)

    @property
    def cost(self) -> float:
        """ρ²."""
        return float(self.triangle[-1, -1].square())


def begin(size: int, alpha: float, like: Tensor) -> Information:
    """θ0 = 0 and P0 = αI.

    Args:
        size: D.
        alpha: α, above 0; the larger, the less the start matters.
        like: gives precision and device.
    """
    triangle = alpha**-0.5 * torch.eye(size + 1, dtype=like.dtype, device=like.device)
    triangle[-1, -1] = 0.0
    return Information(triangle)


def learn(known: Information, rows: Tensor, targets: Tensor) -> Information:
    """Take in more rows, by orthogonal transformations of the root of the information (Golub 1965, Numer. Math. 7:206).

    θ is that of θ ← θ + P·φ·(y − φᵀθ), P ← P − P·φ·φᵀ·P/(1 + φᵀ·P·φ), row by row; but a large α leaves no rounding behind in P, and a block of rows
    costs one factorisation.

    Args:
        known: so far.
        rows: (N, D).
        targets: (N,).
    """
    together = torch.cat([known.triangle, torch.cat([rows, targets.unsqueeze(-1)], dim=-1)])
    return Information(torch.linalg.qr(together, mode="r")[1])
