"""How probable each hypothesis is: nothing missing, each effect, each set that was tried, none of the known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch

from zoo.diagnosis.search import ACCEPT, Search, Trial
from zoo.diagnosis.structure import Structure
from zoo.diagnosis.workbench import Workbench

TEMPER = 0.3
"""Share of a log Bayes factor that is believed: formulas are not nature's, so that evidence for one against another is part misfit."""
STEEPNESS = 1.5
"""How fast the probability of an unknown effect rises with the logarithm of the strain; both from benchmarks/hidden.py."""


@dataclass(frozen=True)
class Hypothesis:
    """What the model may lack.

    Attributes:
        effects: sorted; none where the model is complete.
        evidence: log Bayes factor over the model as it stands.
        probability: against all others that were tried, the unknown included.
    """

    effects: tuple[str, ...]
    evidence: float
    probability: float


def posterior(trials: list[Trial]) -> dict[str, float]:
    """Probability of each candidate of one round, against each other and against none (softmax of the tempered evidence).

    Before looking, none is as much likelier as the evidence that an addition must reach: a candidate at the threshold gets about one half.
    """
    needed = ACCEPT + math.log(max(len(trials), 1))
    weights = torch.softmax(TEMPER * torch.tensor([needed, *(trial.evidence for trial in trials)], dtype=torch.float64), dim=0)[1:]
    return {trial.screened.name: float(weight) for trial, weight in zip(trials, weights, strict=True)}


def unknown(structure: Structure) -> float:
    """Probability that something is left which nothing in the catalogue explains, one half where the absolute test is just passed."""
    return 1.0 / (1.0 + math.exp(-STEEPNESS * math.log(max(structure.strain, 1e-6))))


def hypotheses(bench: Workbench, found: Search, structure: Structure) -> list[Hypothesis]:
    """Every set of effects that was compared, likeliest first; what their probabilities lack to 1 is the unknown's.

    Each effect in a set costs what an addition must reach.

    Args:
        bench: the runs.
        found: the search.
        structure: the absolute test of its final model.
    """
    sets: dict[tuple[str, ...], float] = {(): 0.0}
    for step in found.steps:
        chain, added = bench.evidence(found.base, step.before), [name for name in step.before.names if name not in found.base.names]
        for trial in step.trials:
            key = tuple(sorted([*added, trial.screened.name]))
            sets[key] = max(sets.get(key, -math.inf), chain + trial.evidence)
    price = ACCEPT + math.log(max((len(step.trials) for step in found.steps), default=1))
    logs = torch.tensor([evidence - price * len(effects) for effects, evidence in sets.items()], dtype=torch.float64)
    shares = (torch.softmax(TEMPER * logs, dim=0) * (1.0 - unknown(structure))).tolist()
    listed = [Hypothesis(effects, evidence, share) for (effects, evidence), share in zip(sets.items(), shares, strict=True)]
    return sorted(listed, key=lambda one: -one.probability)
