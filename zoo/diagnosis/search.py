"""Forward and backward until what is left is noise or nothing helps."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace

from zoo.diagnosis.acceptance import ACCEPT, accepted, best_of, chosen_of, pruned
from zoo.diagnosis.reach import out_of_reach
from zoo.diagnosis.screening import Screened, screen
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import leaves_noise
from zoo.diagnosis.trials import OVERWHELMING, REFITS, Step, Trial, glances, refit, round_of
from zoo.diagnosis.workbench import FAR, Workbench, theta_without
from zoo.effects.repeated import by_kind, candidates_beside, kind, kinds

HELPS = 0.3
"""Share of the variance that an addition must take away to be named where the rest stays unexplained (16 % in RMS)."""
MOST_ADDED = 3
PASSES, PAIRED = 3, 3
WITHIN, HIDDEN = 15.0, 0.5
"""How much less evidence than an effect that was added another may have at a glance to be refitted in its place; and what share of it, if the two are
easily confused: it explains little at a coil that the one in its place has bent."""
IN_SIGHT = 2.5
"""RMS over the white noise from which refits of two effects may yet lead to noise."""
PREFERRED = 1.0
"""Log Bayes factor by which another effect must be likelier to take the place of one that was added."""
NEAR = 1.2
"""RMS of a model fitted under the noise that was found, over that under the noise assumed at first, up to which it stands for the runs."""
ALIKE = 1.0
"""χ² between two fits of the same effects that are one."""


@dataclass(eq=False)
class Search:
    """The whole path.

    Attributes:
        base: the model that was asked about, under the noise that evidence is weighed in.
        final: the model with everything that helps.
        steps: rounds in which effects were compared.
        path: every model that was kept, one after the other.
        first: the model that was asked about, under the noise assumed at first, where that is another.
    """

    base: Solved
    final: Solved
    steps: list[Step] = field(default_factory=list)
    path: list[Solved] = field(default_factory=list)
    first: Solved | None = None

    @property
    def as_it_stands(self) -> Solved:
        """The model that was asked about, as the noise that was found weighs the runs; as it fits them best where that is far from them.

        Under white noise alone a fit takes what wanders for its own, with error bars that know nothing of it, and predicts other runs worse; beside a
        walk so large that it hides something slow, the other one leaves that to the walk.
        """
        return self.base if self.first is None or self.base.rms <= NEAR * self.first.rms else self.first

    def keep(self, final: Solved) -> None:
        """Go on from here."""
        self.final = final
        self.path.append(final)

    @property
    def missing(self) -> list[str]:
        """Effects that the final model has and the base has not, in the order they were found."""
        return [name for name in self.final.names if name not in self.base.names]


def never(_: Search) -> bool:
    """A search that goes on to its end."""
    return False


def search(
    bench: Workbench,
    base: Solved,
    candidates: list[str],
    progress: Callable[[str], None] = lambda _: None,
    in_vain: Callable[[Search], bool] = never,
    pairs: bool = True,
) -> Search:
    """Add what helps most, refit, drop what has become superfluous, until nothing helps.

    Args:
        bench: the runs and effects.
        base: the model as it stands.
        candidates: effects that may be added.
        progress: told what is being tried.
        in_vain: whether, as it stands, all will have to be searched again, so that it need not go on.
        pairs: whether two at once are tried as well, where one at a time leads nowhere.
    """
    found = Search(base, base)
    for _ in range(PASSES):
        _forward(bench, found, candidates, progress, in_vain)
        if in_vain(found):
            return found
        far = found.final.rms > FAR * bench.mixtures.white and not leaves_noise(bench, found.final, base)
        if far or not _exchange(bench, found, candidates, progress):
            break
    if not leaves_noise(bench, found.final, base) and not out_of_reach(bench, found.final, base):
        few = len(found.missing) < 2
        if few and single(bench, found):
            _forward(bench, found, candidates, progress)
        elif not by_evidence(bench, found, candidates, progress) and few and pairs:
            pair(bench, found, candidates, progress)
    _drop(bench, found)
    _agree(bench, found)
    # what was asked beside a worse fit of the final model is no answer
    asked = [step for step in found.steps if set(step.before.names) == set(found.final.names)]
    if asked and not same(asked[-1].before, found.final):
        _exchange(bench, found, candidates, progress)
        found.steps.append(_round_beside(bench, found.final, found, candidates, progress))
    return found


def _drop(bench: Workbench, found: Search) -> None:
    """Leave out what beside all the others, as they are in the end, is not called for; what makes noise of the rest is.

    Of three, each pair is looked for once more: with the third beside them they may be where it has put them. Not where that is another time of the
    same, which has moments of its own.
    """
    for name in found.missing:
        if len(found.missing) < 2:
            break
        less = bench.without(found.final, name)
        if len(found.missing) > 2:
            others = by_kind(found.missing, bench.effects)
            less = looked_again(bench, less, [other for one, names in others.items() if name not in names for other in names])
        little = bench.evidence(less, found.final) < ACCEPT
        if little and not (leaves_noise(bench, found.final, found.base) and not leaves_noise(bench, less, found.base)):
            found.keep(less)


def _agree(bench: Workbench, found: Search) -> None:
    """Let each round know the final model where that is one of its candidates: it was reached by way of others, or fitted on since."""
    for name in found.missing:
        less = set(found.final.names) - {name}
        for step in [step for step in found.steps if set(step.before.names) == less]:
            own = next((trial for trial in step.trials if trial.screened.name == name), None)
            evidence = bench.evidence(step.before, found.final)
            if own is not None and evidence > own.evidence:
                own.solved, own.evidence, own.refitted = found.final, evidence, True
                step.sort()


def single(bench: Workbench, found: Search) -> bool:
    """Take another effect of the first round than the one that was chosen, if it leaves noise; whether one did."""
    first = found.steps[0]
    for one in _singles(found):
        if one.solved is None or not one.refitted or one.evidence < first.needed:
            continue
        alone = finished(bench, found.base, one.solved)
        if leaves_noise(bench, alone, found.base):
            first.chosen = one.screened.name
            found.keep(alone)
            return True
    return False


def pair(
    bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None], ask: Callable[[Solved, list[str]], Step] | None = None
) -> None:
    """Two effects at once, where one at a time leads nowhere: each alone may explain too little while the other is missing.

    The likeliest of the first round are each tried with a second one beside them; two are taken if they leave noise.

    Args:
        bench: the runs and effects.
        found: the search so far; its rounds beside one effect are added to it.
        candidates: effects that may be added.
        progress: told what is being tried.
        ask: a round of some candidates beside a model; by default `round_for_a_pair`.
    """
    for one in _singles(found):
        if not one.refitted:
            refit(bench, found.base, [one], progress)
        assert one.solved is not None
        others = candidates_beside(candidates, one.solved.names, bench.effects)
        if not others:
            return
        step = ask(one.solved, others) if ask else round_for_a_pair(bench, one.solved, others, progress)
        found.steps.append(step)
        best = step.trials[0]
        if best.solved is None or not best.refitted or best.evidence < ACCEPT or one.evidence + best.evidence < found.steps[0].needed + step.needed:
            continue
        both = pruned(bench, finished(bench, found.base, best.solved), found.base)
        if len(both.names) == len(best.solved.names) and leaves_noise(bench, both, found.base):
            step.chosen = best.screened.name
            found.keep(both)
            _exchange(bench, found, candidates, progress)
            return


def round_for_a_pair(bench: Workbench, one: Solved, others: list[str], progress: Callable[[str], None]) -> Step:
    """What beside one effect may make noise of the rest; nothing is refitted where that is out of sight."""
    return round_of(bench, one, others, ACCEPT, progress, least=IN_SIGHT * bench.mixtures.white)


def _singles(found: Search) -> list[Trial]:
    """Effects of the first round to try another one beside, which was not done yet: the likeliest, and the one that leaves least; refitted first.

    The latter may be none that is likely: a walk makes noise of two as well as of what one of them leaves.
    """
    tried = {step.before.names for step in found.steps}
    looked_at = [trial for trial in found.steps[0].trials if trial.solved is not None]
    refitted = [trial for trial in looked_at if trial.refitted]
    least = min(refitted, key=lambda trial: trial.solved.rms if trial.solved else math.inf, default=None)
    likely = [trial for trial in looked_at if trial.evidence > (-ACCEPT if trial.refitted else 0.0) or trial is least]
    left = [trial for trial in likely if trial.solved is not None and trial.solved.names not in tried]
    others = [trial for trial in left if trial is not least]
    chosen = others[: PAIRED - 1 if len(others) < len(left) else PAIRED]
    return [trial for trial in left if trial is least or any(trial is one for one in chosen)]


def _forward(
    bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None], in_vain: Callable[[Search], bool] = never
) -> None:
    seen = set[frozenset[str]]()
    while not in_vain(found) and frozenset(found.final.names) not in seen:
        seen.add(frozenset(found.final.names))
        step = _round_beside(bench, found.final, found, candidates, progress)
        found.steps.append(step)
        best = chosen_of(bench, found.base, step)
        if best is None or _as_many_as_may_be(bench, found):
            return
        assert best.solved is not None
        step.chosen = best.screened.name
        found.keep(pruned(bench, finished(bench, found.base, best.solved), found.base))
        if out_of_reach(bench, found.final, found.base):
            return


def _as_many_as_may_be(bench: Workbench, found: Search) -> bool:
    """Whether nothing of another kind may be added."""
    return len(found.missing) >= MOST_ADDED and len(kinds(found.missing, bench.effects)) >= MOST_ADDED


def _round_beside(bench: Workbench, now: Solved, found: Search, candidates: list[str], progress: Callable[[str], None]) -> Step:
    """What else a model may lack."""
    return round_of(bench, now, candidates_beside(candidates, now.names, bench.effects), accepted(found.base, now), progress)


def by_evidence(bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None]) -> bool:
    """The walk once more by evidence alone, as long as that is overwhelming; taken where it leaves noise. Whether it did.

    What predicts other pieces of the runs best may be flexible enough to follow the sum of two, and what happens once predicts none of them. What
    stood for others is dropped when these are there.
    """
    other, seen = Search(found.base, found.base), set[frozenset[str]]()
    while not other.path or not leaves_noise(bench, other.final, found.base):
        if frozenset(other.final.names) in seen or _as_many_as_may_be(bench, other):
            return False
        seen.add(frozenset(other.final.names))
        known = next((step for step in found.steps if same(step.before, other.final)), None)
        step = replace(known, chosen=None) if known else _round_beside(bench, other.final, found, candidates, progress)
        other.steps.append(step)
        best = max((trial for trial in step.trials if trial.refitted), key=lambda trial: trial.evidence, default=None)
        if best is None or best.solved is None or best.evidence < OVERWHELMING:
            return False
        step.chosen = best.screened.name
        here = [one for one in found.path if one.names == best.solved.names]
        other.keep(here[-1] if here else pruned(bench, finished(bench, found.base, best.solved), found.base))
        if len(other.missing) > 1 and not leaves_noise(bench, other.final, found.base):
            other.keep(looked_again(bench, other.final, other.missing[:-1]))
    found.final, found.path[:], found.steps[:] = other.final, other.path, other.steps
    _exchange(bench, found, candidates, progress)
    _forward(bench, found, candidates, progress)
    return True


def same(one: Solved, other: Solved) -> bool:
    """Whether two models have the same effects, fitted about as far."""
    return set(one.names) == set(other.names) and abs(one.fit.total - other.fit.total) < ALIKE


def looked_again(bench: Workbench, solved: Solved, names: list[str]) -> Solved:
    """A model with some of its effects searched for anew, each beside all the others, which alone it may have gone far to follow as well."""
    for name in names:
        again = bench.add(bench.without(solved, name), name)
        solved = again if again.fit.total < solved.fit.total else bench.taken(solved.names, solved.fit, solved.likely.place)
    return solved


def _exchange(bench: Workbench, found: Search, candidates: list[str], progress: Callable[[str], None]) -> bool:
    """Put another effect in the place of each that was added, where that is likelier beside the others; whether anything changed.

    The first that was added was chosen while the second was missing, and may have been bent to make up for both. So what takes its place is fitted
    beside the others as they are now as well.
    """
    changed = False
    for name in found.missing if len(found.missing) > 1 else []:
        less = bench.without(found.final, name)
        own = bench.evidence(less, found.final)
        others = [one for one in candidates if one != kind(name, bench.effects[name])]
        trials = _looked_at(bench, found, less, candidates_beside(others, found.final.names, bench.effects))
        refit(bench, less, in_reach(trials, own, bench.look_alikes(name)), progress, 0, theta_without(found.final, name))
        _remember(bench, found, less, trials)
        mine = Trial(Screened(name, found.final.shape_of(name), 0.0, 0), found.final, own, True)
        step = Step(less, [mine, *trials], ACCEPT, name)
        step.sort()
        found.steps.append(step)
        better = replacement(bench, found.base, step, mine)
        if better is not None and better.solved is not None:
            step.chosen, changed = better.screened.name, True
            found.keep(finished(bench, found.base, better.solved))
    return changed


def in_reach(trials: list[Trial], own: float, alike: Collection[str] = ()) -> list[Trial]:
    """The likeliest that may yet take the place of an effect with some evidence, best first; of some names, those alike, with less."""
    least = {True: min(own - WITHIN, HIDDEN * own), False: own - WITHIN}
    return sorted((trial for trial in trials if trial.evidence > least[trial.screened.name in alike]), key=lambda trial: -trial.evidence)[:REFITS]


def replacement(bench: Workbench, base: Solved, step: Step, own: Trial) -> Trial | None:
    """The likeliest beside all the other effects, where it is to take the place of one that was added.

    Args:
        bench: the runs and effects.
        base: the model before anything was added.
        step: the round beside the others.
        own: in which the effect that was added is this one.
    """
    best = step.trials[0]
    if best.solved is None or best.evidence <= own.evidence + PREFERRED:
        return None
    return best if best_of(bench, base, [best, own]) is best or leaves_noise(bench, best.solved, base) else None


def _looked_at(bench: Workbench, found: Search, before: Solved, names: list[str]) -> list[Trial]:
    """Candidates beside a model: as an earlier round beside the very same one left them, or as they look at a glance."""
    for step in reversed(found.steps):
        known = [replace(trial) for trial in step.trials if trial.screened.name in names]
        if step.before is before and len(known) == len(names):
            return sorted(known, key=lambda trial: -trial.evidence)
    return glances(bench, before, screen(bench, before, names))


def _remember(bench: Workbench, found: Search, less: Solved, trials: list[Trial]) -> None:
    """Let trials beside a model be what they were in an earlier round beside the same effects, where they were fitted further and better."""
    rounds = [step for step in found.steps if set(step.before.names) == set(less.names)]
    for trial in trials:
        names = (*less.names, trial.screened.name)  # in this order, for so its parameters are
        for known in [old.solved for step in rounds for old in step.trials if old.refitted and old.solved is not None and old.solved.names == names]:
            evidence = bench.evidence(less, known)
            if evidence > trial.evidence:
                trial.solved, trial.evidence, trial.refitted = known, evidence, True


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


def finished(bench: Workbench, base: Solved, solved: Solved) -> Solved:
    """A model fitted on, with the shapes of all that was added to the base looked at once more."""
    return bench.finish(solved, tuple(name for name in solved.names if name not in base.names))
