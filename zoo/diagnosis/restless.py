"""A residual that follows nothing smooth: how fast it changes, and between what."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.diagnosis.form_words import number
from zoo.diagnosis.moments import moments, rarity
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.swings import Swings, recurrence, swings
from zoo.diagnosis.switching import switching
from zoo.diagnosis.workbench import Workbench
from zoo.measurements.run import Run
from zoo.physics.differentiator import temperature_rate
from zoo.units import SECONDS_PER_MINUTE, symbol

FAR_AHEAD = 5.0
"""Evidence of two levels over that of a band: a sine has them half as well (1.1 to 2.6 found), what jumps has no band to speak of (18 and more)."""
CHAMBERS_S = 120.0, 720.0
"""Periods at which a chamber's compressor or heater is switched. Engineering prior: 2 to 10 min, and what its load makes of them."""
ALIKE, NEAR = 3, 0.1
"""How many moments within which share of the range of temperatures are no chance: three within a tenth are so by chance in 3 of 100."""


def restless(bench: Workbench, solved: Solved) -> str:
    """How the residual of a model comes and goes, in a sentence: between two levels, at few moments, in a band of periods, or at random."""
    parts = list(solved.residual.split([run.blocks for run in bench.runs]))
    step, unit = bench.runs[0].average_s, symbol(bench.runs[0].unit)
    levels, band = switching(bench, solved), swings(bench, solved)
    if levels.matters and not (band.matters and levels.evidence < FAR_AHEAD * band.evidence):
        apart, dwell = number(levels.apart, 2), _minutes(levels.dwell_s)
        return f"It comes and goes at random: two levels {apart} {unit} apart, switching every {dwell} on average."
    found = moments(bench, solved)
    if found and rarity(bench, solved) > 1.0:
        return f"It happens at few moments: {_told(found)}{_in_common(bench, found)}."
    if band.matters and (line := recurrence(bench, solved)):
        phase = "" if line.runs == 1 else ", with the same phase in all runs" if line.alike else ", in each run with a phase of its own"
        return f"It recurs every {_minutes(line.period_s)}{phase}."
    if band.matters:
        return f"It swings, with no period that stays: every {' to '.join(_minutes(period) for period in band.periods_s)}.{_as_a_chamber(band)}"
    blocks = correlation_time(parts)
    if blocks <= 1.0:
        return f"It is new in every block of {number(step)} s: noise of another level or with outliers, rather than an effect."
    return f"It wanders: values {_minutes(blocks * step)} apart are hardly related, and none is preferred."


def correlation_time(parts: list[Tensor]) -> float:
    """Lag in samples at which the correlation within runs has fallen to 1/e, linear between whole lags."""
    variance = sum(float(part.square().sum()) for part in parts) / sum(len(part) for part in parts)
    before, longest = 1.0, max(len(part) for part in parts) // 2
    for lag in range(1, longest + 1):
        pairs = [(part[:-lag], part[lag:]) for part in parts if len(part) > lag]
        now = sum(float((one * other).sum()) for one, other in pairs) / (variance * sum(len(one) for one, _ in pairs))
        if now <= math.exp(-1.0):
            return lag - 1 + (before - math.exp(-1.0)) / (before - now)
        before = now
    return float(longest)


def _told(found: list[tuple[str, float]]) -> str:
    """Moments by run: run_1 at 2.23 and 5.93 h, run_2 at 3.12 h."""
    hours: dict[str, list[str]] = {}
    for name, hour in found:
        hours.setdefault(name, []).append(f"{hour:.2f}")
    return ", ".join(f"{name} at {' and '.join(each)} h" for name, each in hours.items())


def _in_common(bench: Workbench, found: list[tuple[str, float]]) -> str:
    """At which temperature the moments are, where they are alike in it as chance seldom makes three: something sets in there."""
    runs = {run.name: run for run in bench.runs}
    temperatures = torch.cat([run.block_mean(run.temperature) for run in bench.runs])
    places = [(runs[name], int((_hours(runs[name]) - hour).abs().argmin())) for name, hour in found]
    here = torch.stack([run.temperature[place] for run, place in places])
    if len(found) < ALIKE or float(here.max() - here.min()) > NEAR * float(temperatures.max() - temperatures.min()):
        return ""
    rates = [float(temperature_rate(run.time, run.temperature)[place]) for run, place in places]
    way = " while it warms" if min(rates) > 0 else " while it cools" if max(rates) < 0 else ""
    return f", each time with the thermometer between {number(float(here.min()), 3)} and {number(float(here.max()), 3)} °C{way}"


def _as_a_chamber(band: Swings) -> str:
    """What swings so, where the periods are those of a chamber: a line whose phase wanders as far is no `chamber_cycling`."""
    if band.periods_s[0] < CHAMBERS_S[0] or band.periods_s[1] > CHAMBERS_S[1]:
        return ""
    return " So does the air of a chamber whose compressor or heater is switched as its load wants it: a record of that air, as a column, would tell."


def _hours(run: Run) -> Tensor:
    """(T,) since the run's first row [h]."""
    return (run.time - run.time[0]) / 3600.0


def _minutes(seconds: float) -> str:
    return f"{number(seconds / SECONDS_PER_MINUTE, 2)} min"
