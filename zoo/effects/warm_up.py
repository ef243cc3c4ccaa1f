"""Warm-up: what decays after power-on whatever the chamber does."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import REFERENCE_C, RUN, Effect, History, Parameter, grid_values
from zoo.physics.carry import at_start


class WarmUp(Effect):
    """Error (1 − κ·(T0 − 20 °C))·(A·exp(−t/τ) + A₁·exp(−n·t/τ)), in every run, in one, or in all but one.

    The time t counts from the run's first sample, taken as power-on, and T0 is the temperature then.

    The body heats up within tens of minutes, the source, the cooler and the electronics within minutes; their ratio hardly shows in a sum of
    exponentials, and is about known beforehand. What is kept at a temperature of its own has the farther to go the colder it begins. A gyro that was
    on before a run began is warm; one that was not fitted is taken to begin as most of those that were.
    """

    name = "warm_up"
    runs_together = True
    place = "housing"
    shape = (
        Parameter("time", 1200.0, "s", 60.0, 5400.0, "log", source="prior: the body 10–40 min", meaning="e-folding time"),
        Parameter(RUN, 0.0, "1", -100.0, 100.0, "index", "an index", "the one that began cold, negative: the one that did not", usual=True),
        Parameter("colder", 0.0, "1/K", -0.025, 0.025, source="engineering prior", meaning="κ, the larger from a colder start", within=0.008),
        Parameter(
            "ratio", 10.0, "1", 3.0, 40.0, "log", source="prior: 10–40 min over 1–3 min", meaning="n, how many times as fast as the body", within=1.8
        ),
    )
    amplitudes = (
        Parameter("amplitude", 0.0, "unit", -10.0, 10.0, source="prior: 0.02–0.3 medium, 0.3–3 tactical", meaning="the body's at power-on"),
        Parameter("early", 0.0, "unit", -10.0, 10.0, source="prior: as large at most", meaning="A₁, the electronics' at power-on"),
    )
    formula = "(1 − κ·(T0 − 20 °C))·(A·exp(−t/τ) + A₁·exp(−n·t/τ)), in every run, one, or all but one"
    source = "Kuznetsov et al. 2012, DOI 10.15588/1607-3274-2012-2-26"
    signature = "decays from the start of every run, or of those that began cold, at any temperature"
    confused_with = ("aging", "moisture")

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """In every run, in each alone, and in all but each, see `Effect.shapes_to_try`."""
        del span_s
        time, which, *_ = (grid_values(one, runs) for one in self.shape)
        alike, usual = (torch.tensor([one.default], dtype=torch.float64) for one in self.shape[2:])
        return torch.cartesian_prod(time, torch.cat([which, -which[1:]]) if runs > 2 else which, alike, usual)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """exp(−t/τ) and exp(−n·t/τ), each as large as the start makes it, see `Effect.columns`."""
        age, run = history.time / shape[..., 0:1], shape[..., 1:2].round()
        cold = torch.where(run > 0, run == history.run, run != -1.0 * history.run)
        size = cold * (1.0 - shape[..., 2:3] * (at_start(history.temperature).unsqueeze(-1) - REFERENCE_C))
        return torch.stack([size * torch.exp(-age), size * torch.exp(-shape[..., 3:4] * age)], dim=-1)
