"""A bias that jumps."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import RUN, Effect, History, Parameter, grid_values
from zoo.physics.carry import after_first, left, resumed, with_last

ONSETS, FINER = 200, 21
ENDS, ENDS_S = 0.01, 300.0
"""Share of the longest run at either end in which no step is looked for, and how long that is at most [s]: what differs there alone is an outlier."""


class BiasStep(Effect):
    """A step at one moment: a fan that switches, a fibre that slips, a laser that hops. Each further one is an effect of its own in the model.

    The moment is counted from the run's start. `run` tells which run it happened in; 0 means at that time in every run, as for a programmed switch;
    −2 in run 2, and that it has stayed: the runs after it, in the order of their files, begin with it, and so does any that was not fitted.
    """

    name = "bias_step"
    runs_together = True
    again = True
    moments = ("onset",)
    place = "housing"
    shape = (
        Parameter("onset", 2.0, "h", 0.0, 24.0, source="anywhere in a run", meaning="time from the run's start"),
        Parameter(RUN, 0.0, "1", -100.0, 100.0, "index", "an index", "number of the run it happened in, negative where it stayed; 0 for all"),
    )
    amplitudes = (Parameter("step", 0.0, "unit", -100.0, 100.0, source="engineering prior", meaning="height"),)
    formula = "A·(t > t0), and from then on where the run's number is negative"
    source = "Mukhtubaev et al. 2020, ITMO J. 20(4):507 (phase jumps)"
    signature = "constant before and after one moment"
    confused_with = ("aging",)

    def seen_over(self, span_s: float) -> BiasStep:
        """Onsets with something of the longest run before and after them, see `Effect.seen_over`."""
        end = min(ENDS * span_s, ENDS_S) / 3600.0
        return self.bounded(0, end, span_s / 3600.0 - end)

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """Onsets all along the longest run (its first 24 h), in each run, for good in each but the last, and in all of them, see
        `Effect.shapes_to_try`."""
        onset = self.shape[0]
        onsets = onset.low + (torch.arange(ONSETS, dtype=torch.float64) + 0.5) / ONSETS * (min(span_s / 3600.0, onset.high) - onset.low)
        which = grid_values(self.shape[1], runs)
        return torch.cartesian_prod(onsets, torch.cat([which, -which[1 : min(runs, len(which))]]))

    def shapes_near(self, shape: Tensor, span_s: float) -> Tensor:
        """Onsets from the one tried before to the one tried after, see `Effect.shapes_near`."""
        between = torch.linspace(-1.0, 1.0, FINER, dtype=shape.dtype, device=shape.device) / ONSETS * min(span_s / 3600.0, self.shape[0].high)
        onsets = (shape[0] + between).clamp(self.shape[0].low, self.shape[0].high)
        return torch.stack([onsets, shape[1].expand(FINER)], dim=-1)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """0 before and 1 after the onset, rising within one sampling step so that the onset can be refined, see `Effect.columns`."""
        onset, run = shape[..., 0:1] * 3600.0, shape[..., 1:2].round()
        step_s = shortest_step(history.time)
        now = torch.zeros_like(run) + history.run  # a tensor whether it is a number or one for each of several runs
        here, after = (run == 0) | (run.abs() == now), (run < 0) & ((now > -run) | (now < 0))
        return torch.where(after, 1.0, ((history.time - onset) / step_s + 0.5).clamp(0.0, 1.0) * here).unsqueeze(-1)


def shortest_step(time: Tensor) -> Tensor:
    """(T,) the shortest sampling step so far [s], whatever gaps there are; next to nothing at the first sample."""
    steps = torch.diff(with_last(time))
    before = resumed(torch.full_like(time[0], torch.inf))
    return after_first(torch.full_like(time[0], 1e-9), left(torch.minimum(steps.cummin(-1).values, before), before))
