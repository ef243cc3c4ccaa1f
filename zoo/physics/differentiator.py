"""Rate of a measured temperature: the stated smoothing differentiator, causal and exact for any sampling."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.physics.carry import after_first, with_last
from zoo.physics.lag import lagged
from zoo.physics.recurrence import decaying

SMOOTHING_S = 60.0


def temperature_rate(time: Tensor, temperature: Tensor, tau: float = SMOOTHING_S) -> Tensor:
    """Rate of temperature through two equal lags in cascade, r = (x1 − x2)/τ with τ·dx1/dt = T − x1 and τ·dx2/dt = x1 − x2.

    Its transfer function is s/(1 + τs)². What follows from it:

    - a step D of the thermometer (its resolution) gives D·t/τ²·exp(−t/τ): never more than D/(e·τ), whatever the sampling rate;
    - a ramp gives its slope exactly after a few τ, late by 2τ;
    - before the first sample the temperature is taken to have been constant, so the rate starts at zero.

    The temperature is linear between samples. With b the slope over a step h, a = exp(−h/τ) and c = x1[k−1] − T[k−1] + b·τ, both lags
    are solved in closed form:  r[k] = a·r[k−1] + (1 − a)·b − a·(h/τ²)·c.  Inserting samples on the straight lines changes nothing.

    In the subset of Python that TorchScript takes: exported models have it inside.

    Args:
        time: (T,) strictly increasing [s].
        temperature: (..., T) [°C or K].
        tau: smoothing time τ [s], positive.

    Returns:
        (..., T) [K/min].
    """
    start = torch.zeros_like(temperature[..., 0])
    once = lagged(time, temperature, torch.full_like(start, tau))
    step, known, behind = torch.diff(with_last(time)), with_last(temperature), with_last(once)
    slope = torch.diff(known) / step
    ratio = step / tau
    decay = torch.exp(-ratio)
    behind = behind[..., :-1] - known[..., :-1] + slope * tau
    gain = -torch.expm1(-ratio) * slope - decay * ratio / tau * behind
    return 60.0 * after_first(start, decaying(ratio, gain, start))
