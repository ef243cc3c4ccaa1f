"""What the heat solver takes to be constant and is not: a gyro's coefficients at another temperature than 20 °C, and what that does to its ramps.

No simulation uses it: a test and `benchmarks/constant_coefficients.py` show by it what the simplification costs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from zoo.physics.composite import GLASS_W_PER_M_K, transverse_conductivity
from zoo.physics.materials import (
    air_conductivity,
    metal_capacity,
    polymer_capacity,
    polymer_conductivity,
    radiation,
    silica_capacity,
    silica_conductivity,
)
from zoo.physics.system import modes
from zoo.simulator.gyros.device import Device
from zoo.simulator.thermal.heat import heat, system, watched
from zoo.simulator.thermal.winding_weights import coil_weight

RADIATED = 0.3
"""Share of radiation in the film of the housing at 20 °C, an engineering prior: 4.6 W/m²/K of a painted surface (ε 0.8) beside 11 W/m²/K of a
chamber's stirred air. Bare metal has 0.05, a painted housing in still air 0.5."""
RADIATED_IN_GAP = 0.3
"""The same between winding and housing, an engineering prior: 3 W/m²/K beside the conduction of 4 mm of air."""
REFERENCE_C = 20.0
SAMPLES = 6000


def winding_capacity(device: Device, celsius: Tensor) -> Tensor:
    """ρc of the winding against that at 20 °C; glass and glue store about as much by volume."""
    share = device["glass_fraction"]
    return share * silica_capacity(celsius) + (1 - share) * polymer_capacity(celsius)


def winding_conductivity(device: Device, celsius: Tensor) -> Tensor:
    """k⊥ of the winding against that at 20 °C."""
    share = torch.as_tensor(device["glass_fraction"], dtype=celsius.dtype)

    def across(at: Tensor) -> Tensor:
        return transverse_conductivity(GLASS_W_PER_M_K * silica_conductivity(at), device["glue_conductivity"] * polymer_conductivity(at), share)

    return across(celsius) / across(torch.full_like(celsius, REFERENCE_C))


def housing_film(celsius: Tensor, radiated: float = RADIATED) -> Tensor:
    """Film between housing and chamber against that at 20 °C, where the fan keeps the air's speed.

    Forced convection is constant to some 5 %, k·√(1/ν) of air goes as T^0.05. Free convection goes as the fourth root of the difference as well.
    """
    return (1 - radiated) + radiated * radiation(celsius)


def gap_film(celsius: Tensor) -> Tensor:
    """Film between winding and housing against that at 20 °C: conduction through air that stands, and radiation."""
    return (1 - RADIATED_IN_GAP) * air_conductivity(celsius) + RADIATED_IN_GAP * radiation(celsius)


def at_temperature(device: Device, celsius: float, radiated: float = RADIATED) -> Device:
    """The gyro with the coefficients that it has at one temperature; contacts, screws and power are those at 20 °C.

    Args:
        device: with coefficients of 20 °C.
        celsius: temperature of the whole gyro and of the air around it [°C].
        radiated: share of radiation in the film of the housing at 20 °C.
    """
    here = torch.tensor(celsius, dtype=torch.float64)
    stored, metal, film = (float(one) for one in (winding_capacity(device, here), metal_capacity(here), housing_film(here, radiated)))
    coil = device.coil
    winding = device["heat_capacity"] * math.pi * coil.diameter_m * coil.radial_m * coil.height_m
    before = winding + device["spool_j_per_k"]
    inside = winding * stored + device["spool_j_per_k"] * metal
    whole = (inside + device["housing_j_per_k"] * metal) / (before + device["housing_j_per_k"])
    own = {
        "heat_capacity": device["heat_capacity"] * stored,
        "conductivity": device.conductivity * float(winding_conductivity(device, here)),
        "housing_j_per_k": device["housing_j_per_k"] * metal,
        "spool_j_per_k": device["spool_j_per_k"] * metal,
        "gap": device["gap"] * float(gap_film(here)),
        "mount_s": device["mount_s"] * inside / before,
        "package_s": device["package_s"] * whole / film,
        "self_heating_k": device["self_heating_k"] / film,
    }
    return replace(device, values={**device.values, **own})


@dataclass(frozen=True)
class Frozen:
    """What a long ramp of 1 K/min does to a gyro whose coefficients are those of one temperature.

    Attributes:
        celsius: that temperature [°C].
        slowest_s: slowest time constant [s].
        self_heating_k: rise over the air without a ramp [K].
        delay_s: of the coil behind the chamber's air [s].
        lead_k: of the housing before the coil [K].
        across_k: of the outermost layer before the innermost one [K].
        shupe_dph: largest Shupe error at the ramp's edge [°/h].
    """

    celsius: float
    slowest_s: float
    self_heating_k: float
    delay_s: float
    lead_k: float
    across_k: float
    shupe_dph: float


def bite(device: Device, temperatures: tuple[float, ...] = (-40.0, 20.0, 60.0), radiated: float = RADIATED) -> tuple[Frozen, ...]:
    """The same ramp with the coefficients of several temperatures: where these rows differ, constant coefficients bite.

    Args:
        device: with coefficients of 20 °C.
        temperatures: at which they are frozen [°C].
        radiated: share of radiation in the film of the housing at 20 °C.
    """
    return tuple(_ramped(at_temperature(device, celsius, radiated), celsius) for celsius in temperatures)


def _ramped(device: Device, celsius: float) -> Frozen:
    time = torch.linspace(0.0, 15 * device["package_s"], SAMPLES, dtype=torch.float64)
    air = celsius + (time - time[1]).clamp_min(0.0) / 60
    body = heat([device], time, air)
    slowest = modes(system([device], "radial", time), watched([device], time)).rate.min()
    late = (air - body.coil[0])[-1] - (air - body.coil[0])[0]
    lead, across = (float(one[0, -1]) for one in (body.housing - body.coil, body.outer - body.inner))
    shupe = abs(coil_weight(device)) * float(body.shupe.abs().max())
    return Frozen(celsius, 1 / float(slowest), device["self_heating_k"], 60 * float(late), lead, across, shupe)
