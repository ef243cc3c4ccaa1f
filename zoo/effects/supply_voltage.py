"""Coupling of the supply voltage."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter, spread

NOMINAL_V = 5.0


class SupplyVoltage(Effect):
    """Error p·(V − 5 V) + q·(V − 5 V)²: loop gain, reset height and optical power follow the supply (prior: 0.001–0.02 °/h per per cent).

    Electronics that work within a few tenths of a volt of a limit bend.
    """

    name = "supply_voltage"
    runs_together = True
    place = "housing"
    needs = ("supply_v",)
    amplitudes = (
        Parameter("sensitivity", 0.0, "unit/V", -100.0, 100.0, source="0.001–0.02 °/h/%, prior", meaning="p, per volt"),
        Parameter("curvature", 0.0, "unit/V^2", -100.0, 100.0, source="prior: as large at a volt, at most", meaning="q, per volt squared"),
    )
    formula = "p·(V − 5 V) + q·(V − 5 V)²"
    source = "engineering prior"
    signature = "follows the supply, whatever the temperature does"
    confused_with = ()

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """V − 5 V and its square, see `Effect.columns`; no shape."""
        above = history.inputs["supply_v"] - NOMINAL_V
        return spread(torch.stack([above, above.square()], dim=-1), shape)
