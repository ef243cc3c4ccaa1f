"""Mohr's effect: a bias proportional to the rate of the coil's mean temperature."""

from __future__ import annotations

from torch import Tensor

from zoo.effects.base import Effect, History, Parameter, spread


class Mohr(Effect):
    """Elasto-optic bias C_M·dT/dt of a coil whose thermo-optic coefficient is not the same along the fibre.

    C_M = n/(D L) ∫ n_T(s)·(L − 2s) ds: the potting strains inner and outer layers differently, so that a uniform rate no longer
    cancels (Mohr 1996 JLT; Mohr & Schadt 2004 SPIE 5502:410).
    """

    name = "mohr"
    runs_together = True
    amplitudes = (Parameter("coefficient", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: 0.02–0.3 medium, 0.1–2 tactical", meaning="C_M"),)
    formula = "C_M·dT/dt"
    source = "Mohr 1996, J. Lightwave Technol."
    signature = "plateau in mid-ramp, proportional to the rate, sign flips between heating and cooling, zero in a hold"
    confused_with = ("thermal_gradient", "sensor_lag", "fixture_rotation")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """The coil's rate [K/min], see `Effect.columns`; no shape."""
        column = history.rate.unsqueeze(-1)
        return spread(column, shape)
