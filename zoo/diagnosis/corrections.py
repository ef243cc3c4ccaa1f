"""Is an addition an effect of its own, or does it correct the simplified form of those before it?"""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.free_functions import functions_of
from zoo.diagnosis.quantities import inputs_of
from zoo.diagnosis.workbench import Solved, Workbench
from zoo.fitting.projection import complement, orthonormal, project

STANDS_FOR = 0.85
"""Share of what the effects before it explain that a free function must reproduce to be their freer form."""
KEPT = 0.5
"""Share of its evidence that an effect of its own keeps beside a freer form of the others."""


def stands_apart(bench: Workbench, base: Solved, before: Solved, after: Solved, evidence: float, needed: float) -> bool:
    """Whether an addition is called for even where the effects before it may take any smooth form.

    One that goes with an input which those before it do not know corrects none of them. Those that depend on one quantity, as ageing does on time,
    are given a free function of it; what a correction of their form would explain is then explained already. Where no such function stands for them,
    nobody can tell.

    Args:
        bench: the runs.
        base: the model before anything was added.
        before: with the effects before it.
        after: with the addition as well.
        evidence: log Bayes factor of the two.
        needed: what an addition must reach.
    """
    if any(has_own_input(bench, name, [one for one in before.names if one not in base.names]) for name in after.names if name not in before.names):
        return True
    freer = _freer(bench, base, before)
    if freer is None:
        return False
    price = after.likely.logarithm - before.likely.logarithm - evidence
    left = _logarithm(bench, after, freer) - _logarithm(bench, before, freer) - price
    return left > max(needed, KEPT * evidence)


def has_own_input(bench: Workbench, name: str, others: list[str]) -> bool:
    """Whether an effect goes with a column or with the reference rate, and none of some others does."""
    return bool(inputs_of(bench.effects[name]).difference(*[inputs_of(bench.effects[other]) for other in others]))


def _logarithm(bench: Workbench, solved: Solved, freer: Tensor) -> float:
    return bench.mixtures.most_likely(torch.cat([solved.fit.plain, freer], dim=1), solved.design.error, solved.likely.place).logarithm


def _freer(bench: Workbench, base: Solved, before: Solved) -> Tensor | None:
    """(N, K) the free function that reproduces best what was added to the base, beside the base; None where none does."""
    added = [place for name, places in before.places().items() if name not in base.names for place in places]
    rest = [place for place in range(before.plain_columns.shape[1]) if place not in added]
    columns = orthonormal(bench.whitener(before.plain_columns[:, rest]))
    signal = complement(bench.whitener((before.plain_columns[:, added] @ before.fit.amplitudes[added]).unsqueeze(1)), columns).squeeze(1)
    left = {
        free: float(project(complement(bench.whitener(free.columns), columns), signal).cost) / float(signal.square().sum())
        for free in functions_of(bench, before)
    }
    best = min(left, key=lambda free: left[free])
    return best.columns if left[best] < 1.0 - STANDS_FOR else None
