"""Shupe's effect: transient gradients across the winding."""

from __future__ import annotations

from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.lag import behind


class Shupe(Effect):
    """Pure thermo-optic error of a coil whose layers do not change temperature at the same rate.

    The rate error is C_w·d(ΔT)/dt with ΔT the temperature difference across the winding. Across a winding with diffusion time τ the difference
    relaxes as ΔT ≈ τ·lag_τ(dT/dt), so the column is dT/dt − lag_τ(dT/dt): zero for any uniform rate and with zero integral between two isothermal
    states, as ∫(L − 2s) ds = 0 demands (Shupe 1980, Appl. Opt. 19:654).
    """

    name = "shupe"
    runs_together = True
    shape = (
        Parameter("diffusion_time", 60.0, "s", 5.0, 1200.0, "log", source="prior: d²/(π²a), 30 s to 470 s", meaning="diffusion across the winding"),
    )
    amplitudes = (
        Parameter("weight", 0.0, "unit/(K/min)", -100.0, 100.0, source="prior: 0.1 (quadrupolar) to 38 (cylindrical)", meaning="C_w of the winding"),
    )
    formula = "C_w·(dT/dt − lag_τ(dT/dt))"
    source = "Shupe 1980, Appl. Opt. 19:654; Opt. Express 21, 2521 (2013)"
    signature = "a pair of opposite spikes at the start and end of a ramp, nothing in mid-ramp or hold"
    confused_with = ("sensor_lag",)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """The rate less its lagged self [K/min], see `Effect.columns`."""
        return behind(history.time, history.rate, shape[..., 0]).unsqueeze(-1)
