"""What makes an addition worth while, and what makes it superfluous."""

from __future__ import annotations

import math
from collections.abc import Iterable

from zoo.diagnosis.corrections import has_own_input, is_smooth, stands_apart
from zoo.diagnosis.cross_validation import segment_cost
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import leaves_noise
from zoo.diagnosis.trials import OVERWHELMING, Step, Trial
from zoo.diagnosis.workbench import FAR, QUIET, Workbench
from zoo.effects.repeated import kind, kinds

ACCEPT, FIRST = 7.0, 2.3
"""Log Bayes factor that an effect must reach over the model without it, on top of the logarithm of the number of candidates: 1100 : 1; 10 : 1 for
the first that is added, for beside nothing it cannot make up for the simplified form of another. Of 551 simulated gyros with nothing hidden nine have
more than the latter; what makes up for another's form reaches 14, what is really there beside another has 20 and more in twenty gyros of twenty."""
MOPPING_UP = 0.03
"""Share of the variance explained so far below which an addition is taken for a correction to it (17 % in amplitude)."""
BARELY, ALIKE = 0.0064, 0.0625
"""The same below which it is one however strong the evidence, where both are smooth: no form in the catalogue is nature's to a few per cent (8 % in
amplitude). And below which one is that is easily confused with another before it, unless evidence is overwhelming (a quarter in amplitude)."""
MINOR = 0.15
"""Share of the evidence of all added effects below which one of them may be a correction to the others."""
MATERIAL = 0.1
"""Share of the variance above the white noise that an addition must take away."""
MOST = 0.5
"""Share of the whole variance, of what is no noise or might be a walk, that an addition must take away to be believed on less evidence."""


def accepted(base: Solved, before: Solved) -> float:
    """What an addition to a model must reach, on top of the logarithm of the number of candidates.

    Args:
        base: the model before anything was added.
        before: the model before this addition.
    """
    return FIRST if before.names == base.names else ACCEPT


def convinces(bench: Workbench, base: Solved, step: Step, best: Trial) -> bool:
    """Whether an addition is worth it: strong evidence, more than a correction, and a visible gain with lower error on pieces that were not fitted.

    Where it leaves noise, evidence is enough: what happens once in a run, such as a warm-up, no other piece of it predicts. The evidence is over a
    noise that would do without it: where what was left is none, and is one with the addition, less will do; and where a walk would do, an addition
    that takes most of it away need not outweigh the number of candidates.

    Args:
        bench: the runs.
        base: the model before anything was added.
        step: the round in which it was compared with others.
        best: the addition.
    """
    before, needed = step.before, step.needed
    if best.solved is None or not best.refitted or before.rms < QUIET * bench.mixtures.white:
        return False
    if _corrects(bench, base, before, best) or _only_by_noise(bench, before, best):
        return False
    if best.evidence < needed:
        return best.evidence > 0 and _saves(bench, base, before, best)
    if _mops_up(bench, base, before, best) and not stands_apart(bench, base, before, best.solved, best.evidence, needed):
        return False
    if _material(bench, before, best.solved) and segment_cost(bench, best.solved) < segment_cost(bench, before):
        return True
    return leaves_noise(bench, best.solved, base)


def _only_by_noise(bench: Workbench, before: Solved, best: Trial) -> bool:
    """Whether an addition lowers neither the RMS nor, beside slow noise where what is fast may go while that stays, the error on unfitted pieces."""
    assert best.solved is not None
    if best.solved.rms < before.rms or best.evidence >= OVERWHELMING:
        return False
    return segment_cost(bench, best.solved) >= segment_cost(bench, before)


def _saves(bench: Workbench, base: Solved, before: Solved, best: Trial) -> bool:
    """Whether an addition leaves noise by taking most away, of what was none or, on strong evidence, might be a walk."""
    assert best.solved is not None
    if best.solved.rms**2 >= (1.0 - MOST) * before.rms**2 or not leaves_noise(bench, best.solved, base):
        return False
    return best.evidence > ACCEPT or not leaves_noise(bench, before, base)


