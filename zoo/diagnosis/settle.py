"""The search under the noise that it finds itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from zoo.diagnosis.acceptance import ACCEPT, chosen_of
from zoo.diagnosis.reach import out_of_reach
from zoo.diagnosis.readings import without_scatter
from zoo.diagnosis.search import (
    IN_SIGHT,
    Search,
    by_evidence,
    finished,
    in_reach,
    looked_again,
    never,
    pair,
    replacement,
    round_for_a_pair,
    same,
    search,
    single,
)
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import leaves_noise
from zoo.diagnosis.trials import OVERWHELMING, Step, Trial, refit, refit_best
from zoo.diagnosis.workbench import COARSE, FINE, Workbench, theta_without
from zoo.effects.repeated import kinds
from zoo.fitting.variable_projection import Fit
from zoo.scoring.noise import white_level
from zoo.scoring.stages import rms
from zoo.side_by_side import side_by_side

REPEATED = 3
"""How often the search is repeated at most because the white noise is less than it seemed."""
QUIETER = 0.75
"""Ratio of white noise left to white noise assumed, below which the search is repeated."""
RECONSIDER, SLOW = 2.0, 0.4
"""Ratio of flicker found to flicker assumed, and share of random walk per √h, above which the search is repeated."""


def settle(
    bench: Workbench, names: tuple[str, ...], candidates: list[str], progress: Callable[[str], None] = lambda _: None
) -> tuple[Workbench, Search]:
    """Search, and once more without the outliers or weighted by the noise that the first search left, where there are any or that is another noise.

    The white noise was read off differences of the error, which a fast effect enlarges; what is left of them tells better. Where the scatter of the
    thermometers' readings matters, they are drawn smooth, before the search or, where a model on its way shows it, for another. What a free form
    explains and no effect is neither noise to weigh by nor outliers.

    Args:
        bench: the runs under the noise assumed at first.
        names: the model as it stands.
        candidates: effects that may be added.
        progress: told what is being tried.
    """
    bench, found = _quietly(without_scatter(bench, [bench.begin(names)]), names, candidates, progress)
    steady = without_scatter(bench, found.path)
    if steady is not bench:
        bench, found = _quietly(steady, names, candidates, progress)
    beyond = out_of_reach(bench, found.final, found.base)
    clean = bench if beyond else bench.without_outliers(found.final)
    if clean is not bench:
        bench, found = clean, _again(clean, found, candidates, progress)
        beyond = out_of_reach(bench, found.final, found.base)
    likely, assumed = found.final.likely.noise, bench.noise
    as_assumed = likely.walk < SLOW * likely.white and likely.flicker < RECONSIDER * assumed.flicker
    if as_assumed or beyond:
        return bench, found
    if bench.mixtures.much_walk(likely):
        return _beside_a_walk(bench, found, candidates, progress)
    again = bench.with_noise(likely)
    return again, replace(_again(again, found, candidates, progress), first=found.base)


def _beside_a_walk(bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None]) -> tuple[Workbench, Search]:
    """A search that left much of a walk, once more weighed by it where that leads to noise.

    As if noise were white, fits go far to follow with one effect what another makes, and evidence, under a walk, makes little of what they gain by
    that. Weighed by the walk they leave the rest to it; two at once were tried before. Once there is noise, the fits are weighed by that, unless
    noise is no longer what they leave.
    """
    if leaves_noise(bench, found.final, found.base):
        return bench, found
    walking = bench.with_noise(found.final.likely.noise)
    other = search(walking, walking.begin(found.base.names), candidates, progress, pairs=False)
    if not leaves_noise(walking, other.final, other.base):
        return bench, found
    again = walking.with_noise(other.final.likely.noise)
    last = _again(again, other, candidates, progress)
    ends = leaves_noise(again, last.final, last.base)
    return (again, replace(last, first=found.base)) if ends else (walking, replace(other, first=found.base))


def _quietly(bench: Workbench, names: tuple[str, ...], candidates: list[str], progress: Callable[[str], None]) -> tuple[Workbench, Search]:
    """Search, and from the start once more as soon as what is left is quieter than the runs were taken for."""
    for left in reversed(range(REPEATED + 1)):
        in_vain = partial(_taken_for_louder, bench) if left else never
        found = search(bench, bench.begin(names), candidates, progress, in_vain)
        if not in_vain(found):
            break
        bench = bench.with_white(_white(bench, found))
    return bench, found


def _taken_for_louder(bench: Workbench, found: Search) -> bool:
    """Whether what is left is quieter than the runs were taken for."""
    return _white(bench, found) < QUIETER * bench.mixtures.white


def _again(bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None]) -> Search:
    """What was found, on nearly the same runs or under other noise: fitted on where it ends at the same, searched for anew where not."""
    return reweighed(bench, found, progress) or search(bench, bench.begin(found.base.names), candidates, progress)


def _white(bench: Workbench, found: Search) -> float:
    """White noise that is left [unit]: beside the final model, or the overwhelming addition to it that was refused for what the rest is like then.

    What drawing readings smooth leaves is a part of it, though differences show nothing of that.

    Noise that is taken for louder than it is makes too little of what is slow, so that nothing seems to leave noise.
    """
    refused = [trial.solved for step in found.steps if same(step.before, found.final) for trial in step.trials if trial.evidence > OVERWHELMING]
    left = [one.residual for one in (found.final, *refused) if one is not None]
    levels = [math.hypot(white_level(list(one.split([run.blocks for run in bench.runs]))), bench.scatter) for one in left]
    return min(min(level, rms(one)) for level, one in zip(levels, left, strict=True))


def reweighed(bench: Workbench, found: Search, progress: Callable[[str], None] = lambda _: None) -> Search | None:
    """A search with its models fitted on under other noise; None where it would not end as it did.

    Of one that went straight to its end every round is asked again. Where that end is no noise and runs have changed, nothing else that was tried
    may lead to any now either. Of one that came to noise by detours, or straight but another effect would come first now, the end is asked: nothing
    beside it, and nothing in the place of what was added, may be called for.

    Evidence is weighed in whichever noise suits a model best, before as well as now. So other weights only move what was fitted, mostly by little:
    what hardly explains anything under some is not looked for again under the others, nor what led nowhere. (Of 111 simulated gyros 17 came to no
    noise under the first weights; of these none did under the second.)

    Args:
        bench: the same runs, or nearly so, under the other noise.
        found: the search.
        progress: told what is being tried.
    """
    pairs = _beyond_the_end(found)
    if pairs is None:
        return _end_reweighed(bench, found, progress)
    again, kept = _fitted_on(bench, found, found.path)
    base = again.base
    for number, old in enumerate(found.steps[: len(found.steps) - len(pairs)]):
        there = kept.get(frozenset(old.before.names))
        before = there or bench.solve(old.before.names, [old.before.fit.theta], old.before.likely.place)
        step = _asked_again(bench, old, before, kept)
        if number <= len(found.missing):
            _forward_again(bench, base, step, progress)
        else:
            _exchange_again(bench, again, step, str(old.chosen), progress)
        if step.chosen != old.chosen:
            return None if pairs else _end_reweighed(bench, found, progress)
        again.steps.append(step)
    if leaves_noise(bench, again.final, base):
        return None if pairs else again
    same_runs = bench.runs is found.base.design.runs
    return again if pairs and (same_runs or _nothing_else(bench, again, pairs, progress)) else None


def _fitted_on(bench: Workbench, found: Search, path: list[Solved]) -> tuple[Search, dict[frozenset[str], Solved]]:
    """A search with some of its models fitted on, without its rounds; and these models by the names of their effects."""
    models = [found.base, *path]
    fits = side_by_side(lambda one: bench.fitted(one.names, [one.fit.theta], FINE if one is found.base else COARSE), models)
    base, *others = [bench.taken(one.names, there, one.likely.place) for one, there in zip(models, fits, strict=True)]
    again = Search(base, base)
    for one in others:
        again.keep(finished(bench, base, one))
    return again, {frozenset(one.names): one for one in (base, *again.path)}


def _end_reweighed(bench: Workbench, found: Search, progress: Callable[[str], None]) -> Search | None:
    """A search with its last model alone fitted on, and the rounds that say why it ended there asked again; None where there is not each of them, or
    one has another answer now."""
    rounds = {frozenset(step.before.names): step for step in found.steps}
    places = {frozenset(found.final.names) - {name}: name for name in found.missing}
    if not found.missing or not rounds.keys() >= {frozenset(found.final.names), *places}:
        return None
    again, kept = _fitted_on(bench, found, [found.final])
    for beside in dict.fromkeys([frozenset(found.base.names), *places, frozenset(found.final.names)]):
        old = rounds[beside]
        before = kept.get(beside) or _less(bench, again, old.before)
        if not before.names == old.before.names == tuple(name for name in again.final.names if name in beside):
            return None  # parameters are in the order of the effects
        step = _asked_again(bench, old, before, kept)
        again.steps.append(step)
        if beside in places:
            own = _exchange_again(bench, again, step, places[beside], progress)
            if step.chosen != places[beside] or own.evidence < ACCEPT:
                return None
        else:
            _forward_again(bench, again.base, step, progress)
    return again if step.chosen is None and leaves_noise(bench, again.final, again.base) else None


def _less(bench: Workbench, again: Search, before: Solved) -> Solved:
    """A model that lacks one effect of the last, fitted on as far as that was: from where it was and, its other effects looked for anew, elsewhere.

    What is fitted less far than the one with the effect would make too much of it.
    """
    fitted = finished(bench, again.base, bench.solve(before.names, [before.fit.theta], before.likely.place))
    return looked_again(bench, fitted, [name for name in before.names if name not in again.base.names])


def _beyond_the_end(found: Search) -> list[Step] | None:
    """The rounds in which two effects at once were tried in vain, after a search that went straight to its end; None of one that did not.

    Straight: every round added what is in the end there, the last one nothing, and no exchange took the place of anything.
    """
    missing = found.missing
    asked = missing if len(missing) > 1 else []
    rounds, exchanges = found.steps[: len(missing) + 1], found.steps[len(missing) + 1 : len(missing) + 1 + len(asked)]
    pairs = found.steps[len(missing) + 1 + len(asked) :]
    ways = [(*found.base.names, *missing[:number]) for number in range(len(missing) + 1)]
    if [one.names for one in found.path] != ways[1:] or [step.before.names for step in rounds] != ways:
        return None
    if [step.chosen for step in rounds] != [*missing, None] or [step.chosen for step in exchanges] != asked:
        return None
    others = [step.chosen is None and step.before.names not in ways and step.before.names[:-1] == found.base.names for step in pairs]
    return pairs if all(others) else None


def _nothing_else(bench: Workbench, again: Search, pairs: list[Step], progress: Callable[[str], None]) -> bool:
    """Whether a search that ends where there is no noise finds none by other ways either, of which it has tried some pairs before."""
    candidates = kinds((trial.screened.name for trial in again.steps[0].trials), bench.effects)
    if single(bench, again) or by_evidence(bench, again, candidates, progress):
        return False

    def ask(before: Solved, names: list[str]) -> Step:
        old = next((step for step in pairs if step.before.names == before.names), None)
        if old is None:
            return round_for_a_pair(bench, before, names, progress)
        step = _asked_again(bench, old, before, {})
        refit_best(bench, step, progress, IN_SIGHT * bench.mixtures.white)
        return step

    path = len(again.path)
    pair(bench, again, candidates, progress, ask)
    return len(again.path) == path


def _forward_again(bench: Workbench, base: Solved, step: Step, progress: Callable[[str], None]) -> None:
    """What a round of a search forward comes to."""
    refit_best(bench, step, progress)
    best = chosen_of(bench, base, step)
    step.chosen = None if best is None else best.screened.name


def _exchange_again(bench: Workbench, again: Search, step: Step, name: str, progress: Callable[[str], None]) -> Trial:
    """What a round for another effect in the place of one comes to; gives that one's own trial."""
    own = next(trial for trial in step.trials if trial.screened.name == name)
    others = [trial for trial in in_reach(step.trials, own.evidence, bench.look_alikes(name)) if not trial.refitted]
    refit(bench, step.before, others, progress, 0, theta_without(again.final, name))
    step.sort()
    better = replacement(bench, again.base, step, own)
    step.chosen = name if better is None else better.screened.name
    return own


