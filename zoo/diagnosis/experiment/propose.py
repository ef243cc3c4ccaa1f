"""Chooses, out of the family, the run that tells rival explanations apart best for its effort."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from zoo.diagnosis.alike import MODEL_ERROR
from zoo.diagnosis.experiment.circumstances import Circumstances, circumstances_of
from zoo.diagnosis.experiment.evidence import Answer, Old, Told, answer, difference, elsewhere, told_apart
from zoo.diagnosis.experiment.family import Candidate, family
from zoo.diagnosis.experiment.prediction import Predicted, predicted
from zoo.diagnosis.experiment.proposal import Proposal
from zoo.diagnosis.experiment.refit import told_by_refit
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.parameters import parameters_of
from zoo.measurements.wrong_unit import NEVER_C, too_hot
from zoo.side_by_side import side_by_side

ENOUGH = 10.0
"""Expected log Bayes factor that settles a question (22 000 : 1)."""
PLENTY = 50.0
"""Beyond this, what a model's simplified form takes away is covered, and more is of no use."""
BEYOND_DOUBT = 500.0
"""A pair with so much evidence to first order needs no refit in full."""
LEAST = 2.0
"""Below this nothing is learnt."""
SAME = 1.2
ALIKE, DISTINCT = 2.0 * MODEL_ERROR, 4.0 * MODEL_ERROR
"""Shares of an effect's energy that another fails to reproduce: up to the one no evidence is promised, for what is left after the run was taken and
the other fitted anew may be half of it, which no formula is exact enough for; from the other on all of it."""
MOST_RIVALS = 6
ALTERNATIVES = 2
LOOKS, REFITS, PAIRS = 8, 3, 2
"""How often a run is weighed again with the rivals' shapes looked for elsewhere; how many runs have pairs refitted in full, and how many pairs."""

Pair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Weighed:
    """One candidate and what it would tell.

    Attributes:
        candidate: the run.
        predicted: what it would record.
        answers: what each rival says of it.
        worth: expected evidence of each pair of rivals, the smaller of both directions, as a share too small counts for less.
        anywhere: whether the rivals' shapes were looked for elsewhere as well.
        refitted: whether the weakest pairs were refitted in full.
    """

    candidate: Candidate
    predicted: Predicted
    answers: list[list[Answer]]
    worth: dict[Pair, float]
    anywhere: bool = False
    refitted: bool = False

    def sum_for(self, pairs: Sequence[Pair]) -> float:
        """Evidence over some pairs, no more of each than is enough."""
        return sum(min(self.worth[pair], ENOUGH) for pair in pairs)

    def tells_more_than(self, other: Weighed) -> bool:
        """Whether any pair is worth more than in another run."""
        return any(worth > SAME * other.worth[pair] and worth >= LEAST for pair, worth in self.worth.items())

    def per_effort(self, pairs: Sequence[Pair]) -> float:
        """Evidence of the worst of some pairs, no more than could be of use, for what the run takes."""
        return min(min(self.worth[pair], PLENTY) for pair in pairs) / self.candidate.effort


def propose(bench: Workbench, rivals: Sequence[Solved]) -> Proposal | None:
    """The next experiment.

    Args:
        bench: the runs at hand.
        rivals: explanations that these leave open, fitted to them, the likeliest first; no more than `MOST_RIVALS` are looked at.

    Returns:
        None where there are fewer than two rivals, where no run of the family would tell any of them apart, or where the temperatures are in another
        unit, most likely: no chamber should go there.
    """
    chosen = list(rivals)[:MOST_RIVALS]
    if len(chosen) < 2 or too_hot(bench.runs, NEVER_C):
        return None
    known, old = circumstances_of(bench.runs), Old([[rival] for rival in chosen])
    weighed = side_by_side(lambda one: weigh(bench, known, old, one), family(known))
    if choose(weighed, len(chosen)) is None:
        return None
    anywhere = Old([[rival, *elsewhere(bench, rival, old.common)] for rival in chosen])
    weighed = _confirmed(bench, known, anywhere, _useful(weighed))
    sure = choose([one for one in weighed if one.refitted], len(chosen))
    return None if sure is None else _proposal(anywhere, sure, weighed)


def _useful(weighed: Sequence[Weighed]) -> list[Weighed]:
    """Without runs that tell no more than the same program does for less."""
    cheap = {one.candidate.legs: one for one in sorted(weighed, key=lambda one: -one.candidate.effort)}
    return [one for one in weighed if cheap[one.candidate.legs] is one or one.tells_more_than(cheap[one.candidate.legs])]


