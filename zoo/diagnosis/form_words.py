"""A form, once fitted, in a plain sentence."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

from zoo.diagnosis.form_search import Tried
from zoo.diagnosis.forms import POLYNOMIALS
from zoo.diagnosis.quantities import CLOCK, RATE, SIZE
from zoo.units import SECONDS_PER_HOUR, SECONDS_PER_MINUTE, symbol

NAMED_POWERS = {0.5: "its square root", 1.0: "in proportion to it", 1.5: "its power 1.5", 2.0: "its square", 3.0: "its cube"}
NEAR_POWER = 0.1
"""An exponent so near to a named power, or within two standard errors of it, is called by its name."""
LIKE_FRICTION = 0.3
"""Rate [K/min] up to which what hardly grows any more is nearly one of two values."""
RISE = 4.0
"""Widths in which a step has gone from 12 to 88 % of its height."""
SETTLED = 0.05
"""Share of a curve's range that it may go back by and still be called rising or falling."""

Curve = dict[str, Any]
Found = dict[str, Any]


def sentence(tried: Tried, curves: list[Curve], unit: str) -> str:
    """What the residual does with a quantity, if it has this form.

    Args:
        tried: the form, fitted.
        curves: the free function of its quantity, see `FreeFit.curves`.
        unit: suffix of the output's unit.
    """
    values, tried = tried.parameters(unit), replace(tried, quantity=tried.quantity.told_in(unit))
    makers: dict[str, Callable[[Tried, Found], str]] = {
        "even_power": _even,
        "odd_power": _odd,
        "saturating": _saturating,
        "even_power_by_temperature": _by_temperature,
        "odd_power_by_temperature": _by_temperature,
        "remembered_power": _remembered,
        "wave": _wave,
        "bent": _bent,
        "stepped": _stepped,
    }
    if tried.form is POLYNOMIALS[0]:
        return _proportional(tried, values)
    make = makers.get(tried.form.columns.__name__)
    return make(tried, values) if make else shape_of(tried.quantity.words, tried.quantity.unit, curves[0])


def shape_of(words: str, unit: str, curve: Curve) -> str:
    """What a curve does from left to right, where no form has a name for it."""
    x, y, what = curve["x"], curve["y"], words.split(",", maxsplit=1)[0]
    ends = f"between {_place(x, 0)} and {_place(x, -1)} {unit}".rstrip()
    steps = [later - before for before, later in pairwise(y)]
    way = "rises" if y[-1] > y[0] else "falls"
    if sum(abs(step) for step in steps if (step > 0) != (y[-1] > y[0])) <= SETTLED * (max(y) - min(y)):
        half = len(y) // 2
        late, early = abs(y[-1] - y[half]), abs(y[half] - y[0])
        how = ", mostly at the upper end," if late > 3 * early else ", levelling off," if early > 3 * late else ""
        return f"It {way} with {what}{how} {ends}."
    places = [(y.index(max(y)), "highest"), (y.index(min(y)), "lowest")]
    inner = [f"{name} at {_place(x, i)} {unit}".rstrip() for i, name in places if 0 < i < len(y) - 1]
    return f"It goes up and down with {what} {ends}{': ' if inner else ''}{' and '.join(inner)}."


def _place(x: list[float], i: int) -> str:
    """One value of an axis, no finer than a hundredth of it."""
    decimals = -math.floor(math.log10((x[-1] - x[0]) / 50))
    return number(round(x[i], decimals), digits=12)


def number(value: float, digits: int = 3) -> str:
    """A number in a sentence."""
    text = f"{float(f'{value:.{digits}g}'):g}"
    return text.replace("-", "−")


def _size(words: str) -> str:
    return f"the size of {words}"


def _both_ways(tried: Tried) -> str:
    return "the same for heating and cooling" if tried.quantity.of is RATE.of else "the same for either sign"


