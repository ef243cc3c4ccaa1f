"""Ageing: slow drift with the time in operation."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter

LATE_S, HOUR_S = 36000.0, 3600.0
STEEPEST = 0.7
"""By how much an exponent may be below 1."""
OTHERS = 32
"""How many shapes of either law are looked at around the best."""
LEAST = 1e-30
"""Least that a logarithm or a power is taken of; a line in time to rounding."""


class Aging(Effect):
    """Drift A·ln(1 + t/τ)/ln(1 + 10 h/τ), τ = 1 h/|β|, or for β > 0 A·(t/10 h)^(1 − 0.7·β), with t since the run's first sample.

    A population of relaxations with a broad spread of rates gives the logarithm; what diffuses, such as what leaves a coating, gives a root, whose
    slope has no end at the start. Between the two, at β = 0, both are a straight line in time.
    """

    name = "aging"
    runs_together = True
    place = "housing"
    shape = (Parameter("bend", -0.01, "1", -1.0, 1.0, source="prior: τ of hours to months, or exponents from 0.3", meaning="β", grid=24),)
    amplitudes = (Parameter("drift", 0.0, "unit", -10.0, 10.0, source="prior: 1e-3–1e-2 °/h/month, more when new", meaning="after 10 h"),)
    formula = "A·ln(1 + t/τ)/ln(1 + 10 h/τ), τ = 1 h/|β|; β > 0: A·(t/10 h)^(1 − 0.7·β)"
    source = "logarithmic ageing: Primak 1955, Phys. Rev. 100:1677; roots: Crank 1975, The Mathematics of Diffusion, 2.4"
    signature = "monotone in time, whatever the temperature does"
    confused_with = ("moisture", "warm_up", "viscoelastic")

    def shapes_near(self, shape: Tensor, span_s: float) -> Tensor:
        """The shape itself and others of either law: no step leads from a logarithm to a power, see `Effect.shapes_near`."""
        del span_s
        other = torch.linspace(-1.0, 1.0, OTHERS, dtype=shape.dtype, device=shape.device)
        return torch.cat([shape, other * other.abs()]).unsqueeze(-1)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """The normalised logarithm or power, see `Effect.columns`."""
        bend = shape[..., 0:1]
        pace = (-bend).clamp_min(LEAST) / HOUR_S
        logarithm = torch.log1p(pace * history.time) / torch.log1p(pace * LATE_S)
        power = (history.time / LATE_S).clamp_min(LEAST) ** (1.0 - STEEPEST * bend.clamp_min(0.0))
        return torch.where(bend < 0, logarithm, power).unsqueeze(-1)
