"""Ageing: slow drift with the time in operation."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter

LATE_S = 36000.0


class Aging(Effect):
    """Drift A·ln(1 + t/τ)/ln(1 + 10 h/τ) + B·√(t/10 h) with t since the run's first sample.

    A population of relaxations with a broad spread of rates gives the logarithm; for τ far above the run's length it is a straight line in time. What
    diffuses, such as what leaves a coating, gives the root, whose slope has no end at the start. Powers of t from 0.3 to 1 are sums of both.
    """

    name = "aging"
    runs_together = True
    place = "housing"
    shape = (Parameter("time", 100.0, "h", 1.0, 1000.0, "log", source="prior: hours to months", meaning="where the drift starts to slow down"),)
    amplitudes = (
        Parameter("drift", 0.0, "unit", -10.0, 10.0, source="prior: 1e-3–1e-2 °/h/month, more when new", meaning="A, after 10 h"),
        Parameter("diffusion", 0.0, "unit", -10.0, 10.0, source="prior: as the drift's", meaning="B, after 10 h"),
    )
    formula = "A·ln(1 + t/τ)/ln(1 + 10 h/τ) + B·√(t/10 h)"
    source = "logarithmic ageing: Primak 1955, Phys. Rev. 100:1677; diffusion: Crank 1975, The Mathematics of Diffusion, 2.4"
    signature = "monotone in time, whatever the temperature does"
    confused_with = ("moisture", "warm_up", "viscoelastic")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """The logarithm and the root, both 1 after 10 h, see `Effect.columns`."""
        tau = shape[..., 0:1] * 3600.0
        logarithm = torch.log1p(history.time / tau) / torch.log1p(LATE_S / tau)
        return torch.stack(torch.broadcast_tensors(logarithm, (history.time / LATE_S).sqrt()), dim=-1)
