"""How steady a rate is over each averaging time."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor


def allan_deviation(rate: Tensor, step_s: float, factors: Sequence[int]) -> tuple[Tensor, Tensor]:
    """Overlapping Allan deviation of rates that are means over consecutive steps without gaps (IEEE Std 952, annex C).

    With the angle θ = h·Σ rate at the N = T + 1 ends of the steps and the averaging time τ = m·h,
    σ²(τ) = 1/(2τ²(N − 2m)) · Σ_k (θ_{k+2m} − 2θ_{k+m} + θ_k)².

    Args:
        rate: (..., T) [output's unit].
        step_s: h [s].
        factors: m, how many steps are averaged, F whole numbers from 1 up.

    Returns:
        τ: (F,) [s].
        σ: (..., F) [output's unit]; NaN where the series is shorter than 2m steps.
    """
    # Whatever is the same all along cancels; without it the sums keep their digits.
    angle = torch.nn.functional.pad(torch.cumsum(rate - rate.mean(-1, keepdim=True), -1), (1, 0))
    seconds = [(angle[..., 2 * m :] - 2 * angle[..., m:-m] + angle[..., : -2 * m]) / m for m in factors]
    deviation = torch.stack([second.square().mean(-1).sqrt() for second in seconds], -1) / math.sqrt(2)
    return step_s * torch.tensor(factors, dtype=rate.dtype, device=rate.device), deviation
