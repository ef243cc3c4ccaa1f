"""A winding that dries or swells, faster when hot."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.relaxation import arrhenius, elapsed

SECONDS_PER_HOUR, JOULES_PER_KILOJOULE = 3600.0, 1000.0
HIGHER = (3, 5, 7, 9, 11)
"""Modes of diffusion through a layer beside the slowest; those beyond are gone within a five-hundredth of its time."""


class Moisture(Effect):
    """Error Σ_n (a/n² + f·τ20/τ(T))·e^(−n²u), u = ∫dt/τ(T): the water that is too much strains the winding, its flux does as a rate of strain does.

    Fick's diffusion into surroundings that do not change; each run starts as far from them as the others. The slowest mode, n = 1, is all that is
    left of a change long ago; where the surroundings changed as the run began, a share of 1 of the odd ones above it is there as well (Crank 1975,
    The Mathematics of Diffusion, 4.3). Diffusion is thermally activated, τ(T) = τ20·exp(E/R·(1/T − 1/T20)), so that a first heating dries the coil
    and the second finds it dry.
    """

    name = "moisture"
    runs_together = True
    shape = (
        Parameter("time", 15.0, "h", 3.0, 50.0, "log", source="prior: 3–50 h", meaning="τ20 at 20 °C", grid=6),
        Parameter("energy", 45.0, "kJ/mol", 20.0, 90.0, source="prior: 30–60 kJ/mol, water in epoxies and acrylates", meaning="E", grid=4),
        Parameter("sudden", 0.0, "1", 0.0, 1.0, "share", source="0 long ago, 1 at the start", meaning="share of the higher modes"),
    )
    amplitudes = (
        Parameter("strain", 0.0, "unit", -10.0, 10.0, source="prior: up to 0.1 medium, 0.3 tactical", meaning="a, at the start, of the slowest mode"),
        Parameter("flux", 0.0, "unit", -10.0, 10.0, source="prior: up to 0.1 medium, 0.3 tactical", meaning="f, the same at 20 °C"),
    )
    formula = "Σ_n s_n·(a/n² + f·τ20/τ(T))·e^(−n²u),  s_1 = 1,  s_3,5… = s,  u = ∫dt/τ(T),  τ(T) = τ20·exp(E/R·(1/T − 1/T20))"
    source = "Moisture-induced mechanical strain in gyroscope optical fiber coil (strain measured along the fibre); Fick, Arrhenius"
    signature = "decays over hours to days from the start of every run, faster when hot; a second heating differs from the first"
    confused_with = ("aging", "warm_up", "viscoelastic")

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Water left, and its flux over that at 20 °C, both of those at the start, see `Effect.columns`."""
        faster = arrhenius(history.temperature, JOULES_PER_KILOJOULE * shape[..., 1:2])
        passed = elapsed(history.time, faster) / (SECONDS_PER_HOUR * shape[..., 0:1])
        left = flux = torch.exp(-passed)
        for mode in HIGHER:
            more = shape[..., 2:3] * torch.exp(-(mode**2) * passed)
            left, flux = left + more / mode**2, flux + more
        return torch.stack([left, faster * flux], dim=-1)
