"""One simulated gyro, drawn from its class."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from zoo.errors import InputError
from zoo.simulator.gyro_class import SPANS, GyroClass
from zoo.simulator.streams import Span, stream


@dataclass(frozen=True)
class Device:
    """One gyro: a number for every `Span` of its class, in the same units.

    Attributes:
        name: its class.
        values: every parameter by name.
        sensors: time constant [s] and offset [K] of each thermometer, the main one (at the spool) first.
        effects: spread of each effect's leading amplitude in its class.
        units: unit of every parameter.
    """

    name: str
    values: Mapping[str, float]
    sensors: tuple[tuple[float, float], ...]
    effects: Mapping[str, tuple[float, float]]
    units: Mapping[str, str]

    def __getitem__(self, parameter: str) -> float:
        return self.values[parameter]


def draw(gyro: GyroClass, seed: int, thermometers: int = 2) -> Device:
    """One gyro of a class.

    Args:
        gyro: the class.
        seed: which one.
        thermometers: how many it has, 1 or 2.

    Raises:
        InputError: another number of thermometers.
    """
    if thermometers not in {1, 2}:
        raise InputError(f"thermometers={thermometers}: 1 (at the spool) or 2 (at the spool and the housing) are possible")
    # A stream a parameter, so that fixing one does not change the others.
    spans = {key: getattr(gyro, key) for key in SPANS}
    values = {key: span.draw(stream(seed, "device", key)) for key, span in spans.items() if not key.startswith("sensor_")}
    sensors = tuple((_sensor(spans, "sensor_s", place, seed), _sensor(spans, "sensor_offset_c", place, seed)) for place in range(thermometers))
    return Device(gyro.name, values, sensors, gyro.effects, {key: span.unit for key, span in spans.items()})


def _sensor(spans: Mapping[str, Span], key: str, place: int, seed: int) -> float:
    return spans[key].draw(stream(seed, "device", key, place))
