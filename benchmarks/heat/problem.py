"""A winding, its day in the chamber and what is asked of it: the same for every solver."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import torch

from zoo.physics.lag import lagged
from zoo.physics.winding import Coil, wind
from zoo.units import convert

LAYERS, TURNS, INNER_M, PITCH_M, TURN_PITCH_M = 36, 60, 0.045, 0.22e-3, 0.2e-3
CONDUCTIVITY, HEAT_CAPACITY = 0.30, 1.7e6  # W/m/K, J/m³/K
CONTACT, FILM = 300.0, 15.0  # W/m²/K to the spool inside, to the housing outside
SECONDS, LAG_S, SOAKED_C = 46_800, 900.0, -40.0
WIDTH_M = LAYERS * PITCH_M


@dataclass(frozen=True)
class Body:
    """C·dT/dt = −G·T + g·u, per metre of height, for one device or several.

    Attributes:
        capacity: (N,) C [J/K/m].
        conductance: (..., N, N) G [W/K/m].
        ambient: (..., N) g [W/K/m].
        layers: (36,) which nodes are the layers.
    """

    capacity: np.ndarray
    conductance: np.ndarray
    ambient: np.ndarray
    layers: np.ndarray

    def __getitem__(self, some: int | slice) -> Body:
        """Some of the devices."""
        return Body(self.capacity, self.conductance[some], self.ambient[some], self.layers)

    @property
    def matrix(self) -> np.ndarray:
        """(N, N) A of dT/dt = A·T + p·u [1/s]."""
        return -self.conductance / self.capacity[:, None]

    @property
    def pull(self) -> np.ndarray:
        """(N,) p [1/s]."""
        return self.ambient / self.capacity


@dataclass(frozen=True)
class Watched:
    """What is asked of the nodes: (O, N) weights of T, and of dT/dt [s]."""

    level: np.ndarray
    rate: np.ndarray

    def seen(self, body: Body, air: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        """(T, O) from the temperatures of all nodes, (T, N)."""
        weights, from_air = self.level + self.rate @ body.matrix, self.rate @ body.pull
        return torch.addmm(torch.from_numpy(np.outer(air, from_air)), torch.from_numpy(nodes), torch.from_numpy(weights.T)).numpy()


def body(conductivity: float | np.ndarray = CONDUCTIVITY, contact: float | np.ndarray = CONTACT, cuts: int = 1) -> Body:
    """Finite volumes with a node on both faces and in every layer, each interval cut into so many."""
    coarse = INNER_M + PITCH_M * np.concatenate([[0.0], np.arange(LAYERS) + 0.5, [LAYERS]])
    radius = np.interp(np.arange((LAYERS + 1) * cuts + 1) / cuts, np.arange(LAYERS + 2), coarse)
    ratio = np.log(radius[1:] / radius[:-1])
    faces = np.concatenate([radius[:1] ** 2, (radius[1:] ** 2 - radius[:-1] ** 2) / (2 * ratio), radius[-1:] ** 2])
    link = 2 * math.pi * np.asarray(conductivity)[..., None] / ratio
    ambient = np.zeros((*link.shape[:-1], len(radius)))
    ambient[..., 0], ambient[..., -1] = 2 * math.pi * INNER_M * np.asarray(contact), 2 * math.pi * radius[-1] * FILM
    left = np.arange(len(link.T))
    conductance = np.eye(len(radius)) * ambient[..., None]
    conductance[..., left, left] += link
    conductance[..., left + 1, left + 1] += link
    conductance[..., left, left + 1] = conductance[..., left + 1, left] = -link
    return Body(HEAT_CAPACITY * math.pi * np.diff(faces), conductance, ambient, cuts * (1 + np.arange(LAYERS)))


def air() -> np.ndarray:
    """(46 801,) of the housing and the spool [°C]: an hour at −40, −20, 0, 20, then 40 °C, ramps of 0.2 K/min between, seen through a lag."""
    corners, now = [(0.0, SOAKED_C), (3600.0, SOAKED_C)], 3600.0
    for target in (-20.0, 0.0, 20.0, 40.0):
        corners += [(now + 6000, target), (now + 9600, target)]
        now += 9600
    time = np.arange(SECONDS + 1.0)
    chamber = np.interp(time, *zip(*corners, strict=True))
    return lagged(torch.from_numpy(time), torch.from_numpy(chamber), torch.tensor(LAG_S, dtype=torch.float64)).numpy()


def all_layers(body: Body) -> Watched:
    """The temperature of every layer."""
    level = np.eye(len(body.capacity))[body.layers]
    return Watched(level, np.zeros_like(level))


def mean_and_shupe(body: Body) -> Watched:
    """Mean temperature of the fibre [°C] and Shupe's error [°/h]; a quadrupolar winding with half a turn too much or too little in a layer."""
    errors = 0.5 * torch.randn(LAYERS, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    winding = wind(Coil(LAYERS, TURNS, 2 * INNER_M + WIDTH_M, PITCH_M, TURN_PITCH_M), errors)
    level, rate = np.zeros((2, 2, len(body.capacity)))
    level[0, body.layers] = (winding.length.sum(1) / winding.length.sum()).numpy()
    rate[1, body.layers] = convert(winding.weights().sum(1).numpy(), "rad_per_s", "dph")
    return Watched(level, rate)
