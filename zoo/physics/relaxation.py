"""Relaxation whose speed changes with the temperature: stress in a potting, moisture in a winding."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.physics.carry import after_first, left, resumed, with_last
from zoo.physics.exponential import exponential_weights
from zoo.physics.materials import REFERENCE_K, ZERO_C_IN_K
from zoo.physics.recurrence import decaying

GAS_J_PER_MOL_K = 8.314462618
COLDEST_K = 100.0
"""Below this an Arrhenius factor is taken to stay as it is: a rate of nothing either way, and finite whatever a thermometer says."""


def arrhenius(temperature: Tensor, energy: Tensor) -> Tensor:
    """How much faster than at 20 °C a thermally activated process goes, exp(E/R·(1/T20 − 1/T)).

    Args:
        temperature: (..., T) [°C].
        energy: (..., 1) activation energy E [J/mol].

    Returns:
        (..., T), 1 at 20 °C.
    """
    kelvin = (temperature + ZERO_C_IN_K).clamp_min(COLDEST_K)
    return torch.exp(energy / GAS_J_PER_MOL_K * (1.0 / REFERENCE_K - 1.0 / kelvin))


def shifted(temperature: Tensor, decades: Tensor) -> Tensor:
    """How much faster than at 20 °C a polymer relaxes, 10^(k·(T − 20 °C)/100 K·T20/T): Arrhenius's law, told by its tangent at 20 °C.

    The law of Williams, Landel & Ferry bends more, and has a pole where the polymer freezes; this has none, and is one number instead of three.

    Args:
        temperature: (..., T) [°C].
        decades: (..., 1) k, in a hundred kelvins.

    Returns:
        (..., T), 1 at 20 °C.
    """
    return arrhenius(temperature, decades * (math.log(10.0) / 100.0 * GAS_J_PER_MOL_K * REFERENCE_K**2))


def elapsed(time: Tensor, speed: Tensor) -> Tensor:
    """Time as a process of this speed counts it, ∫ speed dt from the first sample, by the trapezoidal rule.

    Args:
        time: (T,) strictly increasing, any unit.
        speed: (..., T), any unit.

    Returns:
        (..., T), 0 at first.
    """
    clock, known = with_last(time), with_last(speed)
    none = torch.zeros_like(speed[..., 0])
    before = resumed(none)
    total = left(before.unsqueeze(-1) + torch.cumulative_trapezoid(known, clock, dim=-1), before)
    return after_first(none, total)


def maxwell(time: Tensor, drive: Tensor, speed: Tensor, start: Tensor | None = None) -> Tensor:
    """Stress of a Maxwell branch of unit stiffness, ds/dt = du/dt − v(t)·s.

    In the branch's own time ∫v dt this is a lag of 1 behind (du/dt)/v. With x = ∫v dt over a step (trapezoidal rule) and a drive linear in time:
    s[k] = e^(−x)·s[k−1] + (φ1 + (v[k] − v[k−1])/(v[k] + v[k−1])·(φ1 − 2φ2))·(u[k] − u[k−1]). Exact at a constant speed; of second order in the
    change of ln v within a step otherwise, however fast it relaxes.

    Args:
        time: (T,) strictly increasing [s].
        drive: (..., T) u, any unit.
        speed: (..., T) v, one over the time constant [1/s].
        start: (...) s at the first sample, by default 0.

    Returns:
        (..., T) s in the drive's unit.
    """
    clock, driven, fast = with_last(time), with_last(drive), with_last(speed)
    twice = fast[..., 1:] + fast[..., :-1]
    fallen = 0.5 * torch.diff(clock) * twice
    _, phi_1, phi_2 = exponential_weights(fallen)
    tilt = torch.diff(fast) / twice.clamp_min(1e-300)
    added = (phi_1 + tilt * (phi_1 - 2.0 * phi_2)) * torch.diff(driven)
    first = torch.zeros_like((drive + speed)[..., 0])
    first = first if start is None else first + start
    return after_first(first, decaying(fallen, added, first))
