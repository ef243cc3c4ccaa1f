"""Programs of a test: what the chamber's controller asks for, as straight legs, and what a rate table turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.given import is_number

ABSOLUTE_ZERO_C = -273.15
HOTTEST_C = 1000.0
LONGEST_S = 100 * 86400.0
FASTEST_DPH = 1e9
LEG = "[from °C, to °C, seconds]"
PIECE = "[rate, seconds]"


@dataclass(frozen=True)
class Program:
    """Air temperature asked for, leg after leg, and true rate, piece after piece; a jump between two legs is a step of the set point.

    Attributes:
        legs: from [°C], to [°C], duration [s].
        rates: true rate about the input axis [°/h], duration [s]; after the last piece, or without any, the table stands still.
    """

    legs: tuple[tuple[float, float, float], ...]
    rates: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        """Check every leg and every rate.

        Raises:
            InputError: no legs, a leg or piece that is not numbers, a duration that is not positive, a temperature or rate that cannot be, or
                a table that turns longer than the program lasts.
        """
        if not self.legs:
            raise InputError(f"the program has no legs; give profile.legs=[{LEG}, …]")
        for place, leg in enumerate(self.legs, 1):
            _check_leg(leg, f"leg {place} of the program, {list(leg)}")
        if self.seconds > LONGEST_S:
            raise InputError(f"the program lasts {self.seconds:.6g} s; at most {LONGEST_S:.0f} s (100 days) is possible")
        for place, piece in enumerate(self.rates, 1):
            _check_piece(piece, f"piece {place} of the rates, {list(piece)}")
        if self._turning_s > self.seconds * (1 + 1e-9):
            raise InputError(f"the rates last {self._turning_s:.9g} s, the program only {self.seconds:.9g} s; give fewer or shorter rates")

    @property
    def seconds(self) -> float:
        """Length of the whole program."""
        return sum(leg[2] for leg in self.legs)

    @property
    def _turning_s(self) -> float:
        return sum(seconds for _, seconds in self.rates)

    @property
    def range_c(self) -> tuple[float, float]:
        """Coldest and hottest temperature asked for [°C]."""
        ends = [value for leg in self.legs for value in leg[:2]]
        return min(ends), max(ends)

    def reversed(self) -> Program:
        """The same legs backwards in time, and the same rates: another order over the same temperatures."""
        still = self.seconds - self._turning_s
        first = ((0.0, still),) if self.rates and still > 1e-9 * self.seconds else ()
        return Program(tuple((end, start, seconds) for start, end, seconds in self.legs[::-1]), (*first, *self.rates[::-1]))

    def leg(self, time: Tensor) -> Tensor:
        """Which leg goes on, counted from 0: (T,) [s] -> (T,); where two meet, the later one; after the last, their number."""
        return torch.searchsorted(_ends(self.legs, time.dtype), time, right=True)

    def asked(self, time: Tensor) -> Tensor:
        """Set point: (T,) [s] -> (T,) [°C]; after the last leg its end is held."""
        legs = torch.tensor(self.legs, dtype=time.dtype)
        leg = self.leg(time).clamp_max(len(legs) - 1)
        share = ((time - _ends(self.legs, time.dtype)[leg]) / legs[leg, 2] + 1).clamp(0.0, 1.0)
        return legs[leg, 0] + share * (legs[leg, 1] - legs[leg, 0])

    def rate(self, time: Tensor, step_s: float = 0.0) -> Tensor:
        """True rate as rows show it that are means over the step that begins at their time, as the rows of the output are.

        Blocks of rows and the random processes of the output count time in the same way. A row within one piece has exactly its rate.

        Args:
            time: (T,) [s].
            step_s: sampling step [s]; 0 for the rate at the moment itself, where two pieces meet that of the later one.

        Returns:
            (T,) [°/h].
        """
        pieces = torch.tensor((*self.rates, (0.0, 2 * LONGEST_S)), dtype=time.dtype)
        ends = torch.cumsum(pieces[:, 1], 0)
        first = torch.searchsorted(ends, time, right=True)
        if step_s == 0:
            return pieces[first, 0]
        last = torch.searchsorted(ends, time + step_s)
        turned = torch.cumsum(pieces[:, 0] * pieces[:, 1], 0)
        before, after = (turned[piece] - pieces[piece, 0] * (ends[piece] - at) for piece, at in ((first, time), (last, time + step_s)))
        return torch.where(first == last, pieces[first, 0], (after - before) / step_s)


def _ends(legs: Sequence[Sequence[float]], dtype: torch.dtype) -> Tensor:
    """(L,) when each leg ends [s]."""
    return torch.tensor(list(accumulate(leg[-1] for leg in legs)), dtype=dtype)


def _check_numbers(values: Sequence[float], count: str, where: str, form: str) -> None:
    """Finite numbers, as many as the form has, the last one a positive duration."""
    finite = all(map(is_number, values))
    if len(values) != form.count(",") + 1 or not finite:
        raise InputError(f"{where}: {count} numbers are expected, {form}")
    if values[-1] <= 0:
        raise InputError(f"{where}: lasts {values[-1]:g} s; a positive duration is expected")


def _check_leg(leg: Sequence[float], where: str) -> None:
    _check_numbers(leg, "three", where, LEG)
    for value in leg[:2]:
        if not ABSOLUTE_ZERO_C <= value <= HOTTEST_C:
            raise InputError(f"{where}: {value:g} °C is out of reach; {ABSOLUTE_ZERO_C} °C (absolute zero) to {HOTTEST_C:g} °C is possible")


def _check_piece(piece: Sequence[float], where: str) -> None:
    _check_numbers(piece, "two", where, PIECE)
    if abs(piece[0]) > FASTEST_DPH:
        raise InputError(f"{where}: {piece[0]:g} °/h is out of reach; {-FASTEST_DPH:g} to {FASTEST_DPH:g} °/h is possible")


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