def _power(values: Found) -> str:
    """``as its square (exponent 2.01 ± 0.02)``."""
    exponent, error = values["exponent"]["value"], values["exponent"]["stderr"]
    given = f"exponent {number(exponent)}" + (f" ± {number(error, 1)}" if error and math.isfinite(error) else "")
    nearest = min(NAMED_POWERS, key=lambda named: abs(named - exponent))
    if abs(nearest - exponent) <= max(NEAR_POWER, 2 * (error or 0.0)):
        name = NAMED_POWERS[nearest]
        return f"{'' if name.startswith('in ') else 'as '}{name} ({given})"
    return f"with {given}"


def _way(values: Found) -> str:
    return "grows" if values["coefficient"]["value"] > 0 else "falls"


def _proportional(tried: Tried, values: Found) -> str:
    way = "rises" if values["a1"]["value"] > 0 else "falls"
    alike = ", the same for heating and cooling" if tried.quantity == SIZE else ""
    return f"It {way} in proportion to {tried.quantity.words.split(',')[0]}{alike}."


def _even(tried: Tried, values: Found) -> str:
    return f"It {_way(values)} with {_size(tried.quantity.words)}, {_both_ways(tried)}, about {_power(values)}."


def _odd(tried: Tried, values: Found) -> str:
    return f"It changes sign with {tried.quantity.words} and {_way(values)} with its size, about {_power(values)}."


def _saturating(tried: Tried, values: Found) -> str:
    limit = values["size"]["value"]
    friction = ", like friction" if limit < LIKE_FRICTION else ""
    return f"It changes sign with {tried.quantity.words} and hardly grows beyond {number(limit, 2)} {tried.quantity.unit}{friction}."


def _by_temperature(tried: Tried, values: Found) -> str:
    base, slope = values["coefficient"]["value"], values["slope"]["value"]
    even = tried.form.columns.__name__.startswith("even")
    what = f"goes with {_size(tried.quantity.words)}, {_both_ways(tried)}," if even else f"changes sign with {tried.quantity.words} and goes"
    zero = 20.0 - 50.0 * base / slope if slope else math.inf
    if abs(zero - 20.0) < 60.0:
        return f"It {what} about {_power(values)}, times a factor that changes with the temperature, through zero near {number(zero, 2)} °C."
    return f"It {what} about {_power(values)}, and more so the {'hotter' if base * slope > 0 else 'colder'} it is."


def _remembered(tried: Tried, values: Found) -> str:
    minutes = number(values["memory"]["value"] / SECONDS_PER_MINUTE, 2)
    return f"It follows {_size(tried.quantity.words)} with a memory of {minutes} min, about {_power(values)}."


def _bent(tried: Tried, values: Found) -> str:
    slope = values["slope"]
    way, given = "rises" if slope["value"] > 0 else "falls", slope["unit"].partition("/")[0]
    steeper = f"{number(abs(slope['value']))} {symbol(given)}/{tried.quantity.unit.replace('°C', 'K')}"
    return f"It bends at {_at(values['place'], tried)}: above, it {way} by {steeper} more."


def _stepped(tried: Tried, values: Found) -> str:
    step, width = values["step"], f"{number(RISE * values['width']['value'], 2)} {tried.quantity.unit.replace('°C', 'K')}"
    less = "less than " if values["width"].get("at_bound") == "low" else ""
    way, size = "up" if step["value"] > 0 else "down", f"{number(abs(step['value']))} {symbol(step['unit'])}"
    return f"It steps {way} by {size} at {_at(values['place'], tried)}, most of it within {less}{width}."


def _at(place: Found, tried: Tried) -> str:
    """Where something happens along a quantity."""
    error = f" ± {number(place['stderr'], 1)}" if place["stderr"] and math.isfinite(place["stderr"]) else ""
    return f"{number(place['value'])}{error} {tried.quantity.unit} of {tried.quantity.words}"


def _wave(tried: Tried, values: Found) -> str:
    period = values["period"]["value"]
    if tried.quantity == CLOCK:
        return f"It recurs every {number(period * SECONDS_PER_HOUR)} s, with the same phase in all runs."
    return f"It recurs every {number(period)} {tried.quantity.unit.replace('°C', 'K')} of {tried.quantity.words}."
