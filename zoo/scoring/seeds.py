"""Methods of which each was tried with several seeds: the spread of one, and whether one is better than another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import torch
from torch import Generator, Tensor

RESAMPLES = 2000
ENOUGH = 6
"""Fewer pairs that all agree are no evidence at 95 %: a sign test's two-sided level is 2·2⁻ⁿ."""
RANGE = (0.05, 0.95)
"""Quantiles of the 90 % range over seeds."""
SURE = (0.025, 0.975)
"""Quantiles of a 95 % interval."""


@dataclass(frozen=True)
class Spread:
    """Values over seeds.

    Attributes:
        median: of them.
        low: their 5 % quantile.
        high: their 95 % quantile.
        interval: 95 % for the median; None below six seeds.
    """

    median: float
    low: float
    high: float
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class Contest:
    """One method against another, over seeds.

    Attributes:
        ratio: median of the first over the median of the second.
        interval: 95 % for the ratio; None where one of them has two to five seeds, or both have one.
        wins: seeds with which the first is lower.
        ties: seeds with which both are equal.
        seeds: how many were compared.
        paired: whether they were compared seed by seed; else every seed of one with every seed of the other is a win or not.
    """

    ratio: float
    interval: tuple[float, float] | None
    wins: int
    ties: int
    seeds: int
    paired: bool


def spread(values: Tensor, generator: Generator) -> Spread:
    """Median and 90 % range of (E,) values, one a seed, and the bootstrap's interval for the median (Efron & Tibshirani 1993, ch. 13)."""
    low, high = (float(value) for value in values.quantile(values.new_tensor(RANGE)))
    drawn = _drawn(values.numel(), generator, values)
    interval = _interval(_medians(values[drawn])) if values.numel() >= ENOUGH else None
    return Spread(float(values.quantile(0.5)), low, high, interval)


def contest(first: Mapping[int, float], second: Mapping[int, float], generator: Generator) -> Contest:
    """Whether the first method's values are lower than the second's.

    Seeds that both have are drawn together: what a seed makes of the start, it makes of both, and the ratio of the medians scatters less than if each
    were drawn by itself. Without common seeds, each is drawn by itself; a method that has one value only is taken for a constant, which one seed of
    several that it might have had is not: who compares must know.

    Args:
        first: value by seed.
        second: value by seed.
        generator: of the resampling.
    """
    common = sorted(first.keys() & second.keys())
    if min(len(first), len(second)) > 1 and len(common) > 1:
        return _paired(_tensor([first[seed] for seed in common]), _tensor([second[seed] for seed in common]), generator)
    return _apart(_tensor(list(first.values())), _tensor(list(second.values())), generator)


def _paired(a: Tensor, b: Tensor, generator: Generator) -> Contest:
    drawn = _drawn(a.numel(), generator, a)
    interval = _interval(_medians(a[drawn]) / _medians(b[drawn])) if a.numel() >= ENOUGH else None
    return Contest(_ratio(a, b), interval, int((a < b).sum()), int((a == b).sum()), a.numel(), paired=True)


def _apart(a: Tensor, b: Tensor, generator: Generator) -> Contest:
    medians = [_medians(one[_drawn(one.numel(), generator, one)]) for one in (a, b)]
    # One value is no sample: all of it that varies is the other's seeds.
    enough = all(one.numel() == 1 or one.numel() >= ENOUGH for one in (a, b)) and a.numel() + b.numel() > 2
    interval = _interval(medians[0] / medians[1]) if enough else None
    wins, ties = (int(found.sum()) for found in (a.unsqueeze(1) < b, a.unsqueeze(1) == b))
    return Contest(_ratio(a, b), interval, wins, ties, a.numel() * b.numel(), paired=min(a.numel(), b.numel()) == 1)


def _tensor(values: list[float]) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)


def _ratio(a: Tensor, b: Tensor) -> float:
    return float(a.quantile(0.5) / b.quantile(0.5))


def _drawn(count: int, generator: Generator, like: Tensor) -> Tensor:
    """(R, E) places of each resample."""
    return torch.randint(count, (RESAMPLES, count), generator=generator).to(like.device)


def _medians(values: Tensor) -> Tensor:
    """(R, E) -> (R,), the mean of the two in the middle where E is even."""
    return values.quantile(0.5, dim=1)


def _interval(values: Tensor) -> tuple[float, float]:
    low, high = (float(value) for value in values.quantile(values.new_tensor(SURE)))
    return low, high
