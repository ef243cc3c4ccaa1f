"""Cuts a chamber run into what the chamber did: holds, ramps, and the edges between them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from torch import Tensor

Kind = Literal["hold", "heating", "cooling", "edge"]
KINDS: tuple[Kind, ...] = ("hold", "heating", "cooling", "edge")
HOLD, HEATING, COOLING, EDGE = 0, 1, -1, 2
_NAME: dict[int, Kind] = {HOLD: "hold", HEATING: "heating", COOLING: "cooling", EDGE: "edge"}

RATE_FLOOR = 0.05
"""A temperature that moves slower than this is held, whatever the run does elsewhere [K/min]."""
RATE_SHARE = 0.25
"""A hold is slower than this share of the run's usual ramp."""
NEGLIGIBLE_K = 0.2
"""A swing smaller than this is no ramp: it is what a thermometer's resolution and a chamber's control make of a hold [K]."""
WINDOW_SHARE, WINDOW_LOW_S, WINDOW_HIGH_S = 1 / 80, 60.0, 600.0


@dataclass(frozen=True)
class Stage:
    """Consecutive blocks from_index <= i < to_index in which the chamber did one thing.

    Attributes:
        from_index: first block.
        to_index: the block after the last.
        kind: ``"hold"``, ``"heating"``, ``"cooling"`` or ``"edge"`` (the transition between two of the others).
        from_s: centre of the first block [s].
        to_s: centre of the last block [s].
        temperature_c: temperature of the first and of the last block [°C].
    """

    from_index: int
    to_index: int
    kind: Kind
    from_s: float
    to_s: float
    temperature_c: tuple[float, float]

    @property
    def blocks(self) -> slice:
        """The stage's blocks, to index any block means with."""
        return slice(self.from_index, self.to_index)


def label_stages(time: Tensor, temperature: Tensor) -> list[Stage]:
    """Cut a run into stages.

    The rate is a straight line's slope over a window of 1/80 of the run (60 to 600 s, at least three blocks). A block is held where it is below
    0.05 K/min, below a quarter of the run's usual ramp, or within the thermometer's noise. A ramp slower than half of its own plateau, and what
    lies within half a window of any change, is an edge.

    Args:
        time: (N,) block centres, increasing [s].
        temperature: (N,) block means [°C].

    Returns:
        Stages in time order that cover every block exactly once; none for a run without blocks.
    """
    total = time.numel()
    if total == 0:
        return []
    time, temperature = time.detach().double().cpu(), temperature.detach().double().cpu()
    code = torch.zeros(total, dtype=torch.int64) if total < 3 else _codes(time, temperature)
    return [
        Stage(a, b, _NAME[int(code[a])], float(time[a]), float(time[b - 1]), (float(temperature[a]), float(temperature[b - 1])))
        for a, b in _pieces(code)
    ]


def stage_names(stages: list[Stage]) -> list[Kind]:
    """The kind of each of the N blocks."""
    return [stage.kind for stage in stages for _ in range(stage.from_index, stage.to_index)]


def stage_mask(stages: list[Stage], kind: Kind) -> Tensor:
    """(N,) bool, the blocks of one kind."""
    return torch.tensor([name == kind for name in stage_names(stages)], dtype=torch.bool)


def rms(error: Tensor) -> float:
    """Root mean square of (N,) values, in their unit; 0 where there are none."""
    return float(error.square().mean().sqrt()) if error.numel() else 0.0


def bias_stability(error: Tensor) -> float:
    """Bias stability: sample standard deviation of (N,) block means (qiu2023, eq. 5, with scale factor 1); 0 below two blocks."""
    return float(error.std()) if error.numel() > 1 else 0.0


def _fast(rate: Tensor) -> float:
    """What a quarter of the rates exceed, whatever their sign [K/min]; NumPy's, as torch's quantile takes no more than 2²⁴ values."""
    return float(np.quantile(rate.abs().cpu().numpy(), 0.75))


