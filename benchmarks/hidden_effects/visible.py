"""What of a hidden effect can be seen at all: its matched-filter signal-to-noise beside what the base grey box absorbs."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from hidden_effects.case import Case
from hidden_effects.recipe import BASE
from torch import Tensor

from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.refine import check_rms
from zoo.effects.base import Effect
from zoo.fitting.projection import complement, orthonormal
from zoo.measurements.run import Run


@dataclass(frozen=True)
class Visible:
    """What could be known of a case.

    Attributes:
        sizes: z of each hidden effect, ‖(I − P)s‖ with s its block means, whitened by the true noise. P projects on the columns and tangents of the
            base grey box at its fit to the case without anything hidden, and on the other hidden effects.
        check_over_floor: RMS that this fit leaves on the check run without anything hidden, over the noise there.
    """

    sizes: list[float]
    check_over_floor: float


def visible(case: Case, catalogue: dict[str, Effect]) -> Visible:
    """Fit the base where nothing is hidden, with the true noise."""
    *runs, check = case.without_hidden()
    bench = open_bench(runs, list(BASE), catalogue).with_noise(case.noise)
    base = bench.solve(BASE)
    signals = [bench.whitener(_blocks(case, place, bench.runs).unsqueeze(1)) for place in range(len(case.hidden))]
    sizes = []
    for place, signal in enumerate(signals):
        others = [other for at, other in enumerate(signals) if at != place]
        sizes.append(float(complement(signal, orthonormal(torch.cat([base.basis, *others], dim=1))).norm()))
    return Visible(sizes, (check_rms(base.model, [check]) or 0.0) / noise_rms(case.noise_blocks()[-1]))


def noise_rms(run: Run) -> float:
    """RMS of a run's error over its blocks, nothing fitted [unit]."""
    return float(run.block_mean(run.error).square().mean().sqrt())


def _blocks(case: Case, place: int, runs: list[Run]) -> Tensor:
    """(N,) block means of a hidden effect in the blocks of the bench, which has left out spikes."""
    return torch.cat([run.block_mean(one.error) for run, one in zip(runs, case.hidden_blocks(case.hidden[place]), strict=False)])
