"""Ways to write down a chamber program; each is the target of a YAML in conf/profile."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from zoo.errors import InputError
from zoo.simulator.program import Campaign, Program

SECONDS_PER_MINUTE = 60.0


def legs(legs: Sequence[Sequence[float]], check: Sequence[Sequence[float]] | None = None) -> Campaign:
    """The same legs in every run.

    Args:
        legs: [[from °C, to °C, seconds], …].
        check: legs of the check run; where None, `legs` backwards.

    Raises:
        InputError: see `Program`.
    """
    program = _program(legs, "profile.legs")
    return Campaign((program,), _program(check, "profile.check") if check is not None else program.reversed())


def tour(start_c: float, stops: Sequence[Sequence[float]], start_s: float = 3600.0) -> Campaign:
    """From stop to stop, each with its own rate, the same in every run; the check run goes backwards.

    Args:
        start_c: first temperature [°C].
        stops: [[to °C, K/min, seconds of hold], …]; a hold of 0 s turns at once.
        start_s: hold at the start [s].

    Raises:
        InputError: a stop that is not three numbers, a rate that is not positive; see `Program`.
    """
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
    if not (isinstance(cycles, int) and 1 <= cycles <= 1000):
        raise InputError(f"profile.cycles={cycles}: 1 to 1000 is possible")
    return tour(start_c, [(high_c, k_per_min, hold_s), (low_c, k_per_min, hold_s), (start_c, k_per_min, hold_s)] * cycles, hold_s)


def campaign(runs: Sequence[Campaign], check: Campaign) -> Campaign:
    """Another program for each run.

    Args:
        runs: profiles of run 1, 2, …
        check: profile of the check run.

    Raises:
        InputError: no runs.
    """
    if not runs:
        raise InputError("profile.runs is empty; name at least one profile")
    return Campaign(tuple(one.runs[0] for one in runs), check.runs[0])


def _program(legs: Sequence[Sequence[float]], key: str) -> Program:
    if isinstance(legs, str) or not isinstance(legs, Sequence) or not all(isinstance(leg, Sequence) and not isinstance(leg, str) for leg in legs):
        raise InputError(f"{key}={legs}: a list of [from °C, to °C, seconds] is expected, such as [[20,20,3600],[20,60,2400]]")
    return Program(tuple((*leg,) for leg in legs))  # type: ignore[misc]


def _toured(start_c: float, stops: Sequence[Sequence[float]], start_s: float) -> Iterator[tuple[float, float, float]]:
    for stop in stops:
        if len(stop) != 3 or stop[1] <= 0 or stop[2] < 0:
            raise InputError(f"stop {list(stop)} of the program: [to °C, K/min > 0, seconds of hold >= 0] is expected")
    if start_s > 0:
        yield start_c, start_c, start_s
    for before, (to_c, k_per_min, hold_s) in pairwise([(start_c, 0.0, 0.0), *stops]):
        if to_c != before[0]:
            yield before[0], to_c, abs(to_c - before[0]) / k_per_min * SECONDS_PER_MINUTE
        if hold_s > 0:
            yield to_c, to_c, hold_s