def _asked_again(bench: Workbench, old: Step, before: Solved, kept: dict[frozenset[str], Solved]) -> Step:
    """A round beside the same effects under other noise: what was refitted then is fitted on, what was glanced at is glanced at again."""
    trials = [replace(trial) for trial in old.trials]

    def known(trial: Trial) -> Solved | None:
        return kept.get(frozenset((*before.names, trial.screened.name)))

    def fitted_on(trial: Trial) -> tuple[Fit, float] | None:
        was = trial.solved
        if was is None or known(trial) is not None:
            return None
        if trial.refitted:
            own = bench.taken(was.names, bench.fitted(was.names, [was.fit.theta], COARSE), before.likely.place)
        else:
            own = bench.peek(before, trial.screened.name, trial.screened.shape, trial.screened.start)
        return own.fit, bench.evidence(before, own)

    for trial, found in zip(trials, side_by_side(fitted_on, trials), strict=True):
        own = known(trial)
        if found is not None and trial.solved is not None:
            taken = bench.taken if trial.refitted else bench.placed
            trial.solved, trial.evidence = taken(trial.solved.names, found[0], before.likely.place), found[1]
        elif own is not None and trial.solved is not None:
            trial.solved, trial.evidence = own, bench.evidence(before, own)
    return Step(before, trials, old.accept)
