"""A run with ramps of several rates, minor loops and holds, seen from the places where effects live."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
import torch
from torch import Tensor

from zoo.effects.base import History
from zoo.models.places import histories

KNOTS = ((0, 20), (1, 20), (1.5, 55), (2.5, 55), (3, 30), (3.25, 45), (4, 10), (5, 10), (6, -30), (7, -30), (7.5, 0), (7.75, -15), (9, 20), (12, 20))
"""Hours and °C: the temperature is a straight line between them."""
COIL = (300.0, 0.4, 0.0)
STEADY = {"_v": 5.0, "_ut": 0.0, "_pct": 40.0, "_kpa": 100.0}


def straight(time: Tensor, knots: tuple[tuple[float, float], ...]) -> Tensor:
    """(T,) straight lines between knots (h, value), at times in s."""
    at, value = torch.tensor(knots, dtype=torch.float64).T
    at = at * 3600
    i = (torch.searchsorted(at, time, right=True) - 1).clamp(0, len(at) - 2)
    return value[i] + (value[i + 1] - value[i]) * (time - at[i]) / (at[i + 1] - at[i])


def wandering(name: str, time: Tensor) -> Tensor:
    """A recorded input of no particular meaning, straight between knots as well."""
    steady = next(value for suffix, value in STEADY.items() if name.endswith(suffix))
    knots = tuple((hour, steady + math.sin(1.7 * place + len(name)) + 0.3) for place, (hour, _) in enumerate(KNOTS))
    return straight(time, knots)


@pytest.fixture
def places() -> Callable[..., dict[str, History]]:
    """Makes what effects see at each place.

    The keywords: needs (recorded columns), step_s [s], knots of the main thermometer (the outer one leads it by 5 min), run, inputs (column -> value,
    constant), start_s (the clock's first reading), coil (lag in s and weight, may carry batch axes).
    """

    def make(
        needs: Any = (), step_s: float = 60.0, knots: Any = KNOTS, run: int = 1, inputs: Any = None, start_s: float = 0.0, coil: Any = COIL
    ) -> dict[str, History]:
        time = torch.arange(0, knots[-1][0] * 3600 + step_s / 2, step_s, dtype=torch.float64)
        earlier = [(max(0.0, hour - 1 / 12), value) for hour, value in knots[:-1]]
        outer = straight(time, (*earlier, knots[-1]))
        table = {"reference": 9.66 * torch.sin(time / 3000)}
        for name in needs:
            table[name] = wandering(name, time) if inputs is None else torch.full_like(time, inputs[name])
        thermometers = torch.stack([straight(time, knots), outer], dim=-1)
        theta = torch.as_tensor(coil, dtype=torch.float64)
        return histories(time + start_s, table, thermometers, theta, run)

    return make


@pytest.fixture
def seen(places: Callable[..., dict[str, History]]) -> Callable[..., History]:
    """Makes what one effect sees; the keywords are those of `places`."""
    return lambda effect, **keywords: places(effect.needs, **keywords)[effect.place]


@pytest.fixture
def warped() -> Callable[[History, Tensor, Tensor], History]:
    """Makes the same history from another course of the place's temperature (T',) at times (T',): nothing but temperature, time and rate is left."""

    def make(history: History, time: Tensor, temperature: Tensor) -> History:
        rate = torch.gradient(temperature, spacing=(time / 60,))[0]
        zero = torch.zeros_like(time)
        inputs = dict.fromkeys(history.inputs, zero)
        return replace(history, time=time, temperature=temperature, rate=rate, gradient=zero, thermometer=temperature, reference=zero, inputs=inputs)

    return make
