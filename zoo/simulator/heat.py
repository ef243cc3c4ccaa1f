"""A gyro as a heat network: housing, the layers of the winding from outside to inside, spool."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.physics.network import Network, rates, solve
from zoo.simulator.device import Device

LAYERS = 12
SECONDS_PER_MINUTE = 60.0


@dataclass(frozen=True, eq=False)
class Heat:
    """Temperatures of one run.

    Attributes:
        air: (T,) [°C].
        nodes: (T, N) housing, layers from outside to inside, spool [°C].
        rates: (T, N) their derivatives [K/min].
    """

    air: Tensor
    nodes: Tensor
    rates: Tensor

    @property
    def housing(self) -> Tensor:
        """(T,) [°C]."""
        return self.nodes[:, 0]

    @property
    def spool(self) -> Tensor:
        """(T,) [°C]."""
        return self.nodes[:, -1]

    @property
    def coil(self) -> Tensor:
        """(T,) mean over the winding [°C]."""
        return self.nodes[:, 1:-1].mean(1)

    @property
    def coil_rate(self) -> Tensor:
        """(T,) its derivative [K/min]."""
        return self.rates[:, 1:-1].mean(1)


def network(device: Device) -> Network:
    """The gyro's heat network

    The winding is cut into layers of equal thickness. A layer touches its neighbours through k·A/Δr, and through its two ends the flanges of the
    spool: a slab of height h heated from both faces has, for its mean temperature, the resistance h/(12·k·A), plus that of the contact.
    The innermost layer touches the spool's barrel, the outermost faces the housing through air.
    """
    barrel = math.pi * device["diameter_m"] * device["height_m"]
    ring = math.pi * device["diameter_m"] * device["radial_m"] / LAYERS
    thickness = device["radial_m"] / LAYERS
    layer = device["heat_capacity"] * ring * device["height_m"]
    flange = ring / (device["height_m"] / (12 * device["conductivity"]) + 1 / (2 * device["contact"]))
    inside = LAYERS * layer + device["spool_j_per_k"]
    capacity = torch.tensor([device["housing_j_per_k"], *[layer] * LAYERS, device["spool_j_per_k"]], dtype=torch.float64)
    link = torch.zeros(LAYERS + 2, LAYERS + 2, dtype=torch.float64)
    for place in range(1, LAYERS):
        link[place, place + 1] = device["conductivity"] * barrel / thickness
    link[1:-1, -1] = flange
    link[0, 1] = barrel / (1 / device["gap"] + thickness / 2 / device["conductivity"])
    link[LAYERS, -1] += barrel / (1 / device["contact"] + thickness / 2 / device["conductivity"])
    link[0, -1] = inside / device["mount_s"]
    air, power = torch.zeros_like(capacity), torch.zeros_like(capacity)
    air[0] = capacity.sum() / device["package_s"]
    power[0] = air[0] * device["self_heating_k"]
    return Network(capacity, link + link.mT, air, power)


def heat(device: Device, time: Tensor, air: Tensor, cold_start: bool = False) -> Heat:
    """Temperatures of one run.

    Args:
        device: the gyro.
        time: (T,) [s].
        air: (T,) [°C].
        cold_start: switched on at the first sample; otherwise long before.
    """
    body = network(device)
    nodes = solve(body, time, air, start=air[:1].expand(LAYERS + 2) if cold_start else None)
    return Heat(air, nodes, rates(body, nodes, air) * SECONDS_PER_MINUTE)


def weights(bend: float) -> Tensor:
    """(LAYERS,) share of each layer in Shupe's effect, from outside to inside.

    ∫(L − 2s) ds = 0 makes them odd about the winding's middle, so that a uniform rate gives nothing. Scaled so that a rate that falls linearly
    from the outer to the inner face, by 1 K/min, gives 1 (C_w, the winding's weight).

    Args:
        bend: how much more than linearly they grow towards the faces; −1 … 2 is sensible.
    """
    place = 0.5 - (torch.arange(LAYERS, dtype=torch.float64) + 0.5) / LAYERS
    raw = place * (1 + bend * (2 * place) ** 2)
    return raw / (raw * place).sum()
