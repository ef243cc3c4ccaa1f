"""The only place where numbers change unit: suffix of a column's name <-> unit <-> the way it is usually written.

Angles are defined by π rad = 180°, standard gravity is 9.80665 m/s² (CGPM 1901); pulses and counts have no scale until a gyro gives one.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from torch import Tensor

from zoo.errors import InputError

Value = TypeVar("Value", float, np.ndarray, Tensor)

STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True)
class Unit:
    """One unit of one quantity; value in the quantity's base unit = scale · value + offset.

    Attributes:
        suffix: how column names end.
        quantity: what it measures; only units of one quantity convert into each other.
        symbol: as usually written.
        scale: base units per unit.
        offset: base units at zero.
        spellings: other ways to write it, in lower case, without blanks and carets.
    """

    suffix: str
    quantity: str
    symbol: str
    scale: float
    offset: float = 0.0
    spellings: tuple[str, ...] = ()


_DEGREE = math.pi / 180
_ALL = (
    Unit("dph", "rate", "°/h", _DEGREE / 3600, spellings=("deg/hr", "deg/hour", "degrees/hour", "degph")),
    Unit("dps", "rate", "°/s", _DEGREE, spellings=("deg/sec", "deg/second", "degrees/second", "degps")),
    Unit("rad_per_s", "rate", "rad/s", 1.0, spellings=("rad/sec", "radians/second", "rads-1", "radps")),
    Unit("m_per_s2", "acceleration", "m/s²", 1.0, spellings=("m/s/s", "m/sec2", "ms-2", "mps2")),
    Unit("ug", "acceleration", "µg", 1e-6 * STANDARD_GRAVITY, spellings=("microg",)),
    Unit("mg", "acceleration", "mg", 1e-3 * STANDARD_GRAVITY, spellings=("millig",)),
    Unit("g", "acceleration", "g", STANDARD_GRAVITY, spellings=("gn",)),
    Unit("pulses", "pulses", "pulses", 1.0, spellings=("pulse",)),
    Unit("counts", "counts", "counts", 1.0, spellings=("count", "lsb")),
    Unit("c", "temperature", "°C", 1.0, 273.15, spellings=("celsius",)),
    Unit("k", "temperature", "K", 1.0, spellings=("kelvin",)),
    Unit("f", "temperature", "°F", 5 / 9, 273.15 - 32 * 5 / 9, spellings=("fahrenheit",)),
    Unit("s", "time", "s", 1.0, spellings=("sec", "seconds")),
    Unit("ms", "time", "ms", 1e-3, spellings=("milliseconds",)),
    Unit("us", "time", "µs", 1e-6, spellings=("microseconds",)),
    Unit("ns", "time", "ns", 1e-9, spellings=("nanoseconds",)),
    Unit("min", "time", "min", 60.0, spellings=("minutes",)),
    Unit("h", "time", "h", 3600.0, spellings=("hours", "hr")),
)
UNITS = {unit.suffix: unit for unit in _ALL}
OUTPUT_QUANTITIES = ("rate", "acceleration", "pulses", "counts")
SECONDS_PER_MINUTE, SECONDS_PER_HOUR = 60.0, 3600.0
EPOCH_S = 30 * 86400.0
"""A recorder's clock that shows more as a run begins counts from no beginning of the run, but from 1970 or the like (engineering prior)."""


def suffixes(*quantities: str) -> tuple[str, ...]:
    """The units of these quantities."""
    return tuple(unit.suffix for unit in _ALL if unit.quantity in quantities)


def symbol(suffix: str) -> str:
    """The usual writing of a unit: ``symbol("dph") == "°/h"``."""
    return UNITS[suffix].symbol


def _plain(text: str) -> str:
    """A unit's spelling without what people write in different ways."""
    replaced = text.strip().lower().replace("°", "deg").replace("²", "2").replace("µ", "u").replace("μ", "u")
    return replaced.translate(str.maketrans("", "", " ^*·"))


_SPELLED = {_plain(name): unit.suffix for unit in _ALL for name in (unit.suffix, unit.symbol, *unit.spellings)}


