"""One round: every candidate tried beside one model."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from torch import Tensor

from zoo.diagnosis.screening import Screened, screen
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Guess, Workbench
from zoo.fitting.variable_projection import Fit
from zoo.side_by_side import side_by_side

HOPELESS = -4.5
"""A candidate whose projected evidence is below this is not refitted."""
OVERWHELMING = 40.0
"""Log Bayes factor that needs no further argument."""
AT_REST, WANTED = 1.1, -2.5
"""RMS of a model over the white noise up to which a refit changes evidence by little, and evidence at a glance from which one may matter there."""
SURE = 2
"""Parameters that a candidate is charged for before anybody knows which of its amplitudes the runs call for."""
GLANCED = 6
"""How many of the best candidates by projection have their evidence computed."""
FAR_BEHIND = 0.2
"""Share of the best evidence at a glance below which a candidate is not refitted, where the best is overwhelming."""
LITTLE = 0.5
"""Share of an RMS that a candidate must leave at a glance at most to be refitted for that."""
REFITS, LOOKED_FAR = 3, 2
"""How many of the best candidates are refitted, and for how many of these the coil is looked for elsewhere as well."""


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

    @property
    def guess(self) -> Guess:
        """Where to fit it from."""
        one = self.screened
        if self.refitted and self.solved is not None:
            return Guess(one.name, self.solved.shape_of(one.name), self.solved.fit.theta)
        return Guess(one.name, one.shape, one.start, one.looked)


@dataclass(eq=False)
class Step:
    """One round of the forward search.

    Attributes:
        before: the model at its start.
        trials: all candidates, best first.
        accept: log Bayes factor that one of them must reach, on top of the logarithm of their number.
        chosen: the effect that was added, or None.
    """

    before: Solved
    trials: list[Trial]
    accept: float
    chosen: str | None = None

    @property
    def needed(self) -> float:
        """Log Bayes factor that one of them must reach."""
        return self.accept + math.log(max(len(self.trials), 1))

    def sort(self) -> None:
        """Put the likeliest first, those that were refitted before the others."""
        self.trials.sort(key=lambda trial: (not trial.refitted, -trial.evidence))


def round_of(bench: Workbench, before: Solved, names: list[str], accept: float, progress: Callable[[str], None], least: float = math.inf) -> Step:
    """The candidates of a list beside a model: all projected, the best looked at, the best of these refitted.

    Args:
        bench: the runs and effects.
        before: the model.
        names: candidates.
        accept: see `Step`.
        progress: told what is being tried.
        least: RMS that one of them must reach at a glance for any to be refitted [unit].
    """
    step = Step(before, glances(bench, before, screen(bench, before, names)), accept)
    refit_best(bench, step, progress, least)
    return step


def refit_best(bench: Workbench, step: Step, progress: Callable[[str], None], least: float = math.inf) -> None:
    """Refit those trials of a round that are worth it and were not refitted yet, and put the best first; the arguments are those of `round_of`."""
    reached = min((trial.solved.rms for trial in step.trials if trial.solved is not None), default=0.0)
    worthy = worth_a_refit(bench, step.trials, step.before) if reached <= least else []
    refit(bench, step.before, [trial for trial in worthy if not trial.refitted], progress)
    step.sort()


def refit(
    bench: Workbench, before: Solved, trials: list[Trial], progress: Callable[[str], None], far: int = LOOKED_FAR, others: Tensor | None = None
) -> None:
    """Fit the nonlinear parameters of some trials.

    Args:
        bench: the runs and effects.
        before: the model.
        trials: additions to it; one that was refitted before is fitted on.
        progress: told what is being tried.
        far: of so many of them the shape is looked for at other places of the coil as well.
        others: θ (P,) of the model where it may be as well, see `zoo.diagnosis.workbench.Guess`.
    """

    if trials:
        progress(f"{' + '.join(before.names)} + {' or '.join(trial.screened.name for trial in trials)}?")
    guesses = [replace(trial.guess, far=rank < far, others=others) for rank, trial in enumerate(trials)]
    for trial, found in zip(trials, bench.extended(before, guesses), strict=True):
        trial.solved = bench.taken((*before.names, trial.screened.name), found, before.likely.place)
        trial.evidence, trial.refitted = bench.evidence(before, trial.solved), True


def glances(bench: Workbench, before: Solved, candidates: list[Screened]) -> list[Trial]:
    """The best candidates with nothing nonlinear refitted; others get what projection guesses, and no more than the least of these.

    Beside a walk, which makes little of whatever is slow, that tells too little: there all are looked at, unless one is overwhelming, for one may
    leave no walk.
    """
    guesses = [0.5 * one.gain - 0.5 * min(one.freedom, SURE) * math.log(bench.effective_samples) for one in candidates]
    least = max([HOPELESS, *sorted(guesses, reverse=True)[GLANCED : GLANCED + 1]])
    walks = bench.mixtures.much_walk(before.likely.noise) and max(guesses, default=0.0) < OVERWHELMING
    hopeful = [one for one, guess in zip(candidates, guesses, strict=True) if walks or guess > least or one is candidates[0]]

    def glance(one: Screened) -> tuple[Fit, float]:
        solved = bench.peek(before, one.name, one.shape, one.start)
        return solved.fit, bench.evidence(before, solved)

    near = []
    for one, (found, evidence) in zip(hopeful, side_by_side(glance, hopeful), strict=True):
        near.append(Trial(one, bench.placed((*before.names, one.name), found, before.likely.place), evidence, False))
    most = min((trial.evidence for trial in near), default=0.0)
    known = {trial.screened.name: trial for trial in near}
    return [known.get(one.name) or Trial(one, None, min(guess, most), False) for one, guess in zip(candidates, guesses, strict=True)]


def worth_a_refit(bench: Workbench, trials: list[Trial], before: Solved) -> list[Trial]:
    """The candidates with the largest evidence at a glance that are not far behind the first, and the one with the largest gain: a bent coil may hide
    either. And the one that leaves least, where that is little of what there was: before it a walk had taken that over. Beside what is noise already,
    those for which a glance has more than nothing."""
    hopeful = [trial for trial in trials if trial.solved is not None]
    if before.rms < AT_REST * bench.mixtures.white:
        hopeful = [trial for trial in hopeful if trial.evidence > WANTED]
    if not hopeful:
        return []
    best = sorted(hopeful, key=lambda trial: -trial.evidence)[:REFITS]
    near = [trial for trial in best if trial.evidence > FAR_BEHIND * best[0].evidence or best[0].evidence < OVERWHELMING]
    least = min(hopeful, key=lambda trial: trial.solved.rms if trial.solved else math.inf, default=None)
    quiet = [least] if least and least.solved and least.solved.rms < LITTLE * before.rms else []
    return list(dict.fromkeys([*near, *hopeful[:1], *quiet]))
