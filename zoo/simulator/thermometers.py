"""Thermometers: late, offset, noisy and coarse."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.physics.lag import lagged
from zoo.simulator.device import Device
from zoo.simulator.heat import Heat
from zoo.simulator.noise import Noise
from zoo.simulator.streams import normal, stream

COLUMNS = ("temperature_c", "temperature_outer_c")


def quantised(value: Tensor, step: float) -> Tensor:
    """Whole multiples of a step; unchanged where the step is 0."""
    return (value / step).round() * step if step > 0 else value


def reading(time: Tensor, place: Tensor, sensor: tuple[float, float], noise: Noise, generator: torch.Generator) -> Tensor:
    """What a thermometer shows.

    Args:
        time: (T,) [s].
        place: (T,) temperature where it sits [°C].
        sensor: time constant [s] and offset [K].
        noise: noise of a reading and resolution.
        generator: source of chance.

    Returns:
        (T,) [°C].
    """
    tau, offset = sensor
    late = lagged(time, place, torch.tensor(tau, dtype=time.dtype))
    return quantised(late + offset + noise.thermometer_c * normal(len(time), generator), noise.resolution_c)


def readings(device: Device, time: Tensor, heat: Heat, noise: Noise, seed: int, run: object) -> dict[str, Tensor]:
    """The columns of all thermometers: the main one sits at the spool, the other at the housing.

    Args:
        device: the gyro.
        time: (T,) [s].
        heat: temperatures of the run.
        noise: noise of a reading and resolution.
        seed: the user's.
        run: which run.

    Returns:
        Each (T,) [°C] by its column.
    """
    places = zip(COLUMNS, (heat.spool, heat.housing), device.sensors, strict=False)
    return {name: reading(time, place, sensor, noise, stream(seed, "thermometer", name, run)) for name, place, sensor in places}
