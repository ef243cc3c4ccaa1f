"""What of a hidden effect can be seen at all: how much worse the base grey box, refitted, explains the runs because of it, in the true noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch
from hidden_effects.case import Case
from hidden_effects.recipe import BASE
from torch import Tensor

from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.refine import check_rms
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.effects.base import Effect
from zoo.fitting.design import coarse_starts
from zoo.fitting.projection import project
from zoo.fitting.variable_projection import fit
from zoo.measurements.run import Run


@dataclass(frozen=True)
class Visible:
    """What could be known of a case.

    Attributes:
        sizes: z of each hidden effect, z² = χ²(with it) − χ²(without it) or 0: the noncentrality of the test for it. Both are the least that the base
            grey box, its coil and all, leaves of data without noise, weighted by the true noise; the second is what its simplified forms leave
            anyway. The other hidden effects are known in both but for their amplitudes.
        rms: RMS of each over the fitted runs beyond what the base takes up [unit]: the same with all blocks weighted alike, which is what `amplitude`
            of `fogzoo simulate` means.
        check_over_floor: RMS that the base fitted to the case without anything hidden leaves on the check run, over the noise there.
    """

    sizes: list[float]
    rms: list[float]
    check_over_floor: float


def visible(case: Case, catalogue: dict[str, Effect]) -> Visible:
    """Fit the base with the true noise: where nothing is hidden, and with one hidden effect at a time to data without noise."""
    *runs, check = case.without_hidden()
    bench = open_bench(runs, list(BASE), catalogue).with_noise(case.noise)
    base = bench.solve(BASE)
    plain = _means(bench.runs, case.without_noise())
    hidden = [_means(bench.runs, case.hidden_blocks(one)) for one in case.hidden]
    weighted, alike = Refits(base, base.design.whitener), Refits(base, lambda columns: columns)
    sizes, sums = ([one.size(plain, part, hidden[:i] + hidden[i + 1 :]) for i, part in enumerate(hidden)] for one in (weighted, alike))
    return Visible(sizes, [one / len(plain) ** 0.5 for one in sums], (check_rms(base.model, [check]) or 0.0) / noise_rms(case.noise_blocks()[-1]))


def left_beside(case: Case, names: list[str], catalogue: dict[str, Effect]) -> float:
    """How much worse than the truth the base with some effects explains the runs, in the true noise, as a z: what a test for a misfit could see.

    Of data without noise; near 0 where the effects, whatever they are, do what the hidden ones do.
    """
    bench, solved = _with_effects(case, names, catalogue)
    means = _means(bench.runs, case.without_noise()) + torch.stack([_means(bench.runs, case.hidden_blocks(one)) for one in case.hidden]).sum(dim=0)
    design = solved.design
    return fit(design.plain_columns, design.whitener(means).squeeze(1), solved.fit.theta, weigh=design.whitener).cost ** 0.5


def check_over_floor_told(case: Case, catalogue: dict[str, Effect]) -> float:
    """RMS that the base with the hidden effects leaves on the check run, over the noise there: what a diagnosis that is never wrong comes to.

    The effects are the catalogue's, fitted to the runs as they were measured, in the true noise.
    """
    _, solved = _with_effects(case, [one.name for one in case.hidden], catalogue)
    return (check_rms(solved.model, [case.measured()[-1]]) or 0.0) / noise_rms(case.noise_blocks()[-1])


def _with_effects(case: Case, names: list[str], catalogue: dict[str, Effect]) -> tuple[Workbench, Solved]:
    """The base with some effects, each searched for beside those before, fitted to the measured runs in the true noise."""
    bench = open_bench(case.measured()[:-1], list(BASE), catalogue).with_noise(case.noise)
    solved = bench.solve(BASE)
    for name in names:
        solved = bench.add(solved, name)
    return bench, solved


def noise_rms(run: Run) -> float:
    """RMS of a run's error over its blocks, nothing fitted [unit]."""
    return float(run.block_mean(run.error).square().mean().sqrt())


def _means(blocks: list[Run], runs: list[Run]) -> Tensor:
    """(N, 1) block means of the errors of runs in the blocks of the bench, which has left out spikes [unit]."""
    return torch.cat([kept.block_mean(run.error) for kept, run in zip(blocks, runs, strict=False)]).unsqueeze(1)


class Refits:
    """Fits of the base to data without noise, each from its fit where nothing is hidden and from the best of a grid over the coil."""

    def __init__(self, base: Solved, weigh: Callable[[Tensor], Tensor]) -> None:
        """Keep the columns of the grid.

        Args:
            base: fitted where nothing is hidden.
            weigh: (..., N, K) block means -> the same, weighted.
        """
        self.design, self.near, self.weigh = base.design, base.fit.theta, weigh
        self.grid = coarse_starts(base.design)
        self.columns = base.design.plain_columns(self.grid)

    def size(self, plain: Tensor, signal: Tensor, others: list[Tensor]) -> float:
        """How visible a signal is: the root of what it adds to the least χ².

        Args:
            plain: (N, 1) block means of the base effects [unit].
            signal: (N, 1) of the hidden effect [unit].
            others: (N, 1) each, of the other hidden effects [unit].
        """
        known = torch.cat([plain.new_zeros(len(plain), 0), *others], dim=1)
        gained = self._least(plain + signal, known) - self._least(plain, known)
        return max(gained, 0.0) ** 0.5

    def _least(self, means: Tensor, known: Tensor) -> float:
        """Least χ² of the base and of known signals (N, M) of free amplitudes; whether these are in the means (N, 1) makes no difference."""
        weigh = self.weigh
        target = weigh(means).squeeze(1)
        costs = project(weigh(_beside(self.columns, known)), target).cost
        starts = [self.near, self.grid[costs.argmin()]]
        return min(fit(lambda theta: _beside(self.design.plain_columns(theta), known), target, start, weigh=weigh).cost for start in starts)


def _beside(columns: Tensor, known: Tensor) -> Tensor:
    """(B, N, K) and (N, M) -> (B, N, K+M)."""
    return torch.cat([columns, known.expand(len(columns), *known.shape)], dim=2)
