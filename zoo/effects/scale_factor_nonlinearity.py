"""A scale factor that is another one at another rate."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import REFERENCE_C, Effect, History, Parameter, spread
from zoo.effects.scale_factor import PPM, ScaleFactor


class ScaleFactorNonlinearity(Effect):
    """Error c2·Ω² + (c3 + c4·θ)·Ω³ + c1·Ω with Ω the true input and θ = T − 20 °C where the source and the electronics are.

    An open loop answers V0·sin(S·Ω) with the Sagnac gain S = 2πLD/(λc). Calibrated with V0·S = 1 its error is −S²/6·Ω³ + S⁴/120·Ω⁵ − …, of which the
    cubic leaves S²Ω²/20: 3 % at 45° of phase. Where a kelvin changes V0 by a share v and S by a share s, the slope of the scale factor is v + s, and
    c4 = (v + 3s)·c3. A closed loop leaves tens of ppm from the ramp's resets and the loop's gain.

    A scale factor is the line that fits best over a range, and what curves lies to both sides of it: c1, of −c3 times 3/5 of the square of that range
    where all of it was as often, belongs to this effect, unless a scale factor of its own is in the model.
    """

    name = "scale_factor_nonlinearity"
    runs_together = True
    place = "housing"
    needs_varied_reference = True
    amplitudes = (
        Parameter("quadratic", 0.0, "ppm/(unit)", -1e6, 1e6, source="engineering prior: any unit of the output", meaning="c2, even in the input"),
        Parameter("cubic", 0.0, "ppm/(unit)^2", -1e6, 1e6, source="S²/6, S 0.13–1.2 s: 0.9–76 with °/s, 3e3–2.5e5 with rad/s", meaning="c3 at 20 °C"),
        Parameter("cubic_slope", 0.0, "ppm/(unit)^2/K", -1e4, 1e4, source="prior: up to 0.2 %/K of c3", meaning="c4"),
        Parameter("line", 0.0, "ppm", -1e6, 1e6, source="−c3·Ω² at the input where the fitted line is right", meaning="c1", spare=ScaleFactor.name),
    )
    formula = "c2·Ω² + (c3 + c4·θ)·Ω³ + c1·Ω,  θ = T − 20 °C"
    source = "IEEE Std 952 f(I); Lefèvre, The Fiber-Optic Gyroscope: V0·sin(S·Ω)"
    signature = "the square and the cube of the true input, beside a line where that was fitted, at any temperature; nothing at rest"
    confused_with = ("scale_factor",)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Ω², Ω³, θ·Ω³ and Ω in millionths, see `Effect.columns`; no shape."""
        rate, theta = history.reference, history.temperature - REFERENCE_C
        line = 0.0 * rate if "line" in self.left_out else rate
        powers = torch.broadcast_tensors(rate**2, rate**3, theta * rate**3, line)
        return spread(PPM * torch.stack(powers, dim=-1), shape)
