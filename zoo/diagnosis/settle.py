"""The search under the noise that it finds itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from zoo.diagnosis.acceptance import best_of, convinces
from zoo.diagnosis.readings import without_scatter
from zoo.diagnosis.search import Search, finished, same, search
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import leaves_noise
from zoo.diagnosis.trials import OVERWHELMING, Step, Trial, refit, worth_a_refit
from zoo.diagnosis.workbench import COARSE, Workbench
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

    The white noise was read off differences of the error, which a fast effect enlarges; what is left of them tells better.

    Args:
        bench: the runs under the noise assumed at first.
        names: the model as it stands.
        candidates: effects that may be added.
        progress: told what is being tried.
    """
    bench = without_scatter(bench, [bench.begin(names)])
    found = search(bench, bench.begin(names), candidates, progress)
    steady = without_scatter(bench, found.path)
    if steady is not bench:
        bench = steady
        found = search(bench, bench.begin(names), candidates, progress)
    for _ in range(REPEATED):
        white = _white(bench, found)
        if white >= QUIETER * bench.mixtures.white:
            break
        bench = bench.with_white(white)
        found = search(bench, bench.begin(names), candidates, progress)
    clean = bench.without_outliers(found.final)
    if clean is not bench:
        bench = clean
        found = search(bench, bench.begin(names), candidates, progress)
    likely, assumed = found.final.likely.noise, bench.noise
    as_assumed = likely.walk < SLOW * likely.white and likely.flicker < RECONSIDER * assumed.flicker
    if as_assumed or bench.mixtures.much_walk(likely):
        return bench, found
    again = bench.with_noise(likely)
    repeated = reweighed(again, found, progress) or search(again, again.begin(names), candidates, progress)
    return again, replace(repeated, first=found.base)


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
    """A search that went straight to its end, with all its models fitted on under other noise; None where it would not end there.

    Evidence is weighed in whichever noise suits a model best, before as well as now. So other weights only move what was fitted, mostly by little,
    and what hardly explains anything under some is not looked for again under the others.

    Args:
        bench: the same runs under the other noise.
        found: the search, in which no more than one effect was added, and nothing taken back.
        progress: told what is being tried.
    """
    if len(found.missing) > 1 or len(found.steps) != len(found.missing) + 1:
        return None
    base = bench.solve(found.base.names, [found.base.fit.theta], found.base.likely.place)
    again = Search(base, base)
    if found.missing:
        again.keep(finished(bench, base, bench.solve(found.final.names, [found.final.fit.theta], found.final.likely.place, COARSE)))
    for old, before in zip(found.steps, (base, again.final), strict=False):
        step = _asked_again(bench, old, before, again.final, progress)
        best = best_of(bench, base, [trial for trial in step.trials if convinces(bench, base, step, trial)])
        step.chosen = None if best is None else best.screened.name
        again.steps.append(step)
    alike = [step.chosen for step in again.steps] == [step.chosen for step in found.steps]
    return again if alike and leaves_noise(bench, again.final, base) else None


def _asked_again(bench: Workbench, old: Step, before: Solved, final: Solved, progress: Callable[[str], None]) -> Step:
    """A round beside the same model under other noise: what was refitted then is fitted on, what was glanced at is glanced at again."""
    trials = [replace(trial) for trial in old.trials]

    def fitted_on(trial: Trial) -> Fit | None:
        names, was = (*before.names, trial.screened.name), trial.solved
        if was is None or names == final.names:
            return None
        if trial.refitted:
            return bench.fitted(names, [was.fit.theta], COARSE)
        return bench.peek(before, trial.screened.name, trial.screened.shape, trial.screened.start).fit

    for trial, found in zip(trials, side_by_side(fitted_on, trials), strict=True):
        if trial.solved is not None:
            names = (*before.names, trial.screened.name)
            taken = bench.taken if trial.refitted else bench.placed
            trial.solved = final if found is None else taken(names, found, before.likely.place)
            trial.evidence = bench.evidence(before, trial.solved)
    refit(bench, before, [trial for trial in worth_a_refit(bench, trials, before) if not trial.refitted], progress)
    trials.sort(key=lambda trial: (not trial.refitted, -trial.evidence))
    return Step(before, trials, old.accept)
