"""Explanations that a diagnosis leaves open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import torch

from zoo.diagnosis.alike import indistinguishable
from zoo.diagnosis.screening import Screened, screen
from zoo.diagnosis.search import Search, same
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import COARSE, VARIED_REFERENCE, Workbench
from zoo.effects.bounds import to_unit
from zoo.fitting.variable_projection import Fit
from zoo.side_by_side import side_by_side

CLOSE = 5.0
"""Log Bayes factor up to which the second best explanation stays open (150 : 1)."""
OPEN = 15.0
"""Log Bayes factor below which an explanation is out of the question, whatever its columns could reproduce."""


def rivals_of(bench: Workbench, found: Search, twins: Mapping[str, Sequence[str]]) -> list[Solved]:
    """The model that was found, and those that have another effect in the place of one of its own.

    The effect is the first that was found of those that something cannot be told from: what the diagnosis says cannot be, what comes close in
    evidence, and what could not be tried only because the true input was always the same.

    Args:
        bench: the runs.
        found: the path of the diagnosis.
        twins: of each missing effect, those that cannot be told from it.

    Returns:
        The one that was found first, then the likeliest of those that were tried, then of those that were not; empty where nothing is open.
    """
    for name in found.missing:
        names = tuple(other for other in found.final.names if other != name)
        still = [other for other in bench.effects if bench.lacking(other) == [VARIED_REFERENCE] and other not in found.final.names]
        others = [*twins.get(name, ()), *_close(found, name), *(indistinguishable(bench, found.final, name, still) if still else ())]
        open_to = [other for other in dict.fromkeys(others) if other not in found.final.names]
        if open_to:
            before = bench.known(names) or bench.without(found.final, name)
            more = found.final if found.final.names[-1] == name else bench.add(before, name)
            guesses = _guesses(bench, found, before, open_to)
            fits = side_by_side(partial(_in_place_of, bench, before, more), guesses)
            models = [bench.taken((*before.names, guess.name), one, before.likely.place) for guess, one in zip(guesses, fits, strict=True)]
            worth = {id(model): bench.evidence(before, model) for model in models}
            near = [model for model in models if worth[id(model)] > bench.evidence(before, more) - OPEN]
            if not near:
                continue
            return [found.final, *sorted(near, key=lambda model: (model.names[-1] in still, -worth[id(model)]))]
    return []


def _guesses(bench: Workbench, found: Search, before: Solved, names: list[str]) -> list[Screened]:
    """The best guess of each effect beside a model: as it was screened there before, else screened now."""
    known = {trial.screened.name: trial.screened for step in found.steps if same(step.before, before) for trial in step.trials}
    new = [name for name in names if name not in known]
    return [*(known[name] for name in names if name in known), *(screen(bench, before, new) if new else ())]


def _in_place_of(bench: Workbench, before: Solved, more: Solved, guess: Screened) -> Fit:
    """Another effect beside the rest, fitted from the coil as it is without either and as it is with the effect that was found."""
    shape = to_unit(guess.shape, bench.effects[guess.name].shape).to(before.fit.theta)
    starts = [torch.cat([one.fit.theta[: len(before.fit.theta)], shape]) for one in (before, more)]
    return bench.fitted((*before.names, guess.name), starts, COARSE)


def _close(found: Search, name: str) -> list[str]:
    """Candidates of the round that added an effect whose evidence comes close to its own."""
    own = [step for step in found.steps if step.chosen == name]
    for step in [*(step for step in reversed(own) if {*step.before.names, name} == set(found.final.names)), *own][:1]:
        if any(trial.screened.name == name for trial in step.trials):
            best = max(trial.evidence for trial in step.trials if trial.screened.name == name)
            return [trial.screened.name for trial in step.trials if trial.refitted and trial.evidence > best - CLOSE and trial.screened.name != name]
    return []
