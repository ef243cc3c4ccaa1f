"""Chamber programs: what the chamber's controller asks for, as straight legs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.physics.lag import lagged

ABSOLUTE_ZERO_C = -273.15
HOTTEST_C = 1000.0
LONGEST_S = 100 * 86400.0
LEG = "[from °C, to °C, seconds]"


@dataclass(frozen=True)
class Program:
    """Air temperature asked for, leg after leg; a jump between two legs is a door opened to another chamber.

    Attributes:
        legs: from [°C], to [°C], duration [s].
    """

    legs: tuple[tuple[float, float, float], ...]

    def __post_init__(self) -> None:
        """Check every leg.

        Raises:
            InputError: no legs, a leg that is not three numbers, a duration that is not positive, a temperature that cannot be.
        """
        if not self.legs:
            raise InputError(f"the program has no legs; give profile.legs=[{LEG}, …]")
        for place, leg in enumerate(self.legs, 1):
            _check(leg, f"leg {place} of the program, {list(leg)}")
        if self.seconds > LONGEST_S:
            raise InputError(f"the program lasts {self.seconds:.6g} s; at most {LONGEST_S:.0f} s (100 days) is possible")

    @property
    def seconds(self) -> float:
        """Length of the whole program."""
        return sum(leg[2] for leg in self.legs)

    @property
    def range_c(self) -> tuple[float, float]:
        """Coldest and hottest temperature asked for [°C]."""
        ends = [value for leg in self.legs for value in leg[:2]]
        return min(ends), max(ends)

    def reversed(self) -> Program:
        """The same legs backwards in time: another order over the same temperatures."""
        return Program(tuple((end, start, seconds) for start, end, seconds in self.legs[::-1]))

    def asked(self, time: Tensor) -> Tensor:
        """Set point: (T,) [s] -> (T,) [°C]; after the last leg its end is held."""
        legs = torch.tensor(self.legs, dtype=time.dtype)
        ends = torch.cumsum(legs[:, 2], 0)
        leg = torch.searchsorted(ends, time, right=True).clamp_max(len(legs) - 1)
        share = ((time - ends[leg]) / legs[leg, 2] + 1).clamp(0.0, 1.0)
        return legs[leg, 0] + share * (legs[leg, 1] - legs[leg, 0])

    def air(self, time: Tensor, chamber_s: float) -> Tensor:
        """What the air does, a first-order lag behind the set point.

        Args:
            time: (T,) [s].
            chamber_s: the chamber's time constant [s], 0 for none.

        Returns:
            (T,) [°C].
        """
        asked = self.asked(time)
        return lagged(time, asked, torch.tensor(chamber_s, dtype=time.dtype)) if chamber_s > 0 else asked


def _check(leg: Sequence[float], where: str) -> None:
    if len(leg) != 3 or not all(isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value) for value in leg):
        raise InputError(f"{where}: three numbers are expected, {LEG}")
    if leg[2] <= 0:
        raise InputError(f"{where}: lasts {leg[2]:g} s; a leg needs a positive duration")
    for value in leg[:2]:
        if not ABSOLUTE_ZERO_C <= value <= HOTTEST_C:
            raise InputError(f"{where}: {value:g} °C is out of reach; {ABSOLUTE_ZERO_C} °C (absolute zero) to {HOTTEST_C:g} °C is possible")


@dataclass(frozen=True)
class Campaign:
    """Which program each run gets.

    Attributes:
        runs: programs of run 1, 2, …; from the start again when there are more runs.
        check: program of the run that is never fitted.
    """

    runs: tuple[Program, ...]
    check: Program

    def of(self, run: int) -> Program:
        """Program of a run, counted from 1."""
        return self.runs[(run - 1) % len(self.runs)]
