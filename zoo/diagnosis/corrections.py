"""Is an addition an effect of its own, or does it correct the simplified form of those before it?"""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.free_functions import Axis, functions_of
from zoo.diagnosis.noise_likelihood import Likelihood, gain
from zoo.diagnosis.quantities import CLOCK, RATE, TEMPERATURE, inputs_of, inputs_seen, momentary
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.projection import complement, orthonormal, project

STANDS_FOR, ALSO = 0.85, 0.75
"""Share of what the effects before it explain that a free function must reproduce to be their freer form; where one does, that of others which may
be it as well."""
SLOW, SLOW_ORDER = (TEMPERATURE, RATE, CLOCK), 3
"""What the size of an effect may change with, and the order of that change."""
WANDER_ORDER = 8
"""Of the polynomials of time by which a line's phase and size may wander in a run."""
KEPT = 0.5
"""Share of its evidence that an effect of its own keeps beside a freer form of the others."""


def stands_apart(bench: Workbench, base: Solved, before: Solved, after: Solved, evidence: float, needed: float) -> bool:
    """Whether an addition is called for even where the effects before it may take any smooth form.

    One that goes with an input which those before it do not know corrects none of them. The others are given a freer form; what a correction of
    theirs would explain is then explained already. Those that depend on one quantity, as ageing does on time, are given a free function of it; what
    is slow goes with several, and an addition stands apart beside a function of each. Others are given powers of what they did, sizes that change
    with temperature, rate and time, and a function of the inputs that they go with; a line may wander in each run. What else has a memory may have
    any, and nobody can tell.

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
    forms = _freer(bench, base, before)
    return bool(forms) and all(_own(freer, before, after, evidence) > max(needed, KEPT * evidence) for freer in forms)


def is_smooth(bench: Workbench, base: Solved, before: Solved, after: Solved, evidence: float) -> bool:
    """Whether smooth functions, of time in each run and of temperature and rate, make up both the effects before an addition and most of what it is
    called for by: what is smooth is off by something smooth, a line or a fringe is not.

    Args:
        bench: the runs.
        base: where both began.
        before: as for `stands_apart`.
        after: with the addition.
        evidence: what it is called for by.
    """
    functions = functions_of(bench, before)
    clock = next(free.axis for free in functions if free.of is CLOCK)
    in_each = [clock.chebyshev(part, WANDER_ORDER) for part in clock.means.split([run.blocks for run in bench.runs])]
    smooth = torch.cat([torch.block_diag(*in_each), *(free.columns for free in functions if free.of in (TEMPERATURE, RATE))], dim=1)
    return _left(bench, base, before, [smooth])[0] < 1.0 - STANDS_FOR and _own(smooth, before, after, evidence) < KEPT * evidence


def has_own_input(bench: Workbench, name: str, others: list[str]) -> bool:
    """Whether an effect goes with a column or with the reference rate that changes in the runs, and none of some others does."""
    return bool(inputs_seen(bench, bench.effects[name]).difference(*[inputs_of(bench.effects[other]) for other in others]))


def _own(freer: Tensor, before: Solved, after: Solved, evidence: float) -> float:
    """What an addition keeps of its evidence beside more columns (N, K), for the same price."""
    return gain(_beside(freer, before), _beside(freer, after)) - (gain(before.likelihood, after.likelihood) - evidence)


def _beside(freer: Tensor, solved: Solved) -> Likelihood:
    """A model's with more columns (N, K)."""
    return solved.likelihood.of(torch.cat([solved.fit.plain, freer], dim=1))


def _freer(bench: Workbench, base: Solved, before: Solved) -> list[Tensor]:
    """(N, K) freer forms of what was added: functions of one quantity that stand for it, or what each may be like that has no memory."""
    functions = functions_of(bench, before)
    left = dict(zip(functions, _left(bench, base, before, [free.columns for free in functions]), strict=True))
    if min(left.values()) < 1.0 - STANDS_FOR:
        return [free.columns for free, share in left.items() if share < 1.0 - ALSO]
    added = _added(base, before)
    if not all(momentary(bench.effects[name]) for name in added):
        return []
    slow = torch.cat([free.axis.chebyshev(free.axis.means, SLOW_ORDER) for free in functions if free.of in SLOW and free.beside is None], dim=1)
    freer = []
    for name, own in added.items():
        freer.append(_changed(before.plain_columns[:, own] @ before.fit.amplitudes[own], slow))
        if bench.effects[name].frequencies(before.shape_of(name)):
            freer += [_wandering(before.plain_columns[:, own], free.axis) for free in functions if free.of is CLOCK]
        freer += [free.columns for free in functions if free.words in inputs_of(bench.effects[name])]
    return [torch.cat(freer, dim=1)]


def _added(base: Solved, before: Solved) -> dict[str, list[int]]:
    """Columns of the effects that were added to a base."""
    return {name: places for name, places in before.places().items() if name not in base.names}


def _left(bench: Workbench, base: Solved, before: Solved, forms: list[Tensor]) -> list[float]:
    """Shares of what the added effects explain, beside the others, that some columns (N, K) do not reproduce."""
    places = [place for own in _added(base, before).values() for place in own]
    rest = [place for place in range(before.plain_columns.shape[1]) if place not in places]
    columns = orthonormal(bench.whitener(before.plain_columns[:, rest]))
    signal = complement(bench.whitener((before.plain_columns[:, places] @ before.fit.amplitudes[places]).unsqueeze(1)), columns).squeeze(1)
    return [float(project(complement(bench.whitener(form), columns), signal).cost) / float(signal.square().sum()) for form in forms]


def _changed(signal: Tensor, slow: Tensor) -> Tensor:
    """(N, K+2) a signal (N,) with a size that changes as slow columns (N, K) do, and its square and cube."""
    unit = signal / signal.square().mean().sqrt()
    return torch.cat([unit.unsqueeze(1) * slow, torch.stack([unit**2, unit**3], dim=1)], dim=1)


def _wandering(columns: Tensor, clock: Axis) -> Tensor:
    """(N, K·WANDER_ORDER) the waves of lines (N, K), each with sizes of its own that change with time, which is a phase that does."""
    return (columns.unsqueeze(2) * clock.chebyshev(clock.means, WANDER_ORDER).unsqueeze(1)).flatten(1)
