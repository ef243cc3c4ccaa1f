"""Classes of gyros: what is alike in them, and how far the rest is spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

from zoo.errors import InputError, nearest
from zoo.given import check_number
from zoo.physics.winding import PATTERNS
from zoo.simulator.streams import Span


@dataclass(frozen=True)
class GyroClass:
    """What gyros of one class have in common: their design, and the spread of what differs from one to the next.

    Attributes:
        name: the class.
        layers: of the winding.
        turns: in a layer.
        pattern: of the winding.
        diameter_m: mean diameter of the winding.
        layer_pitch_m: from layer to layer.
        turn_pitch_m: from turn to turn.
        winding_error_turns: standard deviation of the fibre that a layer has too much.
        trimmed: share of the winding's sensitivity to radial flow that was trimmed away at its ends.
        lead_asymmetry_m: by how much the lead at the end of A is longer than the other; leads are as warm as the housing.
        index: n of the fibre.
        thermo_optic_per_k: dn/dT + n·α.
        glass_fraction: share of the glass in the winding's volume.
        glue_conductivity: of coating and glue.
        conductivity: of the winding, across the fibre; as glass and glue make it where 0.
        heat_capacity: of the winding, by volume.
        housing_j_per_k: heat capacity of housing and electronics.
        spool_j_per_k: heat capacity of the spool.
        package_s: time constant of the whole gyro against the air.
        mount_s: time constant of spool and coil against the housing.
        contact: between the winding's inner face and lower flange, and the spool.
        top_contact: between the winding and the upper flange; as the lower one where 0.
        gap: between the winding's outer face and the housing, through the air.
        self_heating_k: how much hotter than the air the electronics make the housing.
        power_at_spool: share of their heat that is released at the spool, beneath the coil.
        sensor_s: time constant of a thermometer.
        sensor_offset_c: error of a thermometer.
        sensor_heating_k: by how much a thermometer warms itself.
        random_walk: N at 20 °C.
        cold_loss_db: light lost at −40 °C against 20 °C.
        flicker: B.
        rate_random_walk: K.
        effects: spread of each effect's leading amplitude by the effect's name, in the output's unit.
        fixed: parameters of effects that are the same in all gyros of the class, by effect and parameter.
    """

    name: str
    layers: int
    turns: int
    pattern: str
    diameter_m: Span
    layer_pitch_m: Span
    turn_pitch_m: Span
    housing_j_per_k: Span
    spool_j_per_k: Span
    package_s: Span
    random_walk: Span
    flicker: Span
    rate_random_walk: Span
    effects: Mapping[str, tuple[float, float]]
    winding_error_turns: Span
    trimmed: Span
    lead_asymmetry_m: Span
    index: Span
    thermo_optic_per_k: Span
    glass_fraction: Span
    glue_conductivity: Span
    conductivity: Span
    heat_capacity: Span
    mount_s: Span
    contact: Span
    top_contact: Span
    gap: Span
    self_heating_k: Span
    power_at_spool: Span
    sensor_s: Span
    sensor_offset_c: Span
    sensor_heating_k: Span
    cold_loss_db: Span
    fixed: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


DESIGN = ("layers", "turns", "pattern")
SPANS = tuple(one.name for one in fields(GyroClass) if one.name not in {"name", "effects", "fixed", *DESIGN})
MOST_TURNS = 300
LIMITS = {
    "diameter_m": (1e-3, 10.0),
    "layer_pitch_m": (1e-5, 1e-2),
    "turn_pitch_m": (1e-5, 1e-2),
    "winding_error_turns": (0.0, 1e3),
    "trimmed": (0.0, 1.0),
    "lead_asymmetry_m": (-100.0, 100.0),
    "index": (1.0, 4.0),
    "thermo_optic_per_k": (1e-8, 1e-3),
    "glass_fraction": (1e-3, 1.0),
    "glue_conductivity": (1e-3, 1e3),
    "conductivity": (0.0, 1e4),
    "heat_capacity": (1e3, 1e8),
    "housing_j_per_k": (1e-2, 1e6),
    "spool_j_per_k": (1e-2, 1e6),
    "package_s": (1.0, 1e6),
    "mount_s": (0.1, 1e6),
    "contact": (1e-2, 1e6),
    "top_contact": (0.0, 1e6),
    "gap": (1e-3, 1e6),
    "self_heating_k": (0.0, 500.0),
    "power_at_spool": (0.0, 1.0),
    "sensor_s": (1e-3, 1e5),
    "sensor_offset_c": (-100.0, 100.0),
    "sensor_heating_k": (0.0, 100.0),
    "random_walk": (0.0, 1e6),
    "cold_loss_db": (0.0, 60.0),
    "flicker": (0.0, 1e6),
    "rate_random_walk": (0.0, 1e6),
}
"""Beyond these there is no gyro, in the units of the class."""
LARGEST_EFFECT = 1e9


def changed(base: GyroClass, effects: Mapping[str, Any] | None = None, **changes: Any) -> GyroClass:
    """A class of gyros with some spreads changed, as a YAML in conf/gyro writes it.

    Args:
        base: the class.
        effects: leading amplitudes to change, a number or [low, high] by the effect's name; nothing of such an effect is fixed any more.
        **changes: parameters to change; None leaves the class's spread, a number fixes, [low, high] spreads.

    Raises:
        InputError: an unknown parameter, a spread that is none, a value that cannot be.
    """
    known = (*DESIGN, *SPANS)
    unknown = [key for key in changes if key not in known]
    if unknown:
        raise InputError(f"unknown key 'gyro.{unknown[0]}': {nearest(unknown[0], known)}")
    asked = {key: value for key, value in changes.items() if value is not None}
    if not isinstance(effects or {}, Mapping):
        raise InputError(f"gyro.effects={effects}: effect: number or [low, high] is expected")
    sizes = {key: _ends(f"gyro.effects.{key}", value, -LARGEST_EFFECT, LARGEST_EFFECT) for key, value in (effects or {}).items()}
    own: dict[str, Any] = {key: _span(getattr(base, key), key, value) if key in SPANS else _design(key, value) for key, value in asked.items()}
    fixed = {name: values for name, values in base.fixed.items() if name not in sizes}
    return replace(base, **own, effects={**base.effects, **sizes}, fixed=fixed)


def _design(key: str, value: Any) -> Any:
    """Layers and turns as whole numbers, the pattern by its name."""
    if key == "pattern":
        if value not in PATTERNS:
            raise InputError(f"gyro.pattern={value}: {nearest(str(value), PATTERNS)}")
        return value
    check_number(f"gyro.{key}", value, 1, MOST_TURNS, whole=True)
    return value


def _span(base: Span, key: str, value: Any) -> Span:
    low, high = _ends(f"gyro.{key}", value, *LIMITS[key])
    return replace(base, low=low, high=high, source="given")


def _ends(key: str, value: Any, least: float, most: float) -> tuple[float, float]:
    """Both ends of a spread, each a number that is possible."""
    ends = [value, value] if isinstance(value, (int, float)) else value
    if isinstance(ends, str) or not isinstance(ends, Sequence) or len(ends) != 2:
        raise InputError(f"{key}={value}: a number or [low, high] is expected")
    for end in ends:
        check_number(key, end, least, most)
    if ends[0] > ends[1]:
        raise InputError(f"{key}={value}: finite numbers with low <= high are expected")
    return float(ends[0]), float(ends[1])
