"""First-order lags: what a thermometer, a coil or a housing does to the temperature that drives it."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.physics.carry import after_first, is_carried, with_last
from zoo.physics.recurrence import affine, geometric


def lagged(time: Tensor, drive: Tensor, tau: Tensor, start: Tensor | None = None) -> Tensor:
    """Solution of τ·dx/dt = u(t) − x, exact for a drive that is linear between samples.

    With h the step, a = exp(−h/τ) and m = (τ/h)(1 − a):  x[k] = a·x[k−1] + (m − a)·u[k−1] + (1 − m)·u[k].

    Args:
        time: (T,) strictly increasing [s].
        drive: (..., T) u, any unit.
        tau: (...) time constant [s], positive.
        start: (...) x at the first sample; where None, the drive's first value (soaked).

    Returns:
        (..., T) x in the drive's unit.
    """
    steps, known = torch.diff(with_last(time)), with_last(drive)
    # But for rounding. Not asked of a chunk, whose steps may decide nothing where it is traced.
    even = not is_carried() and steps.numel() > 0 and bool((steps - steps[0]).abs().max() <= 1e-9 * steps[0])
    ratio = (steps[:1] if even else steps) / tau.unsqueeze(-1)
    decay = torch.exp(-ratio)
    mean = -torch.expm1(-ratio) / ratio
    forced = (mean - decay) * known[..., :-1] + (1 - mean) * known[..., 1:]
    first = drive[..., 0] if start is None else start
    first = first + torch.zeros_like(tau)
    rest = geometric(ratio.squeeze(-1), forced, first) if even else affine(decay, forced, first)
    return after_first(first, rest)


def lagged_rate(time: Tensor, drive: Tensor, tau: Tensor) -> Tensor:
    """Rate dx/dt = (u − x)/τ of a drive seen through a lag: a differentiator that cannot amplify a step of the drive by more than 1/τ.

    A thermometer's quantisation step Δ appears as a jump of Δ/τ that decays within τ, whatever the sampling rate. The estimate is causal and late by
    τ.

    Args:
        time: (T,) [s].
        drive: (..., T).
        tau: (...) smoothing time [s].

    Returns:
        (..., T) [drive's unit per second].
    """
    return (drive - lagged(time, drive, tau)) / tau.unsqueeze(-1)
