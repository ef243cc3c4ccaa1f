"""What a log has besides temperatures: the supply's voltage and the magnetic field, both slow, both with a will of their own."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.physics.recurrence import affine
from zoo.simulator.streams import Span, normal, sign, stream, uniform

NAMES = ("supply_v", "field_ut")
SUPPLY_V = 5.0
WANDER_S = 1200.0
DWELL_S = 1800.0
PERIOD = Span(3600.0, 18000.0, "s")
FIELD = Span(10.0, 50.0, "µT")


def wander(count: int, step_s: float, generator: torch.Generator) -> Tensor:
    """(count,) Ornstein–Uhlenbeck process of unit variance and 20 min correlation time."""
    decay = math.exp(-step_s / WANDER_S)
    kicks = math.sqrt(1 - decay**2) * normal(count, generator)
    return affine(torch.tensor(decay, dtype=torch.float64), kicks, normal(1, generator)[0])


def switching(count: int, step_s: float, generator: torch.Generator) -> Tensor:
    """(count,) −1 or 1, as a heater's relay that changes every half hour on average."""
    flips = torch.rand(count, generator=generator, dtype=torch.float64) < 1 - math.exp(-step_s / DWELL_S)
    return 1.0 - 2.0 * (torch.cumsum(flips, 0) % 2)


def wave(time: Tensor, generator: torch.Generator) -> Tensor:
    """(T,) sine of unit amplitude with a period of one to five hours."""
    return torch.sin(2 * math.pi * (time / PERIOD.draw(generator) + uniform(generator)))


def recorded_inputs(time: Tensor, step_s: float, seed: int, run: object) -> dict[str, Tensor]:
    """Supply voltage and field of one run, rounded as a logger does; the gyro feels what is recorded.

    Args:
        time: (T,) [s].
        step_s: sampling step [s].
        seed: the user's.
        run: which run.

    Returns:
        Columns `NAMES`, each (T,) [V] and [µT].
    """
    supply, field = stream(seed, "supply", run), stream(seed, "field", run)
    base = stream(seed, "field")
    volts = SUPPLY_V + 0.05 * wave(time, supply) + 0.02 * wander(len(time), step_s, supply)
    steady = sign(base) * FIELD.draw(base)
    slow = 4.0 * wave(time, field) + 2.0 * wander(len(time), step_s, field)
    jumps = 5.0 * switching(len(time), step_s, field)
    return {"supply_v": volts.round(decimals=4), "field_ut": (steady + slow + jumps).round(decimals=2)}
