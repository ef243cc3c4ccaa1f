"""Coupling of the supply voltage."""

from __future__ import annotations

from torch import Tensor

from zoo.effects.base import Effect, History, Parameter, spread

NOMINAL_V = 5.0


class SupplyVoltage(Effect):
    """Error p·(V − 5 V): loop gain, reset height and optical power follow the supply (prior: 0.001–0.02 °/h per per cent)."""

    name = "supply_voltage"
    runs_together = True
    place = "housing"
    needs = ("supply_v",)
    amplitudes = (Parameter("sensitivity", 0.0, "unit/V", -100.0, 100.0, source="0.001–0.02 °/h/%, prior", meaning="per volt"),)
    formula = "p·(V − 5 V)"
    source = "engineering prior"
    signature = "follows the supply, whatever the temperature does"
    confused_with = ()

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """V − 5 V, see `Effect.columns`; no shape."""
        column = (history.inputs["supply_v"] - NOMINAL_V).unsqueeze(-1)
        return spread(column, shape)