def _material(bench: Workbench, before: Solved, after: Solved) -> bool:
    """Whether an addition takes away a fair part of what is more than white noise; a little of much is hardly what is missing."""
    return before.rms**2 - after.rms**2 >= MATERIAL * max(before.rms**2 - bench.mixtures.white**2, 0.0)


def best_of(bench: Workbench, base: Solved, convincing: list[Trial]) -> Trial | None:
    """The one with the strongest evidence; where that leaves more than noise, the one that predicts pieces best which were not fitted.

    Likelihoods compare models of which one is true up to noise. While something else is missing as well, a flexible effect wins by bending to it.

    Args:
        bench: the runs.
        base: the model before anything was added.
        convincing: what may be added, most likely first.
    """
    if not convincing or convincing[0].solved is None:
        return None
    likeliest = convincing[0].solved
    if likeliest.rms <= FAR * bench.mixtures.white or len(convincing) == 1:
        return convincing[0]
    predicts = min(convincing, key=lambda trial: segment_cost(bench, trial.solved) if trial.solved else math.inf)
    return convincing[0] if predicts is not convincing[0] and leaves_noise(bench, likeliest, base) else predicts


def chosen_of(bench: Workbench, base: Solved, step: Step) -> Trial | None:
    """What a round adds to a model: the best of those that convince; None where none does.

    Args:
        bench: the runs.
        base: the model before anything was added.
        step: the round.
    """
    return best_of(bench, base, [trial for trial in step.trials if convinces(bench, base, step, trial)])


def _corrects(bench: Workbench, base: Solved, before: Solved, addition: Trial) -> bool:
    """Whether an addition explains so little beside what was added before that only the latter's form can be meant."""
    older, new, after = [name for name in before.names if name not in base.names], addition.screened.name, addition.solved
    assert after is not None
    if not older or bench.effects[new].frequencies(after.shape_of(new)) or has_own_input(bench, new, older):
        return False
    share = (before.rms**2 - after.rms**2) / max(base.rms**2 - before.rms**2, 1e-300)
    little = not bench.look_alikes(new).isdisjoint(older) and share < ALIKE and addition.evidence < OVERWHELMING
    return little or (share < BARELY and is_smooth(bench, base, before, after, addition.evidence))


def _mops_up(bench: Workbench, base: Solved, before: Solved, addition: Trial) -> bool:
    """Whether an addition may be making up for the simplified form of those before it.

    That is where it explains little beside them, or where they left noise and it adds little to the evidence. What happens once more does not.
    """
    assert addition.solved is not None
    if _once_more(bench, addition.screened.name, before.names):
        return False
    explained, more = base.rms**2 - before.rms**2, before.rms**2 - addition.solved.rms**2
    if explained <= 0:
        return False
    little = addition.evidence < OVERWHELMING and more < MOPPING_UP * explained
    return little or (addition.evidence < MINOR * bench.evidence(base, before) and leaves_noise(bench, before, base))


def _once_more(bench: Workbench, name: str, others: Iterable[str]) -> bool:
    """Whether an effect is what one of the others is as well, at another moment."""
    return kind(name, bench.effects[name]) in kinds((other for other in others if other != name), bench.effects)


def pruned(bench: Workbench, full: Solved, base: Solved) -> Solved:
    """Drop added effects, all but the newest, that the model no longer needs.

    One that adds a little to the evidence is needed only where there would be more than noise without it, or beside a freer form of the others: else
    it makes up for the simplified form of another.
    """
    for name in [other for other in full.names[:-1] if other not in base.names]:
        less = bench.without(full, name)
        own = bench.evidence(less, full)
        minor = own < MINOR * bench.evidence(base, full) and not _once_more(bench, name, full.names)
        if own < ACCEPT or (minor and leaves_noise(bench, less, base) and not stands_apart(bench, base, less, full, own, ACCEPT)):
            full = less
    return full
