"""Polarisation non-reciprocity: interference fringes in temperature."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter

REFERENCE_C = 20.0


class Polarization(Effect):
    """Fringes in temperature with period P, and their second harmonic.

    A cross-coupling at distance z from the polariser interferes with phase 2πB(T)z/λ, and dB/dT is constant to a few per cent, so that the error is
    periodic in T with P = λ/(z·|dB/dT|), about 2.8 K·m at 1550 nm. Two couplings at a ratio of two, or an intensity-type term, add the harmonic
    (Opt. Lett. 36, 2173 (2011) for dB/dT).
    """

    name = "polarization"
    shape = (Parameter("period", 12.0, "K", 2.0, 60.0, "inverse", source="prior: 3–30 K", meaning="fringe period in temperature", grid=100),)
    amplitudes = (
        Parameter("cosine", 0.0, "unit", -10.0, 10.0, source="prior: 0.002–0.03 medium, 0.02–0.5 tactical", meaning="fundamental, in phase at 20 °C"),
        Parameter("sine", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning="fundamental, in quadrature"),
        Parameter("cosine_2", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning="second harmonic, in phase"),
        Parameter("sine_2", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning="second harmonic, in quadrature"),
    )
    formula = "Σ_{h=1,2} A_h cos(2πhθ/P) + B_h sin(2πhθ/P)"
    source = "Malykin & Pozdnyakova 2004, Opt. Spectrosc. 97:945; Opt. Lett. 36, 2173 (2011)"
    signature = "a wave in temperature (not in time), the same phase up and down, independent of the rate"
    confused_with = ()

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Cosine and sine of the fundamental and of its harmonic, see `Effect.columns`."""
        phase = 2 * torch.pi * (history.temperature - REFERENCE_C) / shape[..., 0:1]
        return torch.stack([phase.cos(), phase.sin(), (2 * phase).cos(), (2 * phase).sin()], dim=-1)
