"""Ageing: slow drift with the time in operation."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import History, Parameter, grid_values
from zoo.effects.earlier import GOES_ON, Continuing, anew_or_on

LATE_S, HOUR_S = 36000.0, 3600.0
STEEPEST = 0.7
"""By how much an exponent may be below 1."""
OTHERS = 32
"""How many shapes of either law are looked at around the best."""
LEAST = 1e-30
"""Least that a logarithm or a power is taken of; a line in time to rounding."""


class Aging(Continuing):
    """Drift A·ln(1 + t/τ)/ln(1 + 10 h/τ), τ = 1 h/|β|, or for β > 0 A·(t/10 h)^(1 − 0.7·β), t since the run's first sample, or the first run's.

    A population of relaxations with a broad spread of rates gives the logarithm; what diffuses, such as what leaves a coating, gives a root, whose
    slope has no end at the start. Between the two, at β = 0, both are a straight line in time. A gyro that has rested starts anew with every run; one
    that was left as it is goes on (`zoo.effects.earlier`).
    """

    name = "aging"
    runs_together = True
    place = "housing"
    shape = (
        Parameter("bend", -0.01, "1", -1.0, 1.0, source="prior: τ of hours to months, or exponents from 0.3", meaning="β", grid=24),
        GOES_ON,
    )
    amplitudes = (Parameter("drift", 0.0, "unit", -10.0, 10.0, source="prior: 1e-3–1e-2 °/h/month, more when new", meaning="after 10 h"),)
    formula = "A·ln(1 + t/τ)/ln(1 + 10 h/τ), τ = 1 h/|β|; β > 0: A·(t/10 h)^(1 − 0.7·β)"
    source = "logarithmic ageing: Primak 1955, Phys. Rev. 100:1677; roots: Crank 1975, The Mathematics of Diffusion, 2.4"
    signature = "monotone in time, whatever the temperature does"
    confused_with = ("moisture", "warm_up", "viscoelastic")

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """Of either law, each anew in every run and going on, see `Effect.shapes_to_try`."""
        del span_s
        return torch.cartesian_prod(grid_values(self.shape[0], runs), anew_or_on(runs))

    def shapes_near(self, shape: Tensor, span_s: float) -> Tensor:
        """The shape itself and others of either law, anew and going on: no step leads from one to the other, see `Effect.shapes_near`."""
        del span_s
        other = torch.linspace(-1.0, 1.0, OTHERS, dtype=shape.dtype, device=shape.device)
        return torch.cat([shape.unsqueeze(0), torch.cartesian_prod(other * other.abs(), torch.stack([shape[1], 1.0 - shape[1]]))])

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """The normalised logarithm or power, see `Effect.columns`."""
        bend, goes_on = shape[..., 0:1], shape[..., 1:2].round()
        time = history.time + goes_on * self.earlier.dwelt(torch.zeros_like(bend) + history.run).sum(-1)
        pace = (-bend).clamp_min(LEAST) / HOUR_S
        logarithm = torch.log1p(pace * time) / torch.log1p(pace * LATE_S)
        power = (time / LATE_S).clamp_min(LEAST) ** (1.0 - STEEPEST * bend.clamp_min(0.0))
        return torch.where(bend < 0, logarithm, power).unsqueeze(-1)
