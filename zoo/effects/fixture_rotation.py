"""A fixture that turns the gyro as it warms up."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.lag import lagged_rate

SECONDS_PER_MINUTE = 60.0


class FixtureRotation(Effect):
    """Real rotation k·dT_f/dt of plate, fixture or pier, T_f the housing's temperature behind a lag τ_f; the sign of the input axis, Ω ≥ 0, with it.

    A twist of 1″/K at 1 K/min is 1″/min, 0.0167 °/h. The gyro measures it rightly and the reference does not know it. On a fixture that stays where
    it is a flipped gyro sees the opposite, while a bias stays; with one attitude it looks like Mohr's effect.
    """

    name = "fixture_rotation"
    place = "housing"
    shape = (Parameter("lag", 600.0, "s", 60.0, 3600.0, "log", source="prior: minutes to an hour", meaning="τ_f behind the housing"),)
    amplitudes = (Parameter("twist", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: 0–1″/K, 0–0.017 °/h at 1 K/min", meaning="k"),)
    formula = "k·sign(Ω)·dT_f/dt,  T_f = lag_τf(T)"
    source = "Weinstock 1966, NASA TN D-3683"
    signature = "a plateau proportional to the rate, late by the fixture's lag, zero in a hold; changes sign when the input axis is flipped"
    confused_with = ("mohr", "thermal_gradient", "sensor_lag")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """The fixture's rate [K/min] in the axis' direction, see `Effect.columns`."""
        rate = SECONDS_PER_MINUTE * lagged_rate(history.time, history.temperature, shape[..., 0])
        return torch.where(history.reference >= 0, rate, -rate).unsqueeze(-1)