def _confirmed(bench: Workbench, known: Circumstances, anywhere: Old, weighed: list[Weighed]) -> list[Weighed]:
    """The same, the best of them weighed again until one stays the best: with the rivals' shapes anywhere, then refitted in full."""
    looks = refits = 0
    while refits < REFITS:
        best = choose(weighed if looks < LOOKS else [one for one in weighed if one.anywhere], len(anywhere.rivals))
        if best is None or best.refitted:
            break
        if best.anywhere:
            again, refits = refitted(bench, anywhere, best), refits + 1
        else:
            again, looks = replace(weigh(bench, known, anywhere, best.candidate), anywhere=True), looks + 1
        weighed[weighed.index(best)] = again
    return weighed


def refitted(bench: Workbench, old: Old, one: Weighed) -> Weighed:
    """The same with the weakest pairs of those that it separates refitted in full, those of the likeliest explanation first."""
    doubtful = [pair for pair in _told(one.worth) if one.worth[pair] < BEYOND_DOUBT]
    doubtful.sort(key=lambda pair: (pair[0] > 0, one.worth[pair]))
    worth = dict(one.worth)
    ways = [way for pair in doubtful[:PAIRS] for way in (pair, pair[::-1])]
    for way, told in zip(ways, side_by_side(lambda way: told_by_refit(bench, old, one.predicted, one.answers, *way), ways), strict=True):
        pair = min(way), max(way)
        worth[pair] = min(worth[pair], _worth(told))
    return replace(one, worth=worth, refitted=True)


def weigh(bench: Workbench, known: Circumstances, old: Old, candidate: Candidate) -> Weighed:
    """What a candidate would tell."""
    new = predicted(bench.runs, bench.noise, known, candidate)
    answers = [[answer(one, new) for one in rival] for rival in old.rivals]
    told = told_apart(old, answers)
    worth = {(a, b): min(_worth(told[a, b]), _worth(told[b, a])) for a, b in combinations(range(len(answers)), 2)}
    return Weighed(candidate, new, answers, worth)


def _worth(told: Told) -> float:
    """Evidence, of which the formulas' own inaccuracy leaves only so much."""
    return told.evidence * min(1.0, max(0.0, told.share - ALIKE) / (DISTINCT - ALIKE))


def choose(weighed: Sequence[Weighed], rivals: int) -> Weighed | None:
    """The best for its effort of those that tell all pairs apart which any does; else the one that tells most.

    Args:
        weighed: all candidates.
        rivals: how many explanations there are.
    """
    best = {pair: max((one.worth[pair] for one in weighed), default=0.0) for pair in combinations(range(rivals), 2)}
    pairs = _told(best)
    if not pairs:
        return None
    enough = [one for one in weighed if all(one.worth[pair] >= ENOUGH for pair in pairs)]
    if enough:
        return max(enough, key=lambda one: one.per_effort(pairs))
    return max(weighed, key=lambda one: one.sum_for(pairs))


def _told(worth: dict[Pair, float]) -> list[Pair]:
    """The pairs that are told apart for certain; where there is none, those of which something would be learnt."""
    return [pair for pair in worth if worth[pair] >= ENOUGH] or [pair for pair in worth if worth[pair] >= LEAST]


def _proposal(old: Old, best: Weighed, weighed: Sequence[Weighed]) -> Proposal:
    names = old.own_names
    told = _told(best.worth) or [max(best.worth, key=best.worth.__getitem__)]
    evidence = min(best.worth[pair] for pair in told)
    others = sorted((one for one in weighed if one is not best), key=lambda one: (-round(one.sum_for(told), 1), -one.per_effort(told)))
    truth, other = told[0]
    likeliest, true = old.rivals[0][0], old.rivals[truth][0]
    return Proposal(
        candidate=best.candidate,
        separates=tuple(names[place] for place in sorted({place for pair in told for place in pair})),
        remaining=tuple((names[a], names[b]) for a, b in best.worth if (a, b) not in told),
        evidence=evidence,
        predicted=replace(best.predicted, run=best.predicted.run.to("cpu")),
        difference=difference(old, best.answers, truth, other).cpu(),
        compared=(names[truth], names[other]),
        truth=dict(true.model.named_effects()).get(names[truth]),
        fitted=_fitted(true, names[truth]),
        alternatives=tuple((one.candidate, min(one.worth[pair] for pair in told)) for one in others[:ALTERNATIVES]),
        model={name: effect for name, effect in likeliest.model.named_effects() if name in old.common},
        enough=evidence >= ENOUGH,
    )


def _fitted(rival: Solved, name: str) -> dict[str, float]:
    """What one effect comes to beside the others, by parameter; nothing where it is not one effect."""
    return {one: entry["value"] for one, entry in parameters_of(rival.model, rival.fit, "unit").get(name, {}).items()}
