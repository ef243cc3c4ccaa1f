"""Stress in potting and coating that relaxes within hours, faster when hot."""

from __future__ import annotations

from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.relaxation import maxwell, shifted

SECONDS_PER_HOUR, SECONDS_PER_MINUTE = 3600.0, 60.0


class Viscoelastic(Effect):
    """Relaxation of one Maxwell branch, G·s/τ(T), of a strain that follows the temperature: ds/dt = dT/dt − s/τ(T), s = 0 at first.

    The bias goes with the rate of stress, ds/dt = dT/dt − s/τ. Its first part is Mohr's column; the second alone is as good beside Mohr's effect and
    far better conditioned: where a branch hardly relaxes ds/dt is dT/dt, and s/τ a slow trace of its own. A fast one (τ → 0) is Mohr's column.
    """

    name = "viscoelastic"
    shape = (
        Parameter("time", 2.0, "h", 0.2, 10.0, "log", source="prior: 0.3–5 h", meaning="τ at 20 °C", grid=6),
        Parameter("shift", 3.0, "1/(100 K)", 0.0, 8.0, source="Trufanov, PMC12846046: a coating's tangent is 4 at 20 °C", meaning="decades", grid=4),
    )
    amplitudes = (Parameter("coefficient", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: of the size of Mohr's C_M", meaning="G"),)
    formula = "G·s/τ(T),  ds/dt = dT/dt − s/τ(T),  τ(T) = τ20·10^(−k·θ/100 K),  θ = T − 20 °C"
    source = "Maxwell's branch; Williams, Landel & Ferry 1955, J. Am. Chem. Soc. 77:3701"
    signature = "decays within hours in the hold after a ramp, faster when hot; opposite sign after cooling"
    confused_with = ("hysteresis", "moisture", "aging", "sensor_lag")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """What relaxes in a minute [K/min], see `Effect.columns`."""
        speed = shifted(history.temperature, shape[..., 1:2]) / (SECONDS_PER_HOUR * shape[..., 0:1])
        return (SECONDS_PER_MINUTE * speed * maxwell(history.time, history.temperature, speed)).unsqueeze(-1)