def parse_unit(text: str, *quantities: str) -> str:
    """The suffix of a unit written as its suffix or as usual: ``deg/h``, ``°/h``, ``dph``, ``rad/s``, ``m/s^2``.

    Args:
        text: what the user wrote.
        quantities: which quantities are possible; where none is given, those of a gyro's or accelerometer's output.

    Raises:
        InputError: no such unit; the message names those that are possible.
    """
    possible = suffixes(*(quantities or OUTPUT_QUANTITIES))
    suffix = _SPELLED.get(_plain(str(text)))
    if suffix not in possible:
        raise InputError(f"unknown unit '{text}'; possible: {', '.join(_choice(one) for one in possible)}")
    return suffix


def _choice(suffix: str) -> str:
    return suffix if suffix == symbol(suffix) else f"{suffix} ({symbol(suffix)})"


def output_suffix(column: str, *quantities: str) -> str | None:
    """The unit in a column's name: ``output_suffix("gyro_x_rad_per_s") == "rad_per_s"``; None where the name ends in no unit.

    Args:
        column: a column's name; ``pulses`` and ``counts`` are units by themselves.
        quantities: as in `parse_unit`.
    """
    found = [one for one in suffixes(*(quantities or OUTPUT_QUANTITIES)) if column.endswith(f"_{one}")]
    if column in suffixes("pulses", "counts") and column in suffixes(*(quantities or OUTPUT_QUANTITIES)):
        return column
    return max(found, key=len, default=None)


def convert(value: Value, given: str, wanted: str) -> Value:
    """A number, array or tensor in another unit of the same quantity.

    Args:
        value: in unit `given`.
        given: its unit's suffix.
        wanted: the suffix of the unit to return.

    Raises:
        InputError: the two units measure different quantities, or one is unknown.
    """
    for unit in (given, wanted):
        if unit not in UNITS:
            raise InputError(f"unknown unit '{unit}'; possible: {', '.join(UNITS)}")
    old, new = UNITS[given], UNITS[wanted]
    if old.quantity != new.quantity:
        raise InputError(f"{old.symbol} ({old.quantity}) cannot be converted to {new.symbol} ({new.quantity})")
    if old is new:
        return value
    return value * (old.scale / new.scale) + (old.offset - new.offset) / new.scale


_RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_SUPERSCRIPTS = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_PARTS = re.compile(r"\^\([^)]*\)|\^[^/·*()\s]+|[/·*()]|[^/·*^()\s]+")


def convert_parameter(value: float, declared: str, given: str, wanted: str) -> float:
    """A parameter whose unit has the output's in it, as ``ppm/(unit)^2`` has, where the output is in another unit; others stay as they are.

    Args:
        value: where ``unit`` is `given`.
        declared: the parameter's unit, products and quotients from left to right.
        given: suffix of the output's unit.
        wanted: suffix of the output's unit to return.

    Returns:
        NaN where the power of ``unit`` is no number.

    Raises:
        InputError: the two units measure different quantities.
    """
    return value * convert(1.0, given, wanted) ** output_power(declared)


def output_power(declared: str) -> float:
    """To which power the output's unit enters a parameter's: 1 for ``unit/K``, −2 for ``ppm/(unit)^2/K``, 0 for ``s``, NaN for ``unit^p``."""
    plain = _SUPERSCRIPTS.sub(lambda found: f"^{found[0].translate(_RAISED)}", declared.replace("**", "^"))
    return _power(_PARTS.findall(plain))


def _power(parts: list[str]) -> float:
    """The power of ``unit`` in a product up to its closing bracket, whose parts are used up."""
    total, sign = 0.0, 1.0
    while parts:
        part = parts.pop(0)
        if part == ")":
            break
        if part in {"/", "·", "*"}:
            sign = -1.0 if part == "/" else 1.0
            continue
        power = _power(parts) if part == "(" else float(part == "unit")
        raised = parts.pop(0) if parts and parts[0].startswith("^") else "^1"
        total += sign * power * _number(raised.strip("^()")) if power else 0.0
    return total


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def own_time(time_s: Any, start_s: float) -> Any:
    """Times of a run as its reader counts them [s]: as recorded, or since its start where the recorder counts from an epoch."""
    return time_s - start_s if start_s > EPOCH_S else time_s
