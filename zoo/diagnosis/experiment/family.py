"""The runs that can be proposed: chamber programs, and inputs beside the temperature."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from zoo.diagnosis.experiment.circumstances import Circumstances
from zoo.simulator.laboratory.profiles import sine, staircase, tour

Legs = tuple[tuple[float, float, float], ...]
Input = Literal["axis_flip", "rate_table", "power_on"]
RATES_K_PER_MIN = (0.2, 0.5, 1.0, 3.0)
FASTEST_K_PER_MIN = 3.0
PERIODS_S, CYCLES = (1200.0, 3600.0, 10800.0), (9, 5, 3)
HOLD_S = 3600.0
SOAK_S, DAY_S = 6 * 3600.0, 24 * 3600.0
EFFORT: dict[Input | None, float] = {None: 1.0, "power_on": 1.1, "axis_flip": 1.3, "rate_table": 1.6}
"""What an hour of a run costs, in hours of a chamber alone; an engineering prior."""
TURN_S = 1800.0
FASTER = 5.0
OVER, STEPS = (1.0, -1.0), (1.0, -1.0, FASTER, -FASTER)
RATE_WORDS = "what goes with the rate of temperature, with a lag or with the path answers differently to another rate"
FLIP_WORDS = "turning the axis over reverses what is proportional to the true input and leaves the rest as it is"
TABLE_WORDS = "what is proportional to the true input, what has only its sign, what has a power of it and what has nothing to do with it come apart"


@dataclass(frozen=True)
class Candidate:
    """One run that could be taken.

    Attributes:
        name: what it is, in a few words.
        why: what it does to the effects, as the end of a sentence.
        legs: chamber program, from [°C], to [°C], duration [s].
        turns: factor on the true input and duration [s], one after the other; the first is 1.
        extra: what is needed beside a chamber.
    """

    name: str
    why: str
    legs: Legs
    turns: tuple[tuple[float, float], ...] = ()
    extra: Input | None = None

    @property
    def effort(self) -> float:
        """Hours, more where something else than a chamber is needed."""
        return EFFORT[self.extra] * self.seconds / 3600.0

    @property
    def seconds(self) -> float:
        """Length of the run."""
        return sum(leg[2] for leg in self.legs)


def family(known: Circumstances) -> list[Candidate]:
    """Every run that is considered, chamber programs first; inputs are turned only where it is known what they are.

    Args:
        known: what the runs at hand tell.
    """
    turned = [*_turned(known)] if known.reference is not None else []
    return [*_cycles(known), *_levels(known), *_sines(known), *_rests(known), *turned, *_power_ons(known)]


def _cycles(known: Circumstances) -> Iterator[Candidate]:
    low, high, start = known.low_c, known.high_c, known.start_c
    for rate in RATES_K_PER_MIN:
        yield Candidate(f"a cycle at {rate:g} K/min", RATE_WORDS, _toured(start, [(high, rate), (low, rate), (start, rate)]))
    both = [(high, 3.0), (low, 3.0), (start, 3.0), (high, 0.5), (low, 0.5), (start, 0.5)]
    yield Candidate("two cycles, at 3 and at 0.5 K/min", RATE_WORDS, _toured(start, both))
    twice = [(high, 1.0), (low, 1.0), (start, 1.0)] * 2
    yield Candidate(
        "the same cycle twice, at 1 K/min", "what fades with time differs from the first cycle to the second", _toured(start, twice, 1800.0)
    )


def _levels(known: Circumstances) -> Iterator[Candidate]:
    low, high, start = known.low_c, known.high_c, known.start_c
    up = staircase(low, high, (high - low) / 4, 1.0, 2700.0).of(1).legs
    down = tuple((end, begin, seconds) for begin, end, seconds in up[-2::-1])
    path = "at the same temperature reached from below and from above, only what depends on the path differs"
    yield Candidate("a staircase up and down, at 1 K/min", path, (*up, *down))
    span = high - low
    turns = [high, low, low + 0.9 * span, low + 0.15 * span, low + 0.75 * span, low + 0.3 * span, low + 0.6 * span, low + 0.45 * span, high]
    inner = [low + 0.7 * span, low + 0.85 * span, low + 0.45 * span, low + 0.6 * span, low + 0.2 * span, low + 0.35 * span, low, start]
    memory = "loops within loops close for a memory of turning points and do not for one that fades with time"
    yield Candidate("minor loops at several temperatures, at 1 K/min", memory, _toured(start, [(to, 1.0) for to in (*turns, *inner)], 900.0))


def _sines(known: Circumstances) -> Iterator[Candidate]:
    middle = min(max(known.start_c, (known.low_c + known.high_c) / 2), known.high_c)
    most = min(middle - known.low_c, known.high_c - middle)
    why = "gains that grow with the frequency, with its square or not at all, and their phases, come apart"
    for period, cycles in zip(PERIODS_S, CYCLES, strict=True):
        swing = min(most, FASTEST_K_PER_MIN * period / 60.0 / math.tau)
        legs = sine(round(middle, 1), round(swing, 1), period, cycles, HOLD_S).of(1).legs
        yield Candidate(f"a sine of {period / 60:g} min, ±{swing:.0f} K", why, tuple((round(a, 3), round(b, 3), s) for a, b, s in legs))


def _rests(known: Circumstances) -> Iterator[Candidate]:
    low, high, start = known.low_c, known.high_c, known.start_c
    soak = ((start, start, HOLD_S), *_ramp(start, high), (high, high, SOAK_S), *_ramp(high, low), (low, low, SOAK_S), *_ramp(low, start))
    slow = "what is slow goes on in a hold, faster where it is hot, when all that follows the temperature has settled"
    yield Candidate("a long hot and a long cold soak", slow, (*soak, (start, start, HOLD_S)))
    hot = ((start, start, HOLD_S), *_ramp(start, high), (high, high, DAY_S), *_ramp(high, start), (start, start, SOAK_S))
    yield Candidate("a day at the hot end", slow, hot)
    still = "at constant temperature only what goes with time is left"
    yield Candidate("a day of rest at constant temperature", still, ((start, start, DAY_S),))


def _turned(known: Circumstances) -> Iterator[Candidate]:
    rest: Legs = ((known.start_c, known.start_c, 4 * HOLD_S),)
    low, high, start = known.low_c, known.high_c, known.start_c
    once = _toured(start, [(high, 1.0), (low, 1.0), (start, 1.0)])
    both = _toured(start, [(high, 3.0), (low, 3.0), (start, 3.0), (high, 0.5), (low, 0.5), (start, 0.5)])
    for name, legs in {"a rest": rest, "a cycle at 1 K/min": once}.items():
        yield Candidate(f"{name}, the axis turned over every 30 min", FLIP_WORDS, legs, _repeated(OVER, legs), "axis_flip")
    for name, legs in {"a rest": rest, "a cycle at 1 K/min": once, "two cycles, at 3 and at 0.5 K/min": both}.items():
        words = f"{name}, on a rate table that turns at ±1 and ±{FASTER:g} times the true input"
        yield Candidate(words, TABLE_WORDS, legs, _repeated(STEPS, legs), "rate_table")


def _power_ons(known: Circumstances) -> Iterator[Candidate]:
    why = "the gyro's own heat comes from inside, at a constant chamber: what belongs to power-on comes back, what belongs to the chamber does not"
    rest: Legs = ((known.start_c, known.start_c, 4 * HOLD_S),)
    yield Candidate("power-on after a soak without power", why, rest, extra="power_on")


def _repeated(factors: Sequence[float], legs: Legs) -> tuple[tuple[float, float], ...]:
    """Factors on the true input, `TURN_S` each, over and over until the legs end, the last of them 1."""
    seconds = sum(leg[2] for leg in legs)
    count = int(seconds // TURN_S)
    rest = seconds - count * TURN_S
    turns = [(factors[place % len(factors)], TURN_S) for place in range(count)]
    return (*turns, (1.0, rest)) if rest > 1e-6 else tuple(turns)


def _toured(start_c: float, stops: Sequence[tuple[float, float]], hold_s: float = HOLD_S) -> Legs:
    """From stop to stop [°C], each with its rate [K/min], with a hold at each."""
    return tour(start_c, [(to, rate, hold_s) for to, rate in stops], hold_s).of(1).legs


def _ramp(begin_c: float, end_c: float) -> Legs:
    return ((begin_c, end_c, abs(end_c - begin_c) / FASTEST_K_PER_MIN * 60.0),) if begin_c != end_c else ()
