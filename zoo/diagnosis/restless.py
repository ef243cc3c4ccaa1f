"""A residual that follows nothing smooth: how fast it changes, and between what."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.diagnosis.form_words import number
from zoo.diagnosis.moments import moments, rarity
from zoo.diagnosis.swings import swings
from zoo.diagnosis.workbench import Solved, Workbench
from zoo.units import symbol

TWO_LEVELS = 0.24
"""Share of the variance that two levels may leave; they leave 0.36 of a Gaussian's (1 − 2/π) and 0.25 of what is anywhere between two bounds."""
SWITCHED = 0.5
"""Part of the way from the middle to the other level beyond which it has switched: noise around the middle is no switch."""
ROUNDS = 20
SECONDS_PER_MINUTE = 60.0


def restless(bench: Workbench, solved: Solved) -> str:
    """How the residual of a model comes and goes, in a sentence: between two levels, at few moments, in a band of periods, or at random."""
    parts = list(solved.residual.split([run.blocks for run in bench.runs]))
    step, unit = bench.runs[0].average_s, symbol(bench.runs[0].unit)
    low, high, left = two_levels(solved.residual)
    if left < TWO_LEVELS:
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        dwell = dwell_time([(part - middle) / half for part in parts]) * step
        return f"It comes and goes at random: two levels {number(high - low, 2)} {unit} apart, switching every {_minutes(dwell)} on average."
    found = moments(bench, solved)
    if found and rarity(bench, solved) > 1.0:
        return f"It happens at few moments: {_told(found)}."
    band = swings(bench, solved)
    if band.matters:
        return f"It swings, with no period that stays: every {' to '.join(_minutes(period) for period in band.periods_s)}."
    blocks = correlation_time(parts)
    if blocks <= 1.0:
        return f"It is new in every block of {number(step)} s: noise of another level or with outliers, rather than an effect."
    return f"It wanders: values {_minutes(blocks * step)} apart are hardly related, and none is preferred."


def two_levels(values: Tensor) -> tuple[float, float, float]:
    """Lower and upper level that leave least of values (N,), and the share of the variance that they leave (two means; Lloyd 1982)."""
    low, high = values.quantile(0.1), values.quantile(0.9)
    for _ in range(ROUNDS):
        upper = values > 0.5 * (low + high)
        if upper.all() or not upper.any():
            return float(low), float(high), 1.0
        low, high = values[~upper].mean(), values[upper].mean()
    upper = values > 0.5 * (low + high)
    left = (values - torch.where(upper, high, low)).square().mean() / values.var(correction=0)
    return float(low), float(high), float(left)


def dwell_time(parts: list[Tensor]) -> float:
    """Mean stay on one of the levels −1 and 1, in samples."""
    switches = 0
    for part in parts:
        clear = part[part.abs() > SWITCHED].sign()
        switches += int((clear[1:] != clear[:-1]).sum())
    return sum(len(part) for part in parts) / (switches + len(parts))


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


def _minutes(seconds: float) -> str:
    return f"{number(seconds / SECONDS_PER_MINUTE, 2)} min"
