"""Moments of a chamber program at which the heat in a winding is worth a picture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from zoo.simulator.laboratory.program import Program
from zoo.units import convert

SOON_S = 600.0
"""How long after a corner of the program a picture is taken, or a quarter of the leg."""
AFTER_POWER_ON_S = (120.0, 300.0, 900.0, 2700.0, 7200.0)
"""Moments besides the first where nothing moves but the gyro warms up."""


@dataclass(frozen=True)
class Moment:
    """When, and why then.

    Attributes:
        time_s: since the start of the run [s].
        label: what goes on, in a few words.
    """

    time_s: float
    label: str


@dataclass(frozen=True)
class Motion:
    """A stretch in which the set point goes one way; without length where it jumps.

    Attributes:
        start_s: when it begins [s].
        end_s: when it ends [s].
        change_k: by how much the set point moves [K].
    """

    start_s: float
    end_s: float
    change_k: float

    @property
    def name(self) -> str:
        """``heating`` or ``cooling``."""
        return "heating" if self.change_k > 0 else "cooling"


def motions(program: Program) -> list[Motion]:
    """All of them in order; neighbours in the same direction are one."""
    found: list[Motion] = []
    for one in _moving(program):
        last = found[-1] if found else None
        if last and last.end_s == one.start_s and last.change_k * one.change_k > 0:
            found[-1] = Motion(last.start_s, one.end_s, last.change_k + one.change_k)
        else:
            found.append(one)
    return found


def moments(program: Program, cold_start: bool = False) -> list[Moment]:
    """Around the first motion, and in the middle of the first one the other way; three to six where anything moves.

    Args:
        program: what the chamber is asked for.
        cold_start: whether the gyro is switched on at the start.
    """
    moving = motions(program)
    if not moving:
        warming = [Moment(one, f"{_lasting(one)} after power-on") for one in AFTER_POWER_ON_S if one <= program.seconds]
        return [Moment(0.0, "at power-on"), *warming] if cold_start else [Moment(0.0, "steady")]
    rests = [one.start_s for one in moving[1:]] + [program.seconds]
    back = next((place for place, one in enumerate(moving) if one.change_k * moving[0].change_k < 0), None)
    return [*_during(moving[0]), *_after(moving[0], rests[0]), *(() if back is None else _back(moving[back], rests[back]))]


def _moving(program: Program) -> Iterator[Motion]:
    time, before = 0.0, program.legs[0][0]
    for start, end, seconds in program.legs:
        if start != before:
            yield Motion(time, time, start - before)
        if end != start:
            yield Motion(time, time + seconds, end - start)
        time, before = time + seconds, end


def _during(motion: Motion) -> Iterator[Moment]:
    yield Moment(motion.start_s, f"before {motion.name}")
    if motion.end_s > motion.start_s:
        soon = min(SOON_S, (motion.end_s - motion.start_s) / 4)
        yield Moment(motion.start_s + soon, f"{_lasting(soon)} after its start")
        yield Moment(_middle(motion), f"mid-{motion.name}")


def _after(motion: Motion, until_s: float) -> Iterator[Moment]:
    """Some minutes after the end and at the end of the hold; only the end itself where there is none."""
    hold = until_s - motion.end_s
    if hold > 0:
        soon = min(SOON_S, hold / 4)
        yield Moment(motion.end_s + soon, f"{_lasting(soon)} after {'its end' if motion.end_s > motion.start_s else 'the step'}")
        yield Moment(until_s, "end of the hold")
    else:
        yield Moment(motion.end_s, f"end of {motion.name}")


def _back(motion: Motion, until_s: float) -> Iterator[Moment]:
    """The middle; some minutes later where the set point jumps."""
    if motion.end_s > motion.start_s:
        yield Moment(_middle(motion), f"mid-{motion.name}")
    else:
        soon = min(SOON_S, (until_s - motion.end_s) / 4)
        yield Moment(motion.end_s + soon, f"{_lasting(soon)} of {motion.name}")


def _middle(motion: Motion) -> float:
    return (motion.start_s + motion.end_s) / 2


def _lasting(seconds: float) -> str:
    minutes = convert(seconds, "s", "min")
    return f"{seconds:.3g} s" if minutes < 2 else f"{minutes:.3g} min" if minutes < 90 else f"{convert(seconds, 's', 'h'):.3g} h"
