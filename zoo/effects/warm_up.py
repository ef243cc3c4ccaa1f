"""Warm-up: what decays after power-on whatever the chamber does."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter


class WarmUp(Effect):
    """Error A·exp(−t/τ) with t since the run's first sample, taken as power-on.

    The source, the cooler and the electronics heat up within minutes, the body within tens of minutes.
    """

    name = "warm_up"
    runs_together = True
    place = "housing"
    shape = (Parameter("time", 1200.0, "s", 60.0, 7200.0, "log", source="prior: τ1 1–3 min, τ2 10–40 min", meaning="e-folding time"),)
    amplitudes = (Parameter("amplitude", 0.0, "unit", -10.0, 10.0, source="prior: 0.02–0.3 medium, 0.3–3 tactical", meaning="at power-on"),)
    formula = "A·exp(−t/τ)"
    source = "Kuznetsov et al. 2012, DOI 10.15588/1607-3274-2012-2-26"
    signature = "decays from the start of every run, at any temperature"
    confused_with = ("aging", "moisture")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """exp(−t/τ), see `Effect.columns`."""
        return torch.exp(-history.time / shape[..., 0:1]).unsqueeze(-1)
