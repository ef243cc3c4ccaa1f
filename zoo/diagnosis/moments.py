"""What happens at few moments: noise has normal steps, a switch, a door or a shock has not.

Flicker and random walk take over the variance of rare events, but not their distribution: whitened by the likeliest noise, these stand out.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench

SCALES = (1, 3, 10)
"""Blocks over which the whitened residual is summed: what lasts longer than a block stands out more."""
RARE = 5.0
"""Standard deviations of the excess kurtosis of normal numbers that chance may give at the best of these scales."""
STANDS_OUT = 4.0
"""Standard deviations from which a sum is one of the moments."""
LISTED = 4


def kurtosis(bench: Workbench, solved: Solved, blocks: int = 1) -> float:
    """Excess kurtosis of the whitened residual summed over so many blocks, in standard deviations of that of as many normal numbers, √(24/N)."""
    sums = torch.cat(_sums(bench, solved, blocks))
    if not len(sums):
        return 0.0
    excess = float(sums.pow(4).mean() / sums.square().mean() ** 2) - 3.0
    return excess / math.sqrt(24.0 * blocks / len(sums))


def rarity(bench: Workbench, solved: Solved) -> float:
    """How much of a residual happens at few moments, over what chance may make of noise: more than 1 is no noise."""
    return max(kurtosis(bench, solved, blocks) for blocks in SCALES) / RARE


def prominence(bench: Workbench, solved: Solved) -> float:
    """Share of a whitened residual's variance that lies in the moments which stand out, at the scale where that is most; in noise next to none."""
    shares = []
    for blocks in SCALES:
        sums = torch.cat(_sums(bench, solved, blocks))
        high = sums[sums.abs() > STANDS_OUT * sums.square().mean().sqrt()]
        shares.append(float(high.square().sum()) / max(float(sums.square().sum()), 1e-300))
    return max(shares)


def moments(bench: Workbench, solved: Solved) -> list[tuple[str, float]]:
    """Runs and hours at which a residual stands out, in order: the four most prominent, if there are as many."""
    found: list[tuple[float, str, float]] = []
    for blocks in SCALES:
        sums = _sums(bench, solved, blocks)
        level = float(torch.cat(sums).square().mean().sqrt())
        for run, part in zip(bench.runs, sums, strict=True):
            times = run.block_mean(run.time) - run.time[0]
            for place in _peaks(part.abs(), blocks):
                height = float(part[place].abs()) / level
                if height > STANDS_OUT:
                    found.append((height, run.name, float(times[place : place + blocks].mean()) / 3600.0))
    kept: list[tuple[str, float]] = []
    apart = SCALES[-1] * bench.runs[0].average_s / 3600.0
    for _, name, hours in sorted(found, reverse=True):
        if all(other != name or abs(hours - before) > apart for other, before in kept):
            kept.append((name, hours))
    return sorted(kept[:LISTED])


def _sums(bench: Workbench, solved: Solved, blocks: int) -> list[Tensor]:
    """Of each run, (N_r − blocks + 1,) sums over consecutive blocks of the residual whitened by its likeliest noise."""
    white = bench.mixtures.whitener(solved.likely.place)[1](solved.residual.unsqueeze(1)).squeeze(1)
    totals = [torch.nn.functional.pad(part.cumsum(0), (1, 0)) for part in white.split([run.blocks for run in bench.runs])]
    return [total[blocks:] - total[:-blocks] for total in totals]


def _peaks(size: Tensor, apart: int) -> list[int]:
    """Places of a (M,) tensor that are the largest within so many places either way."""
    if not len(size):
        return []
    around = torch.nn.functional.max_pool1d(size.view(1, 1, -1), 2 * apart + 1, 1, apart).view(-1)
    return torch.nonzero(size >= around).flatten().tolist()
