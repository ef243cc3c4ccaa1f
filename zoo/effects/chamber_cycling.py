"""The chamber's compressor, as a line in time."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter, physical_value

RUNS = 4
LONGEST_SPAN_S = 86400.0
FINER = 8
OVERTONES = 3
RECURS, SHORTEST = 4, 2.0
"""Periods that the longest run must hold of a line: what comes once or twice may as well be a drift, and goes on as it likes where nothing was
fitted. And how many of the shortest periods are looked for in any case."""


class ChamberCycling(Effect):
    """A line of period P in time, with a cosine and a sine of its own in each of the first four runs.

    A compressor that is switched on and off lets the air swing by 0.2 to 1 K, too fast for a thermometer in the gyro to show what the winding's outer
    layers feel. Its phase is the chamber's, not the program's: nobody knows it for a run that was not fitted, nor for a fifth one, where nothing is
    predicted. Block means over a time b cannot tell a period below 2b from its image, 1/(1/b − 1/P).
    """

    name = "chamber_cycling"
    place = "housing"
    instant = True
    shape = (Parameter("period", 300.0, "s", 120.0, 3600.0, "inverse", source="prior: compressors 2–10 min, slow control 1 h", meaning="P"),)
    amplitudes = tuple(
        Parameter(f"{wave}_{run}", 0.0, "unit", -10.0, 10.0, source="engineering prior", meaning=f"{wave} in run {run}")
        for run in range(1, RUNS + 1)
        for wave in ("cosine", "sine")
    )
    formula = "A_run·cos(2πt/P) + B_run·sin(2πt/P)"
    source = "engineering prior: air of chambers swings by ±0.2–1 K in 2–10 min"
    signature = "a narrow line in time, whatever the temperature does, with another phase in each run"
    confused_with = ()

    def seen_over(self, span_s: float) -> ChamberCycling:
        """Periods that recur, see `Effect.seen_over`."""
        low = self.shape[0].low
        return self.bounded(0, low, max(span_s / RECURS, SHORTEST * low))

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """Frequencies one resolution apart, 1/span (of a day at most), see `Effect.shapes_to_try`.

        A line midway between two of them shows two fifths of its power, which is above all noise for any line that is worth its nine parameters.
        """
        period = self.shape[0]
        count = math.ceil(min(span_s, LONGEST_SPAN_S) * (1 / period.low - 1 / period.high))
        return physical_value((torch.arange(count, dtype=torch.float64) + 0.5) / count, period).unsqueeze(-1)

    def shapes_near(self, shape: Tensor, span_s: float) -> Tensor:
        """Frequencies from the one tried before to the one tried after, see `Effect.shapes_near`."""
        between = torch.linspace(-1.0, 1.0, 2 * FINER + 1, dtype=shape.dtype, device=shape.device) / min(span_s, LONGEST_SPAN_S)
        return (1.0 / (1.0 / shape + between)).clamp(self.shape[0].low, self.shape[0].high).unsqueeze(-1)

    def frequencies(self, shape: Tensor) -> tuple[float, ...]:
        """The line's and its first overtones', see `Effect.frequencies`: a compressor that is switched on and off is no sine."""
        return tuple(order / float(shape[0]) for order in range(1, OVERTONES + 1))

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Cosine and sine in the run's own two columns, zero in the others', see `Effect.columns`."""
        period, run = shape[..., 0], int(history.run)
        phase = 2 * torch.pi * history.time.reshape(-1, *[1] * period.dim()) / period  # time first, as block means go through it
        own = torch.stack([phase.cos(), phase.sin()], dim=-1)
        before = run - 1 if 1 <= run <= RUNS else RUNS  # beyond the last, where the padding cuts them off again
        columns = torch.nn.functional.pad(own, (2 * before, 2 * (RUNS - 1 - before)))
        return columns.movedim(0, -2)
