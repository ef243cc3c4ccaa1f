"""One simulated gyro, drawn from its class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor

from zoo.physics.composite import GLASS_W_PER_M_K, transverse_conductivity
from zoo.physics.winding import Coil, Winding, balancing_trim, wind
from zoo.simulator.gyros.gyro_class import SPANS, GyroClass
from zoo.simulator.streams import Span, normal, stream

PER_DEVICE = tuple(key for key in SPANS if not key.startswith("sensor_"))


@dataclass(frozen=True)
class Device:
    """One gyro: its design, and a number for every `Span` of its class, in the same units.

    Attributes:
        gyro: its class.
        seed: which one of the class.
        values: every parameter by name.
        sensors: time constant [s] and offset [K] of each thermometer, the main one first.
    """

    gyro: GyroClass
    seed: int
    values: Mapping[str, float]
    sensors: tuple[tuple[float, float], ...]

    def __getitem__(self, parameter: str) -> float:
        return self.values[parameter]

    @property
    def name(self) -> str:
        """Its class."""
        return self.gyro.name

    @property
    def coil(self) -> Coil:
        """The winding's geometry."""
        gyro, keys = self.gyro, ("diameter_m", "layer_pitch_m", "turn_pitch_m")
        sizes = {key: self[key] for key in keys}
        return Coil(gyro.layers, gyro.turns, **sizes, pattern=gyro.pattern, index=self["index"], thermo_optic_per_k=self["thermo_optic_per_k"])

    @cached_property
    def winding(self) -> Winding:
        """The winding with this device's own errors, and trimmed if gyros of its class are."""
        errors = self["winding_error_turns"] * normal(2 * self.gyro.layers, stream(self.seed, "device", "winding")).reshape(-1, 2)
        trim = balancing_trim(self.coil, errors, self["trimmed"]) if self["trimmed"] > 0 else 0.0
        return wind(self.coil, errors, trim)

    @property
    def conductivity(self) -> float:
        """Of the winding across the fibre [W/m/K]."""
        glass, glue, share = (torch.tensor(one, dtype=torch.float64) for one in (GLASS_W_PER_M_K, self["glue_conductivity"], self["glass_fraction"]))
        return self["conductivity"] or float(transverse_conductivity(glass, glue, share))

    def described(self) -> dict[str, tuple[float, str]]:
        """Every parameter and what follows from them, with units."""
        drawn = {key: (value, getattr(self.gyro, key).unit) for key, value in self.values.items()}
        return {**drawn, "conductivity": (self.conductivity, "W/m/K"), "fibre_m": (self.winding.fibre_m, "m")}


def draw(gyro: GyroClass, seed: int, thermometers: int = 2) -> Device:
    """One gyro of a class.

    Args:
        gyro: the class.
        seed: which one.
        thermometers: how many it has.
    """
    # A stream a parameter, so that fixing one does not change the others.
    values = {key: getattr(gyro, key).draw(stream(seed, "device", key)) for key in PER_DEVICE}
    sensors = tuple((_sensor(gyro.sensor_s, "sensor_s", place, seed), _offset(gyro, place, seed)) for place in range(thermometers))
    return Device(gyro, seed, values, sensors)


def stacked(devices: Sequence[Device], key: str, like: Tensor) -> Tensor:
    """(B,) one parameter of several devices."""
    return torch.tensor([device[key] for device in devices], dtype=like.dtype, device=like.device)


def _offset(gyro: GyroClass, place: int, seed: int) -> float:
    """Calibration error and self-heating of a thermometer [K]."""
    return _sensor(gyro.sensor_offset_c, "sensor_offset_c", place, seed) + _sensor(gyro.sensor_heating_k, "sensor_heating_k", place, seed)


def _sensor(span: Span, key: str, place: int, seed: int) -> float:
    return span.draw(stream(seed, "device", key, place))
