"""A fixture that turns the gyro as it warms up."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.lag import lagged_rate
from zoo.units import SECONDS_PER_MINUTE


class FixtureRotation(Effect):
    """Real rotation k·dT_f/dt of plate, fixture or pier, in the direction of the input axis, Ω ≥ 0.

    The fixture's temperature is that of the air behind a lag τ_f, and the air is ahead of the housing's thermometer by the housing's lag τ_h:
    T_f = lag_τf(T + τ_h·dT/dt) = (1 − τ_h/τ_f)·lag_τf(T) + (τ_h/τ_f)·T. What is ahead of the thermometer is an amplitude of its own.
    A twist of 1″/K at 1 K/min is 1″/min, 0.0167 °/h. The gyro measures it rightly and the reference does not know it. On a fixture that stays where
    it is a flipped gyro sees the opposite, while a bias stays; with one attitude it looks like Mohr's effect.
    """

    name = "fixture_rotation"
    filters = True
    runs_together = True
    place = "housing"
    shape = (Parameter("lag", 600.0, "s", 60.0, 3600.0, "log", source="prior: minutes to an hour", meaning="τ_f behind the housing"),)
    amplitudes = (
        Parameter("twist", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: 0–1″/K, 0–0.017 °/h at 1 K/min", meaning="k·(1 − τ_h/τ_f)"),
        Parameter("ahead", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: as the twist's", meaning="k·τ_h/τ_f"),
    )
    formula = "k·sign(Ω)·dT_f/dt,  T_f = lag_τf(T + τ_h·dT/dt)"
    source = "Weinstock 1966, NASA TN D-3683"
    signature = "a plateau proportional to the rate, late by the fixture's lag, zero in a hold; changes sign when the input axis is flipped"
    confused_with = ("mohr", "thermal_gradient", "sensor_lag")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Rates behind the lag and of the housing itself [K/min] in the axis' direction, see `Effect.columns`."""
        late = SECONDS_PER_MINUTE * lagged_rate(history.time, history.temperature, shape[..., 0])
        rates = torch.stack(torch.broadcast_tensors(late, history.rate), dim=-1)
        return torch.where((history.reference >= 0).unsqueeze(-1), rates, -rates)
