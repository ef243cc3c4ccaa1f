"""How much of the Earth's rotation a gyro at rest sees."""

from __future__ import annotations

import math
from collections.abc import Sequence

from zoo.errors import InputError, nearest
from zoo.given import is_number
from zoo.units import convert

EARTH_RAD_PER_S = 7.292115e-5
"""Nominal mean angular velocity of the Earth (IERS Conventions 2010, table 1.2), 15.041 °/h."""
AXES = {
    "east": (1.0, 0.0, 0.0),
    "west": (-1.0, 0.0, 0.0),
    "north": (0.0, 1.0, 0.0),
    "south": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}


def earth_rate(latitude_deg: float, axis: str | Sequence[float] = "up") -> float:
    """True rate of a gyro that rests on the Earth [°/h], Ω·(north·cos φ + up·sin φ) for an input axis of length 1.

    Args:
        latitude_deg: φ, geodetic, north of the equator positive [°].
        axis: where the input axis points: a name from `AXES` or [east, north, up] of any length.

    Raises:
        InputError: a latitude beyond the poles, or an axis that is none.
    """
    if not is_number(latitude_deg) or abs(latitude_deg) > 90:
        raise InputError(f"latitude_deg={latitude_deg}: a number from -90 (south pole) to 90 (north pole) is possible")
    _, north, up = direction(axis)
    latitude = math.radians(latitude_deg)
    return convert(EARTH_RAD_PER_S, "rad_per_s", "dph") * (north * math.cos(latitude) + up * math.sin(latitude))


def direction(axis: str | Sequence[float]) -> tuple[float, float, float]:
    """East, north and up of an input axis, of length 1; up is also the specific force along it at rest [g].

    Args:
        axis: a name from `AXES` or [east, north, up] of any length.

    Raises:
        InputError: an axis that is none.
    """
    return _named(axis) if isinstance(axis, str) else _unit(axis)


def _unit(axis: Sequence[float]) -> tuple[float, float, float]:
    if not isinstance(axis, Sequence) or len(axis) != 3 or not all(is_number(one) for one in axis) or not any(axis):
        raise InputError(f"axis={axis}: one of {', '.join(AXES)}, or three finite numbers [east, north, up], not all of them 0, is possible")
    length = math.hypot(*axis)
    return axis[0] / length, axis[1] / length, axis[2] / length


def _named(axis: str) -> tuple[float, float, float]:
    if axis not in AXES:
        raise InputError(f"axis={axis}: {nearest(axis, AXES)}; or [east, north, up]")
    return AXES[axis]
