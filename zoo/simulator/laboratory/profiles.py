"""Ways to write down a chamber program; each is the target of a YAML in conf/profile."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from zoo.errors import InputError
from zoo.given import check_number, check_numbers, is_number
from zoo.simulator.laboratory.program import LEG, Campaign, Program
from zoo.units import SECONDS_PER_MINUTE, convert

LEGS_A_PERIOD = 96
STOP = "[to °C, K/min > 0, seconds of hold >= 0]"
Rows = Sequence[Sequence[float]]


def legs(legs: Rows, check: Rows | None = None, rates: Rows = (), check_rates: Rows = ()) -> Campaign:
    """The same legs in every run.

    Args:
        legs: [[from °C, to °C, seconds], …].
        check: legs of the check run; where None, `legs` and `rates` backwards.
        rates: [[°/s, seconds], …] of a rate table, which stands still afterwards.
        check_rates: those of the check run, where `check` is given.

    Raises:
        InputError: see `Program`.
    """
    program = _program(legs, rates, ("profile.legs", "profile.rates"))
    return Campaign((program,), program.reversed() if check is None else _program(check, check_rates, ("profile.check", "profile.check_rates")))


def tour(start_c: float, stops: Rows, start_s: float = 3600.0) -> Campaign:
    """From stop to stop, each with its own rate, the same in every run; the check run goes backwards.

    Args:
        start_c: first temperature [°C].
        stops: [[to °C, K/min, seconds of hold], …]; a hold of 0 s turns at once.
        start_s: hold at the start [s].

    Raises:
        InputError: a stop that is not three numbers, a rate that is not positive; see `Program`.
    """
    check_numbers("profile", start_c=start_c, start_s=start_s)
    _check_rows(stops, "profile.stops", STOP, "[[60,1.0,3600],[20,1.0,3600]]")
    program = Program(tuple(_toured(start_c, stops, start_s)))
    return Campaign((program,), program.reversed())


def staircase(low_c: float, high_c: float, step_k: float, k_per_min: float, hold_s: float) -> Campaign:
    """Up from the lowest level, with a hold at each, as in qiu2023; the check run goes down.

    Args:
        low_c: first level [°C].
        high_c: last level [°C].
        step_k: from level to level [K]; the last step may be shorter.
        k_per_min: rate of the ramps.
        hold_s: at each level [s].

    Raises:
        InputError: levels that are not in order, a step or a rate that is not positive; see `Program`.
    """
    check_numbers("profile", low_c=low_c, high_c=high_c, step_k=step_k, k_per_min=k_per_min, hold_s=hold_s)
    if not (low_c < high_c and step_k > 0):
        raise InputError(f"profile: a staircase from {low_c:g} to {high_c:g} °C in steps of {step_k:g} K; give low_c < high_c and step_k > 0")
    count = math.ceil((high_c - low_c) / step_k - 1e-9)
    if count > 1000:
        raise InputError(f"profile.step_k={step_k:g}: makes {count} steps; at most 1000 are possible")
    levels = [min(low_c + step_k * place, high_c) for place in range(1, count + 1)]
    return tour(low_c, [(level, k_per_min, hold_s) for level in levels], hold_s)


def cycle(low_c: float, high_c: float, start_c: float, k_per_min: float, hold_s: float, cycles: int = 1) -> Campaign:
    """Up, down and back to the start, with holds; the check run does it backwards.

    Args:
        low_c: coldest [°C].
        high_c: hottest [°C].
        start_c: first and last temperature [°C].
        k_per_min: rate of the ramps.
        hold_s: at each turn and at the ends [s].
        cycles: how often.

    Raises:
        InputError: fewer than one cycle; see `tour`.
    """
    check_numbers("profile", low_c=low_c, high_c=high_c, start_c=start_c, k_per_min=k_per_min, hold_s=hold_s)
    check_number("profile.cycles", cycles, 1, 1000, whole=True)
    return tour(start_c, [(high_c, k_per_min, hold_s), (low_c, k_per_min, hold_s), (start_c, k_per_min, hold_s)] * cycles, hold_s)


def sine(mean_c: float, amplitude_k: float, period_s: float, cycles: int = 1, start_s: float = 3600.0) -> Campaign:
    """A sine of the set point in 96 straight legs a period, off by 5.4e-4 of the amplitude at most; the check run goes backwards.

    Args:
        mean_c: first and mean temperature [°C].
        amplitude_k: above and below it [K].
        period_s: of one cycle [s].
        cycles: how often.
        start_s: hold at the start [s].

    Raises:
        InputError: not 1 to 1000 cycles; see `Program`.
    """
    check_numbers("profile", mean_c=mean_c, amplitude_k=amplitude_k, period_s=period_s, start_s=start_s)
    check_number("profile.cycles", cycles, 1, 1000, whole=True)
    swing = [mean_c + amplitude_k * math.sin(2 * math.pi * (place % LEGS_A_PERIOD) / LEGS_A_PERIOD) for place in range(LEGS_A_PERIOD * cycles + 1)]
    program = Program((*_toured(mean_c, (), start_s), *((*ends, period_s / LEGS_A_PERIOD) for ends in pairwise(swing))))
    return Campaign((program,), program.reversed())


def campaign(runs: Sequence[Campaign], check: Campaign) -> Campaign:
    """Another program for each run.

    Args:
        runs: profiles of run 1, 2, …
        check: profile of the check run.

    Raises:
        InputError: no runs, or what is no profile.
    """
    if not runs:
        raise InputError("profile.runs is empty; name at least one profile")
    for key, one in (*(("runs", one) for one in runs), ("check", check)):
        if not isinstance(one, Campaign):
            raise InputError(f"profile.{key}={one}: no profile; each has a _target_ of its own, as in conf/profile/campaign.yaml")
    return Campaign(tuple(one.of(1) for one in runs), check.of(1))


def _program(legs: Rows, rates: Rows, keys: tuple[str, str]) -> Program:
    _check_rows(legs, keys[0], LEG, "[[20,20,3600],[20,60,2400]]")
    _check_rows(rates, keys[1], "[°/s, seconds]", "[[-10,600],[10,600]]")
    turns = ((convert(rate, "dps", "dph") if isinstance(rate, (int, float)) else rate, *rest) for rate, *rest in rates)
    return Program(tuple((*leg,) for leg in legs), tuple(turns))  # type: ignore[arg-type, misc]


def _check_rows(rows: Rows, key: str, row: str, such_as: str) -> None:
    if not isinstance(rows, Sequence) or not all(isinstance(one, Sequence) and not isinstance(one, str) and len(one) > 0 for one in rows):
        raise InputError(f"{key}={rows}: a list of {row} is expected, such as {such_as}")


def _toured(start_c: float, stops: Rows, start_s: float) -> Iterator[tuple[float, float, float]]:
    for stop in stops:
        if len(stop) != 3 or not all(map(is_number, stop)) or stop[1] <= 0 or stop[2] < 0:
            raise InputError(f"stop {list(stop)} of the program: {STOP} is expected")
    if start_s > 0:
        yield start_c, start_c, start_s
    for before, (to_c, k_per_min, hold_s) in pairwise([(start_c, 0.0, 0.0), *stops]):
        if to_c != before[0]:
            yield before[0], to_c, abs(to_c - before[0]) / k_per_min * SECONDS_PER_MINUTE
        if hold_s > 0:
            yield to_c, to_c, hold_s
