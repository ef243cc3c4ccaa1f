"""A Mohr coefficient that changes with temperature."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import REFERENCE_C, Effect, History, Parameter, spread


class RateTemperatureCoupling(Effect):
    """Error (c1·θ + c2·θ²)·dT/dt with θ = T − 20 °C.

    n_T falls with temperature, the potting softens, the conductivity changes: C_M(T) is not a constant, and n_T itself is quadratic in T
    (measured slope 0.2–1 % per K of C_M, prior).
    """

    name = "rate_temperature_coupling"
    runs_together = True
    amplitudes = (
        Parameter("slope", 0.0, "unit/(K/min)/K", -1.0, 1.0, source="prior: 0.2–1 %/K of C_M", meaning="dC_M/dT"),
        Parameter("curvature", 0.0, "unit/(K/min)/K^2", -0.1, 0.1, source="prior: n_T quadratic in T", meaning="½ d²C_M/dT²"),
    )
    formula = "(c1·θ + c2·θ²)·dT/dt,  θ = T − 20 °C"
    source = "Sensors 15, 11189 (2015) uses the product term"
    signature = "a slope in temperature during ramps, opposite sign while cooling, zero in a hold"
    confused_with = ("glass_transition",)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """θ·dT/dt [K·K/min] and θ²·dT/dt, see `Effect.columns`; no shape."""
        theta = history.temperature - REFERENCE_C
        columns = torch.stack([theta * history.rate, theta**2 * history.rate], dim=-1)
        return spread(columns, shape)
