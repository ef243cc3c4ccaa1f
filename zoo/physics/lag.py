"""First-order lags: what a thermometer, a coil or a housing does to the temperature that drives it."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.physics.carry import after_first, with_last
from zoo.physics.recurrence import decaying


def lagged(time: Tensor, drive: Tensor, tau: Tensor, start: Tensor | None = None) -> Tensor:
    """Solution of τ·dx/dt = u(t) − x, exact for a drive that is linear between samples.

    Args:
        time: (T,) strictly increasing [s].
        drive: (..., T) u, any unit.
        tau: (...) time constant [s], positive.
        start: (...) x at the first sample; where None, the drive's first value (soaked).

    Returns:
        (..., T) x in the drive's unit.
    """
    return drive - behind(time, drive, tau, start)


def behind(time: Tensor, drive: Tensor, tau: Tensor, start: Tensor | None = None) -> Tensor:
    """By how much the solution x of `lagged` is behind what drives it, e = u − x; e/τ is its rate.

    With h the step, a = exp(−h/τ) and m = (τ/h)(1 − a):  e[k] = a·e[k−1] + m·(u[k] − u[k−1]).

    Arguments as of `lagged`; returns (..., T) e in the drive's unit.
    """
    changes = torch.diff(with_last(drive))
    ratio = torch.diff(with_last(time)) / tau.unsqueeze(-1)
    first = drive[..., 0] - (drive[..., 0] if start is None else start) + torch.zeros_like(tau)
    return after_first(first, decaying(ratio, _share(ratio) * changes, first))


def _share(ratio: Tensor) -> Tensor:
    """(..., T−1) of what the drive changes by in a step, what x has not followed at its end, from the step's length over τ."""
    return -torch.expm1(-ratio) / ratio


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
    return behind(time, drive, tau) / tau.unsqueeze(-1)
