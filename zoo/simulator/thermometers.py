"""Thermometers: late, offset, noisy and coarse."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from zoo.physics.lag import lagged
from zoo.simulator.gyros.device import Device
from zoo.simulator.noise import Noise
from zoo.simulator.plant import Scenario
from zoo.simulator.streams import normal, stream

COLUMNS = {"housing": "outer"}
"""Names of thermometers that are not called after their place."""


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


def readings(device: Device, run: Scenario, row: int, places: Sequence[str], noise: Noise) -> dict[str, Tensor]:
    """The columns of all thermometers of one device.

    Args:
        device: the gyro.
        run: temperatures of several gyros.
        row: which of them it is.
        places: where thermometers sit, the main one first.
        noise: noise of a reading and resolution.

    Returns:
        Each (T,) [°C] by its column.
    """
    table = {}
    for number, (place, sensor) in enumerate(zip(places, device.sensors, strict=True)):
        column = "temperature_c" if number == 0 else f"temperature_{COLUMNS.get(place, place)}_c"
        body = run.heat.at(place)
        chance = stream(device.seed, "thermometer", column, run.label)
        table[column] = reading(run.time.cpu(), (body[row] if body.dim() > 1 else body).cpu(), sensor, noise, chance)
    return table
