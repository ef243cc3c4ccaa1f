"""Polarisation non-reciprocity: interference fringes in temperature."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from zoo.effects.base import REFERENCE_C, Effect, History, Parameter, grid_values
from zoo.units import SECONDS_PER_MINUTE

RATIO = Parameter("ratio_2", 2.0, "1", 0.3, 4.0, source="periods of 3–30 K against each other", meaning="period over that of the second line")
LEAD_S, LEADS = 160.0, 8
LONGEST_K = 40.0
"""Longest period of any line: a wave longer than that, and moved by the rate, would be a function of the rate."""
HARMONICS = (2.0, 3.0)
APART = 0.05
"""Ratio less one below which a line is the first one: the difference of two would be a wave that grows with temperature, at huge amplitudes."""


class Polarization(Effect):
    """Fringes in temperature: a line of period P and two more of periods P/ρ, by default its harmonics.

    A cross-coupling at distance z from the polariser interferes with phase 2πB(T)z/λ, and dB/dT is constant to a few per cent, so that the error is
    periodic in T with P = λ/(z·|dB/dT|), about 2.8 K·m at 1550 nm (Opt. Lett. 36, 2173 (2011) for dB/dT), T where the splices are. Each
    splice adds a line of its own, one to four in all; an intensity-type term, or a coupling at twice the distance, a harmonic.
    """

    name = "polarization"
    runs_together = True
    sharp = True
    instant = True
    shape = (
        Parameter("period", 12.0, "K", 2.0, LONGEST_K, "inverse", source="prior: 3–30 K", meaning="fringe period in temperature", grid=100),
        RATIO,
        Parameter("ratio_3", 3.0, "1", 0.3, 4.0, source=RATIO.source, meaning="period over that of the third line"),
        Parameter(
            "lead", 0.0, "s", -240.0, 240.0, source="prior: leads and splices between the coil and the housing", meaning="of that place, to the coil"
        ),
    )
    amplitudes = (
        Parameter("cosine", 0.0, "unit", -10.0, 10.0, source="prior: 0.002–0.03 medium, 0.02–0.5 tactical", meaning="first line, in phase at 20 °C"),
        Parameter("sine", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning="first line, in quadrature"),
        Parameter("cosine_2", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning="second line, in phase"),
        Parameter("sine_2", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning="second line, in quadrature"),
        Parameter("cosine_3", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning="third line, in phase"),
        Parameter("sine_3", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning="third line, in quadrature"),
    )
    formula = "Σ_{i=1..3} A_i cos(2πρ_iθ/P) + B_i sin(2πρ_iθ/P),  ρ_1 = 1,  θ = T + lead·dT/dt − 20 °C"
    source = "Malykin & Pozdnyakova 2004, Opt. Spectrosc. 97:945; Opt. Lett. 36, 2173 (2011)"
    signature = "a wave in temperature (not in time), the same phase up and down, independent of the rate"
    confused_with = ()

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """Periods of one line alone, see `Effect.shapes_to_try`: all three at the same place."""
        periods = grid_values(self.shape[0], runs)
        one = torch.ones_like(periods)
        return torch.stack([periods, one, one, torch.zeros_like(periods)], dim=-1)

    def shapes_near(self, shape: Tensor, span_s: float) -> Tensor:
        """The best itself, and with its second, then its third line at every other period of the grid, or elsewhere, see `Effect.shapes_near`."""
        single = shape[1:3] == 1.0
        moved = [1] if bool(single.all()) else [2] if bool(single.any()) else [1, 2]
        leads = self._with(shape, 3, torch.linspace(-LEAD_S, LEAD_S, LEADS).to(shape))
        return torch.cat([shape.unsqueeze(0), leads, *(self._with(shape, place, self._ratios(shape[0], shape[3 - place])) for place in moved)])

    def _ratios(self, period: Tensor, taken: Tensor) -> Tensor:
        """(G,) ratios to the other periods of the grid and to the harmonics, apart from the line that is there already."""
        first, second, *_ = self.shape
        ratios = torch.cat([period / grid_values(first, 1).to(period), torch.tensor(HARMONICS).to(period)])
        apart = ((ratios - 1.0).abs() > APART) & ((ratios / taken - 1.0).abs() > APART)
        return ratios[(ratios >= second.low) & (ratios <= second.high) & apart]

    def _with(self, shape: Tensor, place: int, values: Tensor) -> Tensor:
        """(G, 4) the shape with other values at one place."""
        moved = shape.expand(len(values), -1).clone()
        moved[:, place] = values
        return moved

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Cosine and sine of each line, see `Effect.columns`."""
        return self._waves(history, shape, (1, 2))

    def distinct_columns(self, history: History, shape: Tensor, tried: Tensor) -> Tensor:
        """Without the lines that are always the first one, see `Effect.distinct_columns`."""
        return self._waves(history, shape, [place for place in (1, 2) if bool((tried[:, place] != 1.0).any())])

    def _waves(self, history: History, shape: Tensor, others: Sequence[int]) -> Tensor:
        """Cosine and sine of the first line and of others, by the places of their ratios in the shape."""
        here = history.temperature + shape[..., 3:4] / SECONDS_PER_MINUTE * history.rate
        period, phase = shape[..., 0:1], 2 * torch.pi * (here - REFERENCE_C)
        lines = [phase / period, *(phase * _other(shape[..., place : place + 1], period) / period for place in others)]
        return torch.stack([wave for line in lines for wave in (line.cos(), line.sin())], dim=-1)


def _other(ratio: Tensor, period: Tensor) -> Tensor:
    """The ratio of another line; 1 where that would be too close to the first or too long."""
    return torch.where(((ratio - 1.0).abs() > APART) & (period <= LONGEST_K * ratio), ratio, torch.ones_like(ratio))
