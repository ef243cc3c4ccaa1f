"""An input axis that is not quite where it should be."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import REFERENCE_C, Effect, History, Parameter, spread


class Misalignment(Effect):
    """Error sign(Ω)·(m0 + m1·θ + m2·θ²) with Ω the true input and θ = T − 20 °C of the mount.

    A tilt δ(T) of the axis takes in Ω_h·δ of the horizontal Earth rate (11.5 °/h at 40° of latitude; 100 µrad are 0.001 °/h). Flipping the input axis
    flips it, as it does not a bias; how fast the gyro turns makes no difference, as it would to a scale factor.
    """

    name = "misalignment"
    runs_together = True
    place = "housing"
    needs_varied_reference = True
    amplitudes = (
        Parameter("offset", 0.0, "unit", -100.0, 100.0, source="engineering prior: 1′ of 11.5 °/h is 0.0034 °/h", meaning="m0 at 20 °C"),
        Parameter("slope", 0.0, "unit/K", -1.0, 1.0, source="prior: 0.5–5 µrad/K medium, 2–20 tactical", meaning="m1"),
        Parameter("curvature", 0.0, "unit/K^2", -0.1, 0.1, source="prior: 30 % of the slope's share", meaning="m2"),
    )
    formula = "sign(Ω)·(m0 + m1·θ + m2·θ²),  θ = T − 20 °C"
    source = "IEEE Std 952 ω_XRA·sin Θ; Ji et al. 2010 (polynomial in T)"
    signature = "follows the temperature as a bias does, and changes sign when the input axis is flipped"
    confused_with = ("scale_factor", "static_bias", "fixture_rotation")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Powers 0 to 2 of θ times the input's sign, see `Effect.columns`; no shape."""
        theta = history.temperature - REFERENCE_C
        columns = torch.stack([torch.ones_like(theta), theta, theta**2], dim=-1) * history.reference.sign().unsqueeze(-1)
        return spread(columns, shape)
