"""Bias as a function of the temperature alone."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import REFERENCE_C, Effect, History, Parameter, spread


class StaticBias(Effect):
    """Quasi-static bias b(T) = b0 + b1·θ + b2·θ² + b3·θ³ with θ = T − 20 °C.

    Sources: modulation cross-talk, detector and ADC offsets, phase error of the integrated optics. Order 1 to 3 is what fits in the literature.
    """

    name = "static_bias"
    runs_together = True
    amplitudes = (
        Parameter("offset", 0.0, "unit", -1e3, 1e3, source="engineering prior", meaning="bias at 20 °C"),
        Parameter("slope", 0.0, "unit/K", -10.0, 10.0, source="prior: 0.5–5e-3 °/h/K (medium)", meaning="temperature coefficient"),
        Parameter("curvature", 0.0, "unit/K^2", -1.0, 1.0, source="prior: 30 % of the slope's share", meaning="second order"),
        Parameter("cubic", 0.0, "unit/K^3", -0.1, 0.1, source="prior: 10 % of the slope's share", meaning="third order"),
    )
    formula = "b0 + b1·θ + b2·θ² + b3·θ³,  θ = T − 20 °C"
    source = "IEEE Std 952 D_T; Sensors 15, 11189 (2015)"
    signature = "follows the temperature, the same while heating and cooling, constant in a hold"
    confused_with = ("scale_factor", "misalignment", "magnetic")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Powers 0 to 3 of θ, see `Effect.columns`; no shape."""
        theta = history.temperature - REFERENCE_C
        columns = torch.stack([torch.ones_like(theta), theta, theta**2, theta**3], dim=-1)
        return spread(columns, shape)
