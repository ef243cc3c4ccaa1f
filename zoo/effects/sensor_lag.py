"""A static bias that follows another temperature than the coil's."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.lag import lagged


REFERENCE_C = 20.0


class SensorLag(Effect):
    """The part of b(T) that lives where the thermometer is, or lags it, instead of in the coil.

    Electronics and integrated optics sit elsewhere than the winding; a static bias of theirs, fitted at the coil, leaves b'·(T' − T) with T' the
    thermometer's temperature behind a lag τ. To first order that is b'·δτ·dT/dt, Mohr's column (physics.md §5).
    """

    name = "sensor_lag"
    place = "coil"
    shape = (Parameter("lag", 300.0, "s", 5.0, 7200.0, "log", source="§5: 10–120 s in contact, to 40 min through the structure", meaning="of the place behind the thermometer"),)
    amplitudes = (
        Parameter("slope", 0.0, "unit/K", -10.0, 10.0, source="§10.5 b_T", meaning="b' of what lives there"),
        Parameter("curvature", 0.0, "unit/K^2", -1.0, 1.0, source="§10.5", meaning="½ b'' of what lives there"),
    )
    formula = "b1·(θ' − θ) + b2·(θ'² − θ²),  θ' = lag_τ(thermometer) − 20 °C"
    source = "openbooks.itmo.ru 20873 (synchronising sensor and fibre); physics.md §5"
    signature = "a plateau proportional to the rate, dying with the lag after the ramp, zero in a hold"
    confused_with = ("mohr", "shupe", "thermal_gradient")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """θ' − θ [K] and θ'² − θ² [K²], see `Effect.columns`."""
        there = lagged(history.time, history.thermometer, shape[..., 0]) - REFERENCE_C
        here = history.temperature - REFERENCE_C
        return torch.stack(torch.broadcast_tensors(there - here, there**2 - here**2), dim=-1)
