"""The weights of an exponential integrator: what a decaying mode makes of an input that is linear within a step."""

from __future__ import annotations

import math

import torch
from torch import Tensor

SERIES_BELOW = 1e-2
PHI_2 = tuple((-1.0) ** k / math.factorial(k + 2) for k in range(6, -1, -1))
"""φ2 = 1/2 − x/6 + x²/24 − …, to x⁶ (3e-20 is left at the limit), highest power first."""


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
    series = _series(x, PHI_2)
    phi_1 = torch.where(small, 1 - x * series, -torch.expm1(-safe) / safe)
    phi_2 = torch.where(small, series, (1 - phi_1) / safe)
    return torch.exp(-x), phi_1, phi_2


def _series(x: Tensor, terms: tuple[float, ...]) -> Tensor:
    """The polynomial with these coefficients, the constant one last (Horner)."""
    total = torch.full_like(x, terms[0])
    for term in terms[1:]:
        total = total * x + term  # numbers, not tensors: in an exported program these would stay on one device
    return total
