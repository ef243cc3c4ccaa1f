"""A static bias that follows another temperature than the coil's."""

from __future__ import annotations

from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.lag import lagged


class SensorLag(Effect):
    """The part of b(T) that lives where the thermometer is, or lags it, instead of in the coil.

    Electronics and integrated optics sit elsewhere than the winding; a static bias of theirs, fitted at the coil, leaves b'·(T' − T) with T' the
    thermometer's temperature behind a lag τ. To first order that is b'·δτ·dT/dt, Mohr's column.
    """

    name = "sensor_lag"
    filters = True
    runs_together = True
    place = "coil"
    shape = (
        Parameter(
            "lag",
            300.0,
            "s",
            5.0,
            7200.0,
            "log",
            source="prior: 10–120 s in contact, to 40 min through the structure",
            meaning="of the place behind the thermometer",
        ),
    )
    amplitudes = (Parameter("slope", 0.0, "unit/K", -10.0, 10.0, source="engineering prior", meaning="b' of what lives there"),)
    formula = "b'·(lag_τ(thermometer) − T)"
    source = "openbooks.itmo.ru 20873 (synchronising sensor and fibre)"
    signature = "a plateau proportional to the rate, dying with the lag after the ramp, zero in a hold"
    confused_with = ("mohr", "shupe", "thermal_gradient")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Temperature there less temperature here [K], see `Effect.columns`."""
        return (lagged(history.time, history.thermometer, shape[..., 0]) - history.temperature).unsqueeze(-1)
