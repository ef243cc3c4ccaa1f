"""What swings in a band of frequencies: a line that moves, which neither a noise mixture nor a single frequency accounts for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench

WIDEST = 4
"""Part of the spectrum, one in so many, that a band may take at most: noise is what the rest is."""
BAND = 6.0
"""Log likelihood ratio of a band over none, beyond that of so many bands, that chance may give (2 in 1000). On 155 gyros of `benchmarks/hidden.py`
with nothing hidden it reached 1.8."""
BAND_BESIDE = 8.0
"""The same beside added effects, whose simplified forms leave what swings."""
STEADY, CYCLES, FINER, TOGETHER = 0.5, 3, 8, 0.9
"""Part of what is left beyond the white noise that one frequency has to have for a period; cycles that the longest run has to show of it; how many
frequencies are tried in a resolution; part of its power that has one phase in all runs where it has the same."""
SKIRT = 4
"""Resolutions to either side of a line that belong to it: a phase that wanders spreads it."""


@dataclass(frozen=True)
class Swings:
    """The band of one run's spectrum that stands out most.

    Attributes:
        evidence: log likelihood ratio of a white spectrum that is higher there over one that is not, less the logarithm of the number of bands.
        share: of the variance of all runs, what the band has more than the rest.
        periods_s: its shortest and longest period [s].
    """

    evidence: float
    share: float
    periods_s: tuple[float, float]

    @property
    def matters(self) -> bool:
        """Whether chance does not do that."""
        return self.evidence > BAND


class Recurrence(NamedTuple):
    """A line in the spectra of what a model leaves.

    Attributes:
        period_s: its period [s].
        runs: how many were looked at.
        alike: whether it has the same phase in all of them, from their first blocks on.
    """

    period_s: float
    runs: int
    alike: bool


def periodograms(bench: Workbench, solved: Solved, lines: tuple[float, ...] = ()) -> list[tuple[Tensor, Tensor]]:
    """Power and frequency [Hz] of each run's residual, whitened by its likeliest noise, but for the ends of the spectrum; blocks as evenly spaced.

    Args:
        bench: the runs.
        solved: the model.
        lines: frequencies of lines that the model has [Hz]: what is left around them, or their images in block means, is theirs, and taken for noise.
    """
    white = bench.mixtures.whitener(solved.likely.place)[1](solved.residual.unsqueeze(1)).squeeze(1)
    found = []
    for run, part in zip(bench.runs, white.split([run.blocks for run in bench.runs]), strict=True):
        power = (torch.fft.rfft(part).abs().square() / max(len(part), 1))[1:-1]
        frequency = torch.fft.rfftfreq(len(part), run.average_s).to(part)[1:-1]
        known = _around(frequency, lines, run.average_s)
        found.append((torch.where(known, power[~known].mean() if bool((~known).any()) else power, power), frequency))
    return found


def _around(frequency: Tensor, lines: tuple[float, ...], average_s: float) -> Tensor:
    """Which frequencies are within a few resolutions of a line or of its image."""
    known = torch.zeros_like(frequency, dtype=torch.bool)
    for line in lines if len(frequency) > 1 else ():
        image = abs(line * average_s - round(line * average_s)) / average_s
        known |= (frequency - image).abs() <= SKIRT * (frequency[1] - frequency[0])
    return known


def swings(bench: Workbench, solved: Solved, lines: tuple[float, ...] = ()) -> Swings:
    """The band that stands out most in the periodograms of a model's residual, whitened by its likeliest noise.

    Ordinates of a white periodogram are exponential; of w of them whose mean is r times that of all, the likelihood of a level of their own over the
    common one has the logarithm w·(r − 1 − ln r) (Whittle 1953). Bands are a power of two wide. Blocks are taken as evenly spaced.
    """
    powers = [power for power, _ in periodograms(bench, solved, lines)]
    mean, total = float(torch.cat(powers).mean()), max(sum(map(len, powers)), 1)
    found, tried = Swings(-math.inf, 0.0, (math.inf, math.inf)), 0
    for run, power in zip(bench.runs, powers, strict=True):
        sums = torch.nn.functional.pad((power / max(mean, 1e-300)).cumsum(0), (1, 0))
        width = 1
        while width <= len(power) // WIDEST:
            level = ((sums[width:] - sums[:-width]) / width).clamp_min(1.0)
            ratio = width * (level - 1.0 - level.log())
            place = int(ratio.argmax())
            tried += 2 * len(ratio) // width
            if float(ratio[place]) > found.evidence:
                step = 1.0 / (2.0 * run.average_s * (len(power) + 1))
                periods = 1.0 / (step * (place + width)), 1.0 / (step * (place + 1))
                found = Swings(float(ratio[place]), (float(level[place]) - 1.0) * width / total, periods)
            width *= 2
    return Swings(found.evidence - math.log(max(tried, 1)), found.share, found.periods_s)


def recurrence(bench: Workbench, solved: Solved) -> Recurrence | None:
    """The line that accounts for what a model leaves beyond white noise, with a height of its own in each run; None where none does.

    Blocks are taken as evenly spaced.
    """
    parts = solved.residual.split([run.blocks for run in bench.runs])
    longest = max(map(len, parts))
    white = float(torch.cat([torch.fft.rfft(part)[1:-1].abs().square() / len(part) for part in parts]).median()) / math.log(2.0)
    lines = torch.stack([torch.fft.rfft(part, FINER * longest) * math.sqrt(2.0 / len(part)) for part in parts])
    power = lines.abs().square().sum(dim=0)
    power[: CYCLES * FINER] = 0.0
    place = int(power.argmax())
    beyond = float(solved.residual.square().sum()) - len(solved.residual) * white
    if not float(power[place]) > STEADY * beyond > 0.0:
        return None
    shares = torch.tensor([len(part) / len(solved.residual) for part in parts]).sqrt().to(lines)
    together = float((shares * lines[:, place]).sum().abs().square() / power[place])
    return Recurrence(FINER * longest * bench.runs[0].average_s / place, len(parts), together > TOGETHER)
