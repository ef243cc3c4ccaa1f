"""How probable each hypothesis is: nothing missing, each effect, each set that was tried, none of the known."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from zoo.diagnosis.search import Search
from zoo.diagnosis.structure import Structure
from zoo.diagnosis.trials import LITTLE, Step
from zoo.effects.base import Effect
from zoo.effects.repeated import kinds

FAINT = 1e-12

TEMPER = 0.3
"""Share of a log Bayes factor beyond the threshold that is believed: there formulas that are not nature's decide, and no longer chance."""
STEEPNESS = 2.0
"""How fast the odds of an unknown effect rise with the strain, as its power. Both are engineering choices: how far they are from calibrated is what
benchmarks/hidden.py prints."""

REFUSED = 0.5
"""Most that is believed of a further effect that the search did not add, whatever its evidence: of those that might mop up, about half are real."""

SOMETHING, ANOTHER = 3.0, 0.4
"""Odds before looking that a model lacks something rather than nothing, as if nothing, one effect, several, and one of no catalogue were equally
likely; that what was found is not all, once more for each that was found. What the runs cannot show keeps them."""


@dataclass(frozen=True)
class Hypothesis:
    """What the model may lack.

    Attributes:
        effects: sorted; none where the model is complete.
        probability: against all others that were tried, the unknown included.
        faint: whether beside them there is another effect, too small for these runs to show.
    """

    effects: tuple[str, ...]
    probability: float
    faint: bool = False


def believed(excess: Tensor) -> Tensor:
    """Logarithm of the odds over nothing, from the log Bayes factor less what an addition must reach."""
    return torch.where(excess > 0, TEMPER * excess, excess)


def posterior(step: Step) -> dict[str, float]:
    """Probability of each candidate of one round, against each other and against none.

    Before looking, none is as much likelier as the evidence that an addition must reach: a candidate at the threshold gets about one half.
    """
    excess = torch.tensor([0.0, *(trial.evidence - step.needed for trial in step.trials)], dtype=torch.float64)
    weights = torch.softmax(believed(excess), dim=0)[1:]
    return {trial.screened.name: float(weight) for trial, weight in zip(step.trials, weights, strict=True)}


def unknown(structure: Structure) -> float:
    """Probability that something is left which nothing in the catalogue explains, one half where the absolute test is just passed."""
    return 1.0 / (1.0 + math.exp(-STEEPNESS * math.log(max(structure.strain, 1e-6))))


def too_small(known: list[tuple[float, float]], alone: bool) -> float:
    """Mean odds of an effect that is too small to be named.

    Beside those that were named, what speaks for another is believed no more than beyond a threshold: their simplified forms leave it as well.

    Args:
        known: of each effect the probability that it is too small, and its odds after looking, see `zoo.diagnosis.detection_limits`.
        alone: whether nothing was named.
    """
    each = [odds if alone or odds <= hidden else hidden * (odds / hidden) ** TEMPER for hidden, odds in known]
    return sum(each) / max(len(each), 1)


def hypotheses(found: Search, structure: Structure, odds: float, effects: Mapping[str, Effect]) -> list[Hypothesis]:
    """The effects that were found and what differs from them in one, likeliest first; what their probabilities lack to 1 is the unknown's.

    A set's probability is the product of those of its effects, each beside the others, and of nothing more being needed; how often one happens that
    may happen several times makes no other set. What is too small to be named has the odds that looking left it.

    Args:
        found: the search.
        structure: the absolute test of its final model.
        odds: of a missing effect that is too small to be seen against none, if both were as likely before, see `zoo.diagnosis.detection_limits`.
        effects: by the names that the models have for them.
    """
    sets: defaultdict[tuple[str, ...], float] = defaultdict(float)

    def add(names: Iterable[str], weight: float) -> None:
        sets[tuple(sorted(kinds(names, effects)))] += weight

    members = {name: _chances(_round_of(found, name), name) for name in found.missing}
    last = _last(found)
    more = _refused(posterior(last)) if last else {}
    stop = max(1.0 - sum(more.values()), FAINT)
    whole = math.prod(max(chances[name], FAINT) for name, chances in members.items()) * stop
    add(found.missing, whole)
    for name, chances in members.items():
        others = [other for other in found.missing if other != name]
        each = whole / max(chances[name], FAINT)
        add(others, each * max(1.0 - sum(chances.values()), 0.0))
        for other, chance in chances.items():
            if other not in found.missing:
                add([*others, other], each * chance)
    for other, chance in more.items():
        add([*found.missing, other], whole / stop * chance)
    size = len(kinds(found.missing, effects))
    alone = 1.0 / (1.0 + odds * (ANOTHER**size if size else SOMETHING))
    total = sum(sets.values()) / (1.0 - unknown(structure))
    listed = [Hypothesis(names, (alone if len(names) <= size else 1.0) * weight / total) for names, weight in sets.items()]
    faint = [Hypothesis(names, (1.0 - alone) * weight / total, faint=True) for names, weight in sets.items() if len(names) <= size]
    return sorted([*listed, *faint], key=lambda one: -one.probability)


def _chances(step: Step, name: str) -> dict[str, float]:
    """Chances of the candidates of a round; none of them is no choice where one was added for want of noise without it, on little evidence.

    What leaves far more than the one that was added is no rival of it, however well a walk explains the rest.
    """
    own = next(trial for trial in step.trials if trial.screened.name == name)
    most = own.solved.rms / LITTLE if own.solved else math.inf
    rivals = [trial for trial in step.trials if trial.solved is None or trial.solved.rms <= most]
    chances = posterior(replace(step, trials=rivals))
    total = sum(chances.values()) if own.evidence < step.needed else 1.0
    return {one: chance / max(total, FAINT) for one, chance in chances.items()}


def _refused(chances: dict[str, float]) -> dict[str, float]:
    """Chances of effects none of which was added."""
    share = min(1.0, REFUSED / max(sum(chances.values()), FAINT))
    return {name: share * chance for name, chance in chances.items()}


def _round_of(found: Search, name: str) -> Step:
    """The round in which an effect was compared with others last, with the others of the final model beside it where there is one."""
    rounds = [step for step in found.steps if any(trial.screened.name == name for trial in step.trials)]
    beside = [step for step in rounds if {*step.before.names, name} == set(found.final.names)]
    return (beside or rounds)[-1]


def _last(found: Search) -> Step | None:
    """The round that asked for something beside the final model."""
    return next((step for step in reversed(found.steps) if set(step.before.names) == set(found.final.names)), None)
