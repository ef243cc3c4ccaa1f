"""The weights of an exponential integrator: what a decaying mode makes of an input that is linear within a step."""

from __future__ import annotations

import torch
from torch import Tensor

SERIES_BELOW = 1e-2


def exponential_weights(x: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """e^(−x), φ1 = (1 − e^(−x))/x and φ2 = (1 − φ1)/x for x ≥ 0, by series where the closed form would cancel.

    Hochbruck & Ostermann 2010, Acta Numerica 19:209.

    Args:
        x: (...) decay rate times step.

    Returns:
        Each (...).
    """
    small = x < SERIES_BELOW
    safe = torch.where(small, torch.ones_like(x), x)
    phi_1 = torch.where(small, _series(x, 1), -torch.expm1(-safe) / safe)
    phi_2 = torch.where(small, _series(x, 2), (1 - phi_1) / safe)
    return torch.exp(-x), phi_1, phi_2


def _series(x: Tensor, order: int) -> Tensor:
    """φ1 = 1 − x/2 + x²/6 − …, φ2 = 1/2 − x/6 + x²/24 − …, to x⁶ (5e-18 at the limit)."""
    total, term = torch.zeros_like(x), torch.ones_like(x)
    factor = 1.0 if order == 1 else 0.5
    for power in range(7):
        total = total + factor * term
        term = -term * x
        factor /= power + order + 1
    return total