def _codes(time: Tensor, temperature: Tensor) -> Tensor:
    block_s = float(time.diff().median())
    window = max(min(max(float(time[-1] - time[0]) * WINDOW_SHARE, WINDOW_LOW_S), WINDOW_HIGH_S), 3 * block_s)
    rate = local_rate(time, temperature, window)
    usual = _fast(rate)
    limit = max(RATE_FLOOR, RATE_SHARE * usual, 4 * _rate_noise(temperature, block_s, window))
    code = torch.where(rate.abs() > limit, rate.sign(), torch.zeros_like(rate)).long()
    code = _without_glitches(code, time, temperature, max(window / 2, 2 * block_s))
    return _with_edges(code, time, rate, max(window / 2, 1.5 * block_s))


def local_rate(time: Tensor, temperature: Tensor, window: float) -> Tensor:
    """Slope of the straight line through all blocks within half a window of each.

    Args:
        time: (N,) [s].
        temperature: (N,) [K or °C].
        window: full width [s].

    Returns:
        (N,) [K/min]; 0 where a block is alone in its window.
    """
    first = torch.searchsorted(time, time - window / 2 - 1e-6)
    last = torch.searchsorted(time, time + window / 2 + 1e-6, right=True)
    t, u = time - time.mean(), temperature - temperature.mean()
    sums = torch.cat([torch.zeros(5, 1, dtype=t.dtype), torch.stack([torch.ones_like(t), t, u, t * t, t * u]).cumsum(-1)], dim=-1)
    count, st, su, stt, stu = sums[:, last] - sums[:, first]
    spread = stt - st * st / count
    slope = (stu - st * su / count) / spread
    return 60 * torch.where((count > 1) & (spread > 0), slope, torch.zeros_like(slope))


def _rate_noise(temperature: Tensor, block_s: float, window: float) -> float:
    """Standard deviation of the local rate that white noise of the thermometer makes [K/min]."""
    # Second differences take out the ramps; the median takes out their corners.
    noise = 1.4826 * float(temperature.diff(n=2).abs().median()) / 6**0.5
    count = max(window / block_s, 2.0)
    return 60 * noise / block_s * (12 / (count * (count**2 - 1))) ** 0.5


def _without_glitches(code: Tensor, time: Tensor, temperature: Tensor, shortest: float) -> Tensor:
    """Small swings become part of the hold; what is short and moves is left to the edges; a short rest between two ramps as well."""
    code = code.clone()
    for a, b in _pieces(code):
        if code[a] != HOLD and float(temperature[a:b].max() - temperature[a:b].min()) < NEGLIGIBLE_K:
            code[a:b] = HOLD
    result = code.clone()
    for a, b in _pieces(code):
        inner = a > 0 and b < len(code)
        if float(time[b - 1] - time[a]) < shortest and (code[a] != HOLD or inner):
            result[a:b] = EDGE
    return result


def _with_edges(code: Tensor, time: Tensor, rate: Tensor, reach: float) -> Tensor:
    """Marks slow ends of ramps, and what lies within `reach` [s] of a change, but never more than a quarter of a stage at each end."""
    result = code.clone()
    pieces = _pieces(code)
    for a, b in pieces:
        if int(code[a]) in {HEATING, COOLING}:
            result[a:b][rate[a:b].abs() < 0.5 * _fast(rate[a:b])] = EDGE
        width = min(reach, float(time[b - 1] - time[a]) / 4)
        if a > 0:
            result[a:b][time[a:b] - time[a] < width] = EDGE
        if b < len(code):
            result[a:b][time[b - 1] - time[a:b] < width] = EDGE
    return result


def _pieces(code: Tensor) -> list[tuple[int, int]]:
    """Half-open index ranges of equal code."""
    cuts = [0, *(torch.nonzero(code.diff()).flatten() + 1).tolist(), len(code)]
    return list(itertools.pairwise(cuts))
