"""The two beams of a quartz vibrating-beam accelerometer: one pulled and one pressed by the proof mass, their difference of frequency counted.

Beam i, at its own temperature T_i, vibrates at f_i·(1 + β(T_i − T_0i)²), the parabola of a quartz tuning fork; f_i = f ± (offset + scale·force)/2 is
what the proof mass makes of it. What both beams do alike cancels; what is left of the temperature is the difference of their turnover temperatures
T_0i, the scale factor's change, and, after power-on, the difference of the beams' temperatures, which the steep flank of the parabola far below T_0i
turns into pulses.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import torch
from torch import Tensor

from zoo.simulator.accelerometer.preset import Accelerometer

CALIBRATED_C = 25.0
NODES = 5


def beam_temperatures(device: Accelerometer, start_c: float, ends: Tensor, gate_s: float) -> Tensor:
    """Temperatures of the two beams after power-on in a chamber where everything has soaked.

    T = T_start + A_u(1 − exp(−t/τ_u)) + (A ± G/2)(1 − exp(−t/τ)): the unit warms slowly, the accelerometer in it quickly.

    Args:
        device: the accelerometer.
        start_c: the chamber's temperature [°C].
        ends: (T,) ends of the counts after power-on [s].
        gate_s: length of a count [s].

    Returns:
        (2, T, J) at the J Gauss–Legendre nodes of each count [°C].
    """
    nodes, _ = _gauss()
    time = ends.unsqueeze(-1) + (nodes - 1) * gate_s
    unit = -device["unit_heating"] * torch.expm1(-time / device["unit_time"])
    own = -torch.expm1(-time / device["heating_time"])
    sides = torch.tensor([0.5, -0.5], dtype=time.dtype).reshape(2, 1, 1)
    return start_c + unit + (device["heating"] + sides * device["gradient"]) * own


def over_gate(values: Tensor) -> Tensor:
    """(..., T, J) at the nodes of `beam_temperatures` -> (..., T) means over the counts."""
    return values @ _gauss()[1]


@cache
def _gauss() -> tuple[Tensor, Tensor]:
    """(J,) nodes and weights of Gauss and Legendre on 0…1."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    return torch.from_numpy(nodes + 1) / 2, torch.from_numpy(weights) / 2


def expected_pulses(device: Accelerometer, force_g: float, gate_s: float) -> float:
    """Pulses of one count by the calibration at 25 °C."""
    return gate_s * (device["offset"] + device["scale"] * force_g)


def drift_pulses(device: Accelerometer, beams: Tensor, force_g: float, gate_s: float) -> dict[str, Tensor]:
    """What the temperature adds to the expected pulses of each count, by cause.

    Args:
        device: the accelerometer.
        beams: (2, T, J) of `beam_temperatures` [°C].
        force_g: specific force along the axis [g].
        gate_s: length of a count [s].

    Returns:
        (T,) each [pulses]: at the temperature that the beams have in common without a force, by the beams' difference of temperature, and by the
        change of the scale factor, the parabola's and the drift's.
    """
    alike = beams.mean(0).expand_as(beams)
    static, loaded = _bent(device, alike, 0.0), _bent(device, alike, force_g)
    drift = device["scale"] * force_g * device["scale_drift"] * (alike[0] - CALIBRATED_C)
    parts = {"static_bias": static, "thermal_gradient": _bent(device, beams, force_g) - loaded, "scale_factor": loaded - static + drift}
    return {name: gate_s * over_gate(part) for name, part in parts.items()}


def _bent(device: Accelerometer, beams: Tensor, force_g: float) -> Tensor:
    """(T, J) what the two parabolas make of the difference of frequency [Hz]."""
    half = (device["offset"] + device["scale"] * force_g) / 2
    pulled = (device["frequency"] + half) * (beams[0] - device["turnover_1"]).square()
    pressed = (device["frequency"] - half) * (beams[1] - device["turnover_2"]).square()
    return device["parabola"] * (pulled - pressed)
