"""A bias that stands as long as a temperature difference stands."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter, spread


class ThermalGradient(Effect):
    """Error b_g·ΔT + b_i·ΔT_i: strain and birefringence of a winding that is warmer on one side.

    ΔT is what two thermometers measure, the one on the housing less the main one, and ΔT_i the main one less the estimated coil: together the
    difference between any two of housing, spool and winding. With one thermometer both are ΔT_i, which for a coil of one time constant is τ·dT/dt,
    Mohr's column: only a second thermometer or heat from inside tells the two apart.
    """

    name = "thermal_gradient"
    filters = True
    runs_together = True
    amplitudes = (
        Parameter("coefficient", 0.0, "unit/K", -10.0, 10.0, source="prior: Mohr's plateau at 2–3 K for 1 K/min", meaning="b_g, outside less main"),
        Parameter("inner", 0.0, "unit/K", -10.0, 10.0, source="engineering prior", meaning="b_i, main thermometer less coil"),
    )
    formula = "b_g·ΔT + b_i·ΔT_i"
    source = "US 5,416,585 (Turner): compensation with the difference between housing and spool"
    signature = "a plateau proportional to the rate, dying with the difference after the ramp; a constant where the gyro heats itself"
    confused_with = ("mohr", "sensor_lag", "fixture_rotation")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Both differences [K], see `Effect.columns`; no shape."""
        differences = torch.broadcast_tensors(history.gradient, history.thermometer - history.temperature)
        return spread(torch.stack(differences, dim=-1), shape)
