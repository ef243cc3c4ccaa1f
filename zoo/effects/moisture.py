"""A winding that dries or swells, faster when hot."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import History, Parameter, grid_values
from zoo.effects.earlier import GOES_ON, Continuing, anew_or_on, beside
from zoo.physics.relaxation import arrhenius, elapsed
from zoo.units import SECONDS_PER_HOUR

JOULES_PER_KILOJOULE = 1000.0
MODES = 4
"""Of the whole of Fick's diffusion; the fifth would be 81 times as fast as the slowest, over within minutes."""


class Moisture(Continuing):
    """Error (a + f·τ20/τ(T))·w(u), u = ∫dt/τ(T): the water that is too much strains the winding, and its flux does as a rate of strain does.

    Fick's diffusion into surroundings that do not change: its slowest mode, w = e^(−u), or all those of a plate, w = Σ e^(−n²u) over odd n, as its
    gradient at the surface is, steep at first. Each run starts as far from them as the others, or where the one before has left it
    (`zoo.effects.earlier`). Diffusion is thermally activated, τ(T) = τ20·exp(E/R·(1/T − 1/T20)), so that a first heating dries the coil and the
    second finds it dry.
    """

    name = "moisture"
    runs_together = True
    shape = (
        Parameter("time", 15.0, "h", 3.0, 50.0, "log", source="prior: 3–50 h", meaning="τ20 at 20 °C", grid=6),
        Parameter("energy", 45.0, "kJ/mol", 20.0, 90.0, source="prior: 30–60 kJ/mol, water in epoxies and acrylates", meaning="E", grid=4),
        GOES_ON,
        Parameter("modes", 0.0, "1", 0.0, 1.0, "index", "an option", "1: all modes of diffusion, 0: the slowest", usual=True),
    )
    amplitudes = (
        Parameter("strain", 0.0, "unit", -10.0, 10.0, source="prior: up to 0.1 medium, 0.3 tactical", meaning="a, the slowest mode at the start"),
        Parameter("flux", 0.0, "unit", -10.0, 10.0, source="prior: up to 0.1 medium, 0.3 tactical", meaning="f, at the start and 20 °C"),
    )
    formula = "(a + f·τ20/τ(T))·w(u),  w = e^(−u) or Σ e^(−n²u) over odd n,  u = ∫dt/τ(T),  τ(T) = τ20·exp(E/R·(1/T − 1/T20))"
    source = "Moisture-induced mechanical strain in gyroscope optical fiber coil (strain measured along the fibre); Fick, Arrhenius"
    signature = "decays over hours to days from the start of every run, or of the first, faster when hot; a second heating differs from the first"
    confused_with = ("aging", "warm_up", "viscoelastic")

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """Each anew in every run and going on, and with one mode and all: these are alike where the slowest takes two or three times as long, see
        `Effect.shapes_to_try`."""
        del span_s
        time, energy, *_ = (grid_values(one, runs) for one in self.shape)
        return torch.cartesian_prod(time, energy, anew_or_on(runs), torch.arange(2.0, dtype=torch.float64))

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Water left, and its flux over that at 20 °C, both of those at the start, see `Effect.columns`."""
        tau_s, energy, goes_on = SECONDS_PER_HOUR * shape[..., 0:1], JOULES_PER_KILOJOULE * shape[..., 1:2], shape[..., 2:3].round()
        faster = arrhenius(history.temperature, energy)
        dwell = self.earlier.dwelt(torch.zeros_like(tau_s) + history.run).squeeze(-2)
        before = (dwell * arrhenius(beside(energy, self.earlier.celsius), energy)).sum(-1, keepdim=True)
        left = diffusing((elapsed(history.time, faster) + goes_on * before) / tau_s, shape[..., 3:4].round())
        return torch.stack([left, faster * left], dim=-1)


def diffusing(age: Tensor, higher: Tensor) -> Tensor:
    """Gradient at the surface of a plate out of which something diffuses, Σ e^(−n²u) over odd n, or its first term.

    Crank 1975, The Mathematics of Diffusion, §4.3. As n² − 1 = 8·(1 + 2 + … + m) with n = 2m + 1, it is a nested product of powers of e^(−8u).

    Args:
        age: (..., T) u, in times of the slowest mode.
        higher: (..., 1) 1 with all modes, 0 with the slowest alone.

    Returns:
        (..., T).
    """
    slowest = torch.exp(-age)
    ratio = higher * slowest**8
    terms = 1.0 + ratio ** (MODES - 1)
    for m in range(MODES - 2, 0, -1):
        terms = 1.0 + ratio**m * terms
    return slowest * terms
