"""Classes of gyros: what is alike in them, and how far the rest is spread."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from zoo.errors import InputError, nearest
from zoo.simulator.streams import Span


@dataclass(frozen=True)
class GyroClass:
    """What gyros of one class have in common: the spread of what differs from one to the next.

    Spreads of noise, heat paths, thermometers and effects are engineering priors from published gyros; masses and contacts likewise.

    Attributes:
        name: the class.
        diameter_m: mean diameter of the coil.
        radial_m: radial thickness of the winding.
        height_m: axial height of the winding.
        conductivity: of the winding, across the fibre.
        heat_capacity: of the winding, by volume.
        housing_j_per_k: heat capacity of housing and electronics.
        spool_j_per_k: heat capacity of the spool.
        package_s: time constant of the whole gyro against the air.
        mount_s: time constant of spool and coil against the housing.
        contact: between winding and spool.
        gap: between winding and housing, through the air.
        self_heating_k: how much hotter than the air the electronics make the gyro.
        sensor_s: time constant of a thermometer.
        sensor_offset_c: error of a thermometer.
        bend: how much the winding's weight grows towards its faces, on top of a straight line.
        random_walk: N.
        flicker: B.
        rate_random_walk: K.
        effects: spread of each effect's leading amplitude by the effect's name, in the output's unit.
    """

    name: str
    diameter_m: Span
    radial_m: Span
    height_m: Span
    housing_j_per_k: Span
    spool_j_per_k: Span
    package_s: Span
    self_heating_k: Span
    random_walk: Span
    flicker: Span
    rate_random_walk: Span
    effects: Mapping[str, tuple[float, float]]
    conductivity: Span
    heat_capacity: Span
    mount_s: Span
    contact: Span
    gap: Span
    sensor_s: Span
    sensor_offset_c: Span
    bend: Span


MEDIUM = GyroClass(
    name="medium",
    diameter_m=Span(0.07, 0.12, "m"),
    radial_m=Span(0.007, 0.011, "m"),
    height_m=Span(0.010, 0.018, "m"),
    housing_j_per_k=Span(400.0, 900.0, "J/K"),
    spool_j_per_k=Span(60.0, 150.0, "J/K"),
    package_s=Span(600.0, 2400.0, "s"),
    conductivity=Span(0.28, 0.32, "W/m/K"),
    heat_capacity=Span(1.6e6, 1.8e6, "J/m^3/K"),
    mount_s=Span(40.0, 160.0, "s"),
    contact=Span(100.0, 500.0, "W/m^2/K"),
    gap=Span(5.0, 30.0, "W/m^2/K"),
    sensor_s=Span(10.0, 120.0, "s"),
    sensor_offset_c=Span(-0.3, 0.3, "K", log=False),
    bend=Span(-0.5, 1.0, "1", log=False),
    self_heating_k=Span(3.0, 12.0, "K"),
    random_walk=Span(0.002, 0.01, "°/√h"),
    flicker=Span(0.003, 0.02, "°/h"),
    rate_random_walk=Span(0.001, 0.01, "°/h/√h"),
    effects={
        "static_bias": (5e-4, 5e-3),
        "shupe": (0.05, 0.6),
        "mohr": (0.02, 0.3),
        "rate_temperature_coupling": (1e-4, 3e-3),
        "sensor_lag": (5e-4, 5e-3),
        "hysteresis": (0.002, 0.02),
        "polarization": (0.002, 0.03),
        "warm_up": (0.02, 0.3),
        "aging": (0.005, 0.05),
        "bias_step": (0.005, 0.05),
        "magnetic": (2e-4, 5e-3),
        "supply_voltage": (0.02, 0.4),
    },
)
TACTICAL = replace(
    MEDIUM,
    name="tactical",
    diameter_m=Span(0.03, 0.06, "m"),
    radial_m=Span(0.004, 0.008, "m"),
    height_m=Span(0.006, 0.012, "m"),
    housing_j_per_k=Span(80.0, 250.0, "J/K"),
    spool_j_per_k=Span(10.0, 40.0, "J/K"),
    package_s=Span(180.0, 900.0, "s"),
    self_heating_k=Span(3.0, 12.0, "K"),
    random_walk=Span(0.01, 0.05, "°/√h"),
    flicker=Span(0.05, 0.3, "°/h"),
    rate_random_walk=Span(0.01, 0.1, "°/h/√h"),
    effects={
        "static_bias": (0.01, 0.1),
        "shupe": (0.05, 2.0),
        "mohr": (0.1, 2.0),
        "rate_temperature_coupling": (1e-3, 2e-2),
        "sensor_lag": (0.01, 0.1),
        "hysteresis": (0.05, 0.5),
        "polarization": (0.02, 0.5),
        "warm_up": (0.3, 3.0),
        "aging": (0.05, 0.5),
        "bias_step": (0.05, 0.5),
        "magnetic": (5e-3, 5e-2),
        "supply_voltage": (0.4, 8.0),
    },
)
CLASSES = {one.name: one for one in (MEDIUM, TACTICAL)}
SPANS = tuple(one.name for one in fields(GyroClass) if one.name not in {"name", "effects"})
# What is not named here has to be above 0.
LEAST = {"random_walk": 0.0, "flicker": 0.0, "rate_random_walk": 0.0, "self_heating_k": 0.0, "sensor_offset_c": -100.0, "bend": -1.0}


def gyro_class(name: str, effects: Mapping[str, Any] | None = None, **changes: Any) -> GyroClass:
    """A class of gyros with some spreads changed, as a YAML in conf/gyro writes it.

    Args:
        name: ``"medium"`` or ``"tactical"``.
        effects: leading amplitudes to change, a number or [low, high] by the effect's name.
        **changes: parameters to change; None leaves the class's spread, a number fixes, [low, high] spreads.

    Raises:
        InputError: unknown class or parameter, or a spread that is none.
    """
    if name not in CLASSES:
        raise InputError(f"gyro.name='{name}': {nearest(name, CLASSES)}")
    base = CLASSES[name]
    unknown = [key for key in changes if key not in SPANS]
    if unknown:
        raise InputError(f"unknown key 'gyro.{unknown[0]}': {nearest(unknown[0], SPANS)}")
    spans = {key: replace(getattr(base, key), **_spread(f"gyro.{key}", value)) for key, value in changes.items() if value is not None}
    sizes = {key: _spread(f"gyro.effects.{key}", value) for key, value in (effects or {}).items()}
    return replace(base, **spans, effects={**base.effects, **{key: (size["low"], size["high"]) for key, size in sizes.items()}})


def _spread(key: str, value: Any) -> dict[str, float]:
    ends = [value, value] if isinstance(value, (int, float)) else value
    if isinstance(ends, str) or not isinstance(ends, Sequence) or len(ends) != 2:
        raise InputError(f"{key}={value}: a number or [low, high] is expected")
    if not all(isinstance(end, (int, float)) and math.isfinite(end) for end in ends) or ends[0] > ends[1]:
        raise InputError(f"{key}={value}: finite numbers with low <= high are expected")
    _check_low(key, ends[0])
    return {"low": float(ends[0]), "high": float(ends[1])}


def _check_low(key: str, low: float) -> None:
    parameter = key.removeprefix("gyro.")
    if parameter in LEAST and low < LEAST[parameter]:
        raise InputError(f"{key}: {low:g} is too small; {LEAST[parameter]:g} and more is possible")
    if parameter in SPANS and parameter not in LEAST and low <= 0:
        raise InputError(f"{key}: {low:g} is too small; a value above 0 is expected")
