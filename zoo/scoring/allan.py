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


def pooled_allan_deviation(pieces: Sequence[Tensor], step_s: float, factors: Sequence[int]) -> tuple[Tensor, Tensor]:
    """The same of several series that do not join, such as those between the gaps of a recording: every second difference counts once.

    Args:
        pieces: (T,) each.
        step_s: h [s].
        factors: m, F whole numbers from 1 up.

    Returns:
        τ: (F,) [s].
        σ: (F,) [output's unit]; NaN where every series is shorter than 2m steps.
    """
    counts = torch.tensor([[max(len(piece) + 1 - 2 * m, 0) for m in factors] for piece in pieces], dtype=torch.float64)
    each = [allan_deviation(piece, step_s, factors) for piece in pieces]
    squares = torch.stack([deviation for _, deviation in each]).square().nan_to_num(0.0)
    return each[0][0], ((counts * squares).sum(0) / counts.sum(0)).sqrt()


def expected_allan_deviation(tau: Tensor, step_s: float, white: float, flicker: float, walk: float) -> Tensor:
    """Allan deviation of white noise, flicker and random walk together, σ² = w²·h/τ + (2 ln 2/π)·B² + K²·τ/3 (IEEE Std 952, annex C).

    Args:
        tau: (F,) averaging time [s].
        step_s: h [s].
        white: w, RMS of a mean over one step [output's unit].
        flicker: bias instability B [output's unit].
        walk: rate random walk K [output's unit per √h].

    Returns:
        (F,) [output's unit].
    """
    return (white**2 * step_s / tau + 2 * math.log(2) / math.pi * flicker**2 + walk**2 * tau / 3600 / 3).sqrt()
