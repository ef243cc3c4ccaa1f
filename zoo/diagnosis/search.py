"""Forward and backward until what is left is noise or nothing helps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import torch

from zoo.diagnosis.cross_validation import segment_cost
from zoo.diagnosis.screening import Screened, screen
from zoo.diagnosis.structure import examine
from zoo.diagnosis.workbench import FAR, QUIET, Solved, Workbench
from zoo.scoring.noise import white_level

ACCEPT = 5.0
"""Log Bayes factor that an effect must reach over the model without it, on top of the logarithm of the number of candidates (150 : 1)."""
HOPELESS = -8.0
"""A candidate whose projected evidence is below this is not refitted."""
OVERWHELMING = 40.0
"""Log Bayes factor that needs no further argument."""
MOPPING_UP = 0.03
"""Share of the variance explained so far below which an addition is taken for a correction to it (17 % in amplitude)."""
MINOR = 0.15
"""Share of the evidence of all added effects below which one of them may be a correction to the others."""
MATERIAL = 0.1
"""Share of the variance above the white noise that an addition must take away."""
HELPS = 0.3
"""Share of the variance that an addition must take away to be named where the rest stays unexplained (16 % in RMS)."""
SURE = 3
"""Parameters that a candidate is charged for before anybody knows which of its amplitudes the runs call for."""
GLANCED = 6
"""How many of the best candidates by projection have their evidence computed."""
FAR_BEHIND = 0.2
"""Share of the best evidence at a glance below which a candidate is not refitted, where the best is overwhelming."""
REFITS, LOOKED_FAR = 3, 2
"""How many of the best candidates are refitted, and for how many of these the coil is looked for elsewhere as well."""
MOST_ADDED = 3
PASSES, PAIRED = 3, 2
WITHIN = 15.0
"""How much less evidence than an effect that was added another may have at a glance to be refitted in its place."""
PREFERRED = 1.0
"""Log Bayes factor by which another effect must be likelier to take the place of one that was added."""
QUIETER = 0.75
"""Ratio of white noise left to white noise assumed, below which the search is repeated."""
RECONSIDER, SLOW = 2.0, 0.2
"""Ratio of flicker found to flicker assumed, and share of random walk per √h, above which the search is repeated."""


@dataclass(eq=False)
class Trial:
    """One candidate added to one model.

    Attributes:
        screened: its best guess from projection.
        solved: the model with it, or None where the guess was hopeless.
        evidence: log Bayes factor over the model without it.
        refitted: whether the nonlinear parameters were fitted again.
    """

    screened: Screened
    solved: Solved | None
    evidence: float
    refitted: bool


@dataclass(eq=False)
class Step:
    """One round of the forward search.

    Attributes:
        before: the model at its start.
        trials: all candidates, best first.
        chosen: the effect that was added, or None.
    """

    before: Solved
    trials: list[Trial]
    chosen: str | None = None


@dataclass(eq=False)
class Search:
    """The whole path.

    Attributes:
        base: the model that was asked about.
        final: the model with everything that helps.
        steps: rounds in which effects were compared.
        path: every model that was kept, one after the other.
    """

    base: Solved
    final: Solved
    steps: list[Step] = field(default_factory=list)
    path: list[Solved] = field(default_factory=list)

    def keep(self, final: Solved) -> None:
        """Go on from here."""
        self.final = final
        self.path.append(final)

    @property
    def missing(self) -> list[str]:
        """Effects that the final model has and the base has not, in the order they were found."""
        return [name for name in self.final.names if name not in self.base.names]


def search(bench: Workbench, base: Solved, candidates: list[str], progress: Callable[[str], None] = lambda _: None) -> Search:
    """Add what helps most, refit, drop what has become superfluous, until nothing helps.

    Args:
        bench: the runs and effects.
        base: the model as it stands.
        candidates: effects that may be added.
        progress: told what is being tried.
    """
    found = Search(base, base)
    for _ in range(PASSES):
        _forward(bench, found, candidates, progress)
        if found.final.rms > FAR * bench.mixtures.white or not _exchange(bench, found, candidates, progress):
            break
    if len(found.missing) < 2 and not examine(bench, found.final, base).is_noise:
        _pair(bench, found, candidates, progress)
    return found


def _pair(bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None]) -> None:
    """Two effects at once, where one at a time leads nowhere: each alone may explain too little while the other is missing.

    The likeliest of the first round are each tried with a second one beside them; two are taken if they leave noise.
    """
    for single in _singles(found):
        assert single.solved is not None
        step = _round(bench, single.solved, [name for name in candidates if name not in single.solved.names], progress)
        found.steps.append(step)
        best = step.trials[0]
        price = 2 * (ACCEPT + math.log(max(len(step.trials), 1)))
        if best.solved is None or not best.refitted or best.evidence < ACCEPT or single.evidence + best.evidence < price:
            continue
        both = _prune(bench, _finished(bench, found.base, best.solved), found.base)
        if len(both.names) == len(best.solved.names) and examine(bench, both, found.base).is_noise:
            step.chosen = best.screened.name
            found.keep(both)
            return


def _singles(found: Search) -> list[Trial]:
    """Effects of the first round to try another one beside, which was not done yet."""
    tried = {step.before.names for step in found.steps}
    refitted = [trial for trial in found.steps[0].trials if trial.refitted and trial.solved is not None and trial.evidence > 0]
    return [trial for trial in refitted if trial.solved is not None and trial.solved.names not in tried][:PAIRED]


def _forward(bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None]) -> None:
    while True:
        step = _round(bench, found.final, [name for name in candidates if name not in found.final.names], progress)
        found.steps.append(step)
        best = _best(bench, [trial for trial in step.trials if _convinces(bench, found.base, found.final, trial, len(step.trials))])
        if best is None or len(found.missing) >= MOST_ADDED:
            return
        assert best.solved is not None
        step.chosen = best.screened.name
        found.keep(_prune(bench, _finished(bench, found.base, best.solved), found.base))


def _exchange(bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None]) -> bool:
    """Put another effect in the place of each that was added, where that is likelier beside the others; whether anything changed.

    The first that was added was chosen while the second was missing, and may have been bent to make up for both.
    """
    changed = False
    for name in found.missing if len(found.missing) > 1 else []:
        less = bench.without(found.final, name)
        own = bench.evidence(less, found.final)
        trials = _glances(bench, less, screen(bench, less, [one for one in candidates if one not in found.final.names]))
        for trial in [trial for trial in trials if trial.evidence > own - WITHIN][:REFITS]:
            progress(f"{' + '.join(less.names)} + {trial.screened.name} instead of {name}?")
            _refit(bench, less, trial, far=False)
        mine = Trial(Screened(name, torch.zeros(0), 0.0, 0), found.final, own, True)
        step = Step(less, sorted([mine, *trials], key=lambda trial: (not trial.refitted, -trial.evidence)), name)
        found.steps.append(step)
        best = step.trials[0]
        if best is not mine and best.solved is not None and best.evidence > own + PREFERRED:
            step.chosen, changed = best.screened.name, True
            found.keep(_finished(bench, found.base, best.solved))
    return changed


def what_helps(found: Search) -> Search:
    """The path as far as every addition takes away a large share of what was left: for a residual that nothing in the catalogue makes noise.

    What lowers it a little then is more likely bent to fit something that it is not.
    """
    kept = found.base
    for after in found.path:
        if after.rms**2 > (1.0 - HELPS) * kept.rms**2:
            break
        kept = after
    return replace(found, final=kept)


def settle(
    bench: Workbench, names: tuple[str, ...], candidates: list[str], progress: Callable[[str], None] = lambda _: None
) -> tuple[Workbench, Search]:
    """Search, and once more with fits weighted by the noise that the first search left, where that is another noise than was assumed.

    The white noise was read off differences of the error, which a fast effect enlarges; the residual tells better, and is never less than it.

    Args:
        bench: the runs under the noise assumed at first.
        names: the model as it stands.
        candidates: effects that may be added.
        progress: told what is being tried.
    """
    found = search(bench, bench.solve(names), candidates, progress)
    for _ in range(PASSES):
        left = found.final.residual
        white = min(white_level(list(left.split([run.blocks for run in bench.runs]))), float(left.square().mean().sqrt()))
        if white >= QUIETER * bench.mixtures.white:
            break
        bench = bench.with_white(white)
        found = search(bench, bench.solve(names), candidates, progress)
    likely, assumed = found.final.likely.noise, bench.noise
    as_assumed = likely.walk < SLOW * likely.white and likely.flicker < RECONSIDER * assumed.flicker
    if as_assumed or bench.mixtures.much_walk(likely):
        return bench, found
    again = bench.with_noise(likely)
    second = search(again, again.solve(names), candidates, progress)
    return (bench, found) if second.missing == found.missing else (again, second)


def _round(bench: Workbench, before: Solved, names: list[str], progress: Callable[[str], None]) -> Step:
    trials = _glances(bench, before, screen(bench, before, names))
    for rank, trial in enumerate(_worth_a_refit(trials)):
        progress(f"{' + '.join(before.names)} + {trial.screened.name}?")
        _refit(bench, before, trial, far=rank < LOOKED_FAR)
    trials.sort(key=lambda trial: (not trial.refitted, -trial.evidence))
    return Step(before, trials)


def _refit(bench: Workbench, before: Solved, trial: Trial, far: bool) -> None:
    trial.solved = bench.extend(before, trial.screened.name, trial.screened.shape, far=far)
    trial.evidence, trial.refitted = bench.evidence(before, trial.solved), True


def _finished(bench: Workbench, base: Solved, solved: Solved) -> Solved:
    return bench.finish(solved, tuple(name for name in solved.names if name not in base.names))


def _glances(bench: Workbench, before: Solved, candidates: list[Screened]) -> list[Trial]:
    """The best candidates with nothing nonlinear refitted; others get what projection guesses, and no more than the least of these."""
    guesses = [0.5 * one.gain - 0.5 * min(one.freedom, SURE) * math.log(bench.effective_samples) for one in candidates]
    least = max([HOPELESS, *sorted(guesses, reverse=True)[GLANCED : GLANCED + 1]])
    near = [_glance(bench, before, one) for one, guess in zip(candidates, guesses, strict=True) if guess > least or one is candidates[0]]
    most = min((trial.evidence for trial in near), default=0.0)
    known = {trial.screened.name: trial for trial in near}
    return [known.get(one.name) or Trial(one, None, min(guess, most), False) for one, guess in zip(candidates, guesses, strict=True)]


def _glance(bench: Workbench, before: Solved, candidate: Screened) -> Trial:
    solved = bench.peek(before, candidate.name, candidate.shape)
    return Trial(candidate, solved, bench.evidence(before, solved), False)


def _worth_a_refit(trials: list[Trial]) -> list[Trial]:
    """The candidates with the largest evidence at a glance that are not far behind the first, and the one with the largest gain: a bent coil may hide
    either."""
    hopeful = [trial for trial in trials if trial.solved is not None]
    best = sorted(hopeful, key=lambda trial: -trial.evidence)[:REFITS]
    near = [trial for trial in best if trial.evidence > FAR_BEHIND * best[0].evidence or best[0].evidence < OVERWHELMING]
    return near + [trial for trial in hopeful[:1] if trial not in near]


def _convinces(bench: Workbench, base: Solved, before: Solved, best: Trial, candidates: int) -> bool:
    """Whether an addition is worth it: strong evidence, more than a correction, and a visible gain with lower error on pieces that were not fitted.

    Where it leaves noise, evidence is enough: what happens once in a run, such as a warm-up, no other piece of it predicts.
    """
    if best.solved is None or not best.refitted or best.evidence < ACCEPT + math.log(max(candidates, 1)):
        return False
    if before.rms < QUIET * bench.mixtures.white:
        return False
    if _mops_up(bench, base, before, best):
        return False
    if best.solved.rms >= before.rms:
        return False
    if _material(bench, before, best.solved) and segment_cost(bench, best.solved) < segment_cost(bench, before):
        return True
    return examine(bench, best.solved, base).is_noise


def _material(bench: Workbench, before: Solved, after: Solved) -> bool:
    """Whether an addition takes away a fair part of what is more than white noise; a little of much is hardly what is missing."""
    return before.rms**2 - after.rms**2 >= MATERIAL * max(before.rms**2 - bench.mixtures.white**2, 0.0)


def _best(bench: Workbench, convincing: list[Trial]) -> Trial | None:
    """The one with the strongest evidence; where that leaves much, the one that predicts pieces best which were not fitted.

    Likelihoods compare models of which one is true up to noise. While something else is missing as well, a flexible effect wins by bending to it.
    """
    if not convincing or convincing[0].solved is None:
        return None
    if convincing[0].solved.rms <= FAR * bench.mixtures.white:
        return convincing[0]
    return min(convincing, key=lambda trial: segment_cost(bench, trial.solved) if trial.solved else math.inf)


def _mops_up(bench: Workbench, base: Solved, before: Solved, addition: Trial) -> bool:
    """Whether an addition may be making up for the simplified form of those before it.

    That is where it explains little beside them, or where they left noise and it adds little to the evidence.
    """
    assert addition.solved is not None
    explained, more = base.rms**2 - before.rms**2, before.rms**2 - addition.solved.rms**2
    if explained <= 0:
        return False
    little = addition.evidence < OVERWHELMING and more < MOPPING_UP * explained
    return little or (addition.evidence < MINOR * bench.evidence(base, before) and examine(bench, before, base).is_noise)


def _prune(bench: Workbench, full: Solved, base: Solved) -> Solved:
    """Drop added effects, all but the newest, that the model no longer needs.

    One that adds a little to the evidence is needed only where there would be more than noise without it: else it makes up for the simplified form
    of another.
    """
    for name in [other for other in full.names[:-1] if other not in base.names]:
        less = bench.without(full, name)
        own = bench.evidence(less, full)
        if own < ACCEPT or (own < MINOR * bench.evidence(base, full) and examine(bench, less, base).is_noise):
            full = less
    return full
