"""A rate table in a chamber: at each temperature one rate after another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from zoo.errors import InputError
from zoo.given import check_number, check_numbers
from zoo.simulator.laboratory.profiles import tour
from zoo.simulator.laboratory.program import Campaign, Program
from zoo.units import convert


def rate_table(levels_c: Sequence[float], soak_s: float, rates_dps: Sequence[float], point_s: float, k_per_min: float = 1.0) -> Campaign:
    """At each level a soak at rest and then one rate after another, as in liu2010; the check run goes backwards.

    Args:
        levels_c: temperatures, in order [°C].
        soak_s: hold at each level before the table turns [s].
        rates_dps: true rates, in order [°/s].
        point_s: length of each [s].
        k_per_min: rate of the ramps from level to level, at rest.

    Raises:
        InputError: no levels, no rates, a duration that cannot be; see `tour` and `Program`.
    """
    for key, values in (("levels_c", levels_c), ("rates_dps", rates_dps)):
        if isinstance(values, str) or not isinstance(values, Sequence) or not values:
            raise InputError(f"profile.{key}={values}: a list of one number or more is expected")
        for place, value in enumerate(values, 1):
            check_number(f"profile.{key}, number {place}", value)
    check_numbers("profile", soak_s=soak_s, point_s=point_s, k_per_min=k_per_min)
    if not (soak_s >= 0 and point_s > 0):
        raise InputError(f"profile: soak_s={soak_s}, point_s={point_s}; soak_s >= 0 and point_s > 0 are possible")
    turns = [(convert(rate, "dps", "dph"), point_s) for rate in rates_dps]
    stop_s = soak_s + len(turns) * point_s
    legs = tour(levels_c[0], [(level, k_per_min, stop_s) for level in levels_c[1:]], stop_s).of(1).legs
    program = Program(legs, tuple(_turned(legs, soak_s, turns)))
    return Campaign((program,), program.reversed())


def _turned(legs: Sequence[tuple[float, float, float]], soak_s: float, turns: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    for start, end, seconds in legs:
        if start != end:
            yield 0.0, seconds
            continue
        if soak_s > 0:
            yield 0.0, soak_s
        yield from turns
