"""Faraday effect of a magnetic field in a twisted fibre."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import REFERENCE_C, Effect, History, Parameter, spread


class Magnetic(Effect):
    """Error (m0 + m1·θ)·B with B the recorded field along the sensitive direction.

    Radial field and twist give 26.5 to 30.4 °/h per mT between −40 and 60 °C in a 1 km coil, 0.15 %/K.
    """

    name = "magnetic"
    runs_together = True
    needs = ("field_ut",)
    amplitudes = (
        Parameter("sensitivity", 0.0, "unit/µT", -1.0, 1.0, source="prior: 0.02–0.5 °/h/G medium (1 G = 100 µT)", meaning="m0 at 20 °C"),
        Parameter("slope", 0.0, "unit/µT/K", -0.01, 0.01, source="prior: 0.10–0.15 %/K of m0", meaning="m1"),
    )
    formula = "(m0 + m1·θ)·B"
    source = "engineering prior; see the class docstring"
    signature = "follows the field, whatever the temperature does; jumps with heaters and relays"
    confused_with = ("static_bias",)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """B [µT] and θ·B [K·µT], see `Effect.columns`; no shape."""
        field = history.inputs["field_ut"]
        columns = torch.stack(torch.broadcast_tensors(field, field * (history.temperature - REFERENCE_C)), dim=-1)
        return spread(columns, shape)
