"""What the rates of a winding's turns weigh in its error: Shupe's and Mohr's effects as integrals along the fibre."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.physics.winding import Winding, shupe_weight
from zoo.simulator.gyros.device import Device
from zoo.units import SECONDS_PER_MINUTE

FREE_LAYERS = 2.0
"""Depth in layers within which the free surface lets the outermost fibre expand differently, which makes Mohr's effect."""
BALANCED = 0.02
"""Share of the outermost layers' weights that is left of them in sum where a winding balances them, and Mohr's effect comes from elsewhere in it."""
SMALLEST = 1e-9
"""A coil's weight that counts as nothing, relative to that of a coil wound straight through."""


def of_turns(device: Device) -> Tensor:
    """(3, layers, turns) weights of the mean over the fibre, of Shupe's effect for C_w = 1 and of Mohr's for C_M = 1.

    Mohr's are Shupe's, as strong as each layer's coefficient is off; scaled by their sum. A coil that is blind to one of them keeps its own weights.
    """
    winding = device.winding
    mean = winding.length / winding.length.sum()
    weights = winding.weights()
    free, uneven = weights * _freedom(device), _unevenness(device)
    shupe = weights / (_sensitivity(winding) * SECONDS_PER_MINUTE) - lead_weight(device) * mean
    return torch.stack([mean, shupe, free / uneven if uneven else mean])


def lead_weight(device: Device) -> float:
    """Weight of the rate at which the leads warm before the coil, for C_w = 1.

    A lead that is longer by ℓ at one end adds ℓ·L·Ṫ_lead to ∫Ṫ·(L − 2s) ds and, as it moves the middle, takes away ℓ·∫Ṫ ds: n·n_T·ℓ/D·(Ṫ_lead − Ṫ).
    """
    full = device["index"] * device["thermo_optic_per_k"] * device["lead_asymmetry_m"] / device["diameter_m"]
    return full / SECONDS_PER_MINUTE / _sensitivity(device.winding)


def _sensitivity(winding: Winding) -> float:
    """What Shupe's column is multiplied by: C_w, or what all turns do together where the coil is blind to radial flow [rad/s per K/min]."""
    radial, scale = shupe_weight(winding), float(winding.weights().abs().sum()) / SECONDS_PER_MINUTE
    return radial if abs(radial) > SMALLEST * scale else scale or 1.0


def _unevenness(device: Device) -> float:
    """Mohr's effect of an outermost layer whose coefficient is twice the others', 0 where the coil is blind to it [rad/s per K/s]."""
    weights = device.winding.weights() * _freedom(device)
    uneven = float(weights.sum())
    return uneven if abs(uneven) > BALANCED * float(weights.abs().sum()) else 0.0


def coil_weight(device: Device) -> float:
    """C_w of the device's winding, the effect of rates that differ by 1 K/min between its faces [°/h]."""
    return math.degrees(shupe_weight(device.winding)) * 3600


def column_weight(device: Device) -> float:
    """What Shupe's column of the device is multiplied by [(°/h)/(K/min)]: C_w, unless the coil is blind to radial flow."""
    return math.degrees(_sensitivity(device.winding)) * 3600


def strain_per_k(device: Device, coefficient: float) -> float | None:
    """By how much the outermost layer's coefficient dn/dT + n·α has to be off for Mohr's effect to be this large [1/K]; None for a blind coil.

    Args:
        device: the gyro.
        coefficient: C_M [(°/h)/(K/min)].
    """
    full = math.degrees(_unevenness(device)) * 3600 / SECONDS_PER_MINUTE
    return coefficient / full * device["thermo_optic_per_k"] if full else None


def _freedom(device: Device) -> Tensor:
    """(layers, 1) how far each layer's coefficient is off, 1 for the outermost."""
    return torch.exp(-torch.arange(device.gyro.layers, dtype=torch.float64).flip(0) / FREE_LAYERS).unsqueeze(-1)
