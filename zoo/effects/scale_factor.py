"""A scale factor that is off, and off by another amount at another temperature."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import REFERENCE_C, Effect, History, Parameter, spread

PPM = 1e-6


class ScaleFactor(Effect):
    """Error (e0 + e1·θ + e2·θ²)·Ω with Ω the true input and θ = T − 20 °C where the source and the electronics are.

    The Sagnac scale factor goes with L·D/λ, so that e1 is the coil's expansion less the source's drift of wavelength; in an open loop the optical
    power and the detector's gain are added, in a closed one without a second loop the modulator's V_π.
    Beside a true input that never changes this is a polynomial in temperature, which a static bias is as well.
    """

    name = "scale_factor"
    runs_together = True
    place = "housing"
    needs_varied_reference = True
    amplitudes = (
        Parameter("offset", 0.0, "ppm", -1e6, 1e6, source="engineering prior: up to an output without a calibration", meaning="e0 at 20 °C"),
        Parameter("slope", 0.0, "ppm/K", -5e3, 5e3, source="1–10 ASE, 10–50 SLD cooled, 250–450 SLD, 400–520 open loop, prior", meaning="e1"),
        Parameter("curvature", 0.0, "ppm/K^2", -100.0, 100.0, source="prior: 30 % of the slope's share", meaning="e2"),
    )
    formula = "(e0 + e1·θ + e2·θ²)·Ω,  θ = T − 20 °C"
    source = "IEEE Std 952 ε_T; Lefèvre, The Fiber-Optic Gyroscope: S = 2πLD/(λc)"
    signature = "proportional to the true input, with a share that follows the temperature; nothing at rest"
    confused_with = ("static_bias", "sensor_lag", "misalignment")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Ω, θ·Ω and θ²·Ω in millionths, see `Effect.columns`; no shape."""
        theta = history.temperature - REFERENCE_C
        columns = torch.stack([torch.ones_like(theta), theta, theta**2], dim=-1) * (PPM * history.reference).unsqueeze(-1)
        return spread(columns, shape)
