"""A potting that turns from glass to rubber within the operating range."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter


class GlassTransition(Effect):
    """Error (c·σ(z) + d·sech²(z/q))·dT/dt with z = (T − T_g)/w and σ the logistic function.

    Stiffness and expansion of the potting change at T_g, and with them Mohr's coefficient from C_M to C_M + c; within the transition the volume
    that the glass held back is given free, a bell-shaped spike. Far from T_g nothing is left but Mohr's column, or none.
    """

    name = "glass_transition"
    instant = True
    runs_together = True
    shape = (
        Parameter("transition", 10.0, "°C", -60.0, 80.0, source="pottings: silicones below, epoxies and acrylates within", meaning="T_g", grid=12),
        Parameter("width", 8.0, "K", 3.0, 20.0, "log", source="prior: 5–15 K", meaning="w of the transition", grid=3),
        Parameter(
            "spike", 1.0, "1", 0.4, 3.0, "log", source="engineering prior", meaning="q, width of the spike over that of the transition", grid=1
        ),
    )
    amplitudes = (
        Parameter("jump", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: C_M once to three times itself", meaning="c, from below T_g to above"),
        Parameter("peak", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: of the jump's size", meaning="d, within the transition"),
    )
    formula = "(c·σ(z) + d·sech²(z/q))·dT/dt,  z = (T − T_g)/w"
    source = "US 5,546,482 (Cordova & Surabian): spikes and crossings of the bias at the potting's transition"
    signature = "a plateau in ramps that changes at one temperature, with a spike there; opposite sign while cooling, zero in a hold"
    confused_with = ("rate_temperature_coupling", "mohr", "viscoelastic")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """σ·dT/dt and sech²·dT/dt [K/min], see `Effect.columns`."""
        place = (history.temperature - shape[..., 0:1]) / shape[..., 1:2]
        spike = 1.0 - (place / shape[..., 2:3]).tanh().square()
        return torch.stack([place.sigmoid(), spike], dim=-1) * history.rate.unsqueeze(-1)
