"""Stress in potting and coating that relaxes within hours, faster when hot."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import History, Parameter, grid_values
from zoo.effects.earlier import ROOM_C, Continuing
from zoo.physics.relaxation import maxwell, shifted
from zoo.units import SECONDS_PER_HOUR, SECONDS_PER_MINUTE

FASTER = 6.0
"""Ratio of the two branches' times: a spectrum of a decade or two in two lines, of which either may be nothing."""


class Viscoelastic(Continuing):
    """Two Maxwell branches of a strain that follows the temperature, Σ G_i·s_i/τ_i(T), with ds_i/dt = dT/dt − s_i/τ_i(T).

    A polymer has a spectrum of times (a Prony series); the second branch is six times as fast as the first, at any temperature. Light in a winding
    whose strain changes sees the rate of stress, ds/dt = dT/dt − s/τ. Its first part is Mohr's column; the second alone is as good beside Mohr's
    effect and far better conditioned: where a branch hardly relaxes ds/dt is dT/dt, and s/τ a slow trace of its own. A fast one (τ → 0) is Mohr's
    column. What couples polarisations or bends an optical chip goes with the stress itself, G_i·s_i/τ_i(20 °C): at one temperature the two are one
    curve, over tens of kelvins they are not, for τ changes by decades.

    A run begins relaxed, or with what is left of the strain of the way to its start: of that from room temperature where p > 0, from where the run
    before ended where p < 0, 1/(1 + t/τ(T)) with the t after which |p| is left at 20 °C.
    """

    name = "viscoelastic"
    runs_together = True
    shape = (
        Parameter("time", 2.0, "h", 0.2, 10.0, "log", source="prior: 0.3–5 h", meaning="τ at 20 °C", grid=6),
        Parameter("shift", 3.0, "1/(100 K)", 0.0, 8.0, source="Trufanov, PMC12846046: a coating's tangent is 4 at 20 °C", meaning="k", grid=4),
        Parameter("of_stress", 0.0, "1", 0.0, 1.0, "index", "an option", "1: goes with the stress itself, 0: with its rate", usual=True),
        Parameter("past", 0.0, "1", -1.0, 1.0, "share", source="0 none", meaning="p, share of the way's strain left, negative: from the run before"),
    )
    amplitudes = (
        Parameter("coefficient", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: of the size of Mohr's C_M", meaning="G"),
        Parameter("fast", 0.0, "unit/(K/min)", -10.0, 10.0, source="prior: as the first", meaning="G of the branch six times as fast"),
    )
    formula = (
        "G·s/τ + G₂·s₂/τ₂ with τ(T), or τ20 of the stress itself,  ds/dt = dT/dt − s/τ(T),  τ(T) = τ20·10^(−k·(T − 20 °C)/100 K·293 K/T),  τ₂ = τ/6"
    )
    source = "Maxwell's branches (Prony series); Arrhenius; Ferry 1980, Viscoelastic Properties of Polymers, ch. 11"
    signature = "decays within hours in the hold after a ramp, faster when hot; opposite sign after cooling"
    confused_with = ("hysteresis", "moisture", "aging", "sensor_lag")

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """With the rate of stress and with the stress, see `Effect.shapes_to_try`."""
        del span_s
        time, shift, _, past = (grid_values(one, runs) for one in self.shape)
        return torch.cartesian_prod(time, shift, torch.tensor([0.0, 1.0], dtype=torch.float64), past)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """What relaxes in a minute in each branch [K/min], at its time or at that of 20 °C, see `Effect.columns`."""
        of_stress = shape[..., 2:3].round()
        faster = shifted(history.temperature, shape[..., 1:2])
        times = SECONDS_PER_HOUR * torch.stack([shape[..., 0:1], shape[..., 0:1] / FASTER], dim=-2)
        speed = faster.unsqueeze(-2) / times
        stress = maxwell(history.time, history.temperature.unsqueeze(-2), speed, self._left_over(history, shape[..., 3:4], faster))
        seen = torch.where(of_stress > 0, 1.0, faster).unsqueeze(-2)
        return (SECONDS_PER_MINUTE * seen / times * stress).movedim(-2, -1)

    def _left_over(self, history: History, past: Tensor, faster: Tensor) -> Tensor:
        """(..., 2) what is left of either branch's strain at a run's first sample [K].

        Args:
            history: see `columns`.
            past: (..., 1) p.
            faster: (..., T) how much faster than at 20 °C the stress relaxes.
        """
        first, share = history.temperature[..., 0:1], torch.where(past < 0, -past, past)
        came_from = torch.where(past < 0, self.earlier.turned(history.run, past)[..., -1:], first.clamp(*ROOM_C))
        relaxed = torch.cat([faster[..., 0:1], FASTER * faster[..., 0:1]], dim=-1)
        return (first - came_from) * share / (share + (1.0 - share) * relaxed)
