"""How well a run would tell apart explanations that the runs at hand leave open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.diagnosis.experiment.prediction import Predicted
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.effects.repeated import kinds
from zoo.fitting.design import Design
from zoo.fitting.projection import complement, orthonormal, project
from zoo.models.graybox import UNSEEN

STEP = 1e-4
OPEN_CHI2, MOST_PLACES = 30.0, 5
"""How much worse a shape may explain the runs at hand to be looked at, to first order; and at how many of them."""
FREE = 0.5
"""Standard deviation of a nonlinear parameter about its value, between bounds at 0 and 1: further it has nowhere to go."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What one explanation says of a new run.

    Attributes:
        columns: (N, K+P) its columns and tangents, whitened.
        plain: (N, K+P) the same before [unit].
        signal: (N,) what it predicts with its fitted parameters, whitened.
    """

    columns: Tensor
    plain: Tensor
    signal: Tensor


@dataclass(frozen=True)
class Told:
    """How one explanation, were it true, would be told from another.

    Attributes:
        evidence: expected log Bayes factor.
        share: part of the energy of what the true one has and the other has not, which the other cannot reproduce.
    """

    evidence: float
    share: float


@dataclass(frozen=True, eq=False)
class Reduced:
    """One explanation on the runs at hand.

    Attributes:
        triangle: (K+P, K+P) R of its columns and tangents.
        seen: (K+P, R) coordinates Qᵀy of every rival's signal.
        outside: (R,) norm of the rest, which no new run changes.
    """

    triangle: Tensor
    seen: Tensor
    outside: Tensor


class Old:
    """The runs at hand, reduced to what a later fit needs of them: the triangles of their QR decompositions."""

    def __init__(self, rivals: Sequence[Sequence[Solved]]) -> None:
        """Decompose once.

        Args:
            rivals: explanations fitted to the same runs with the same weights; of each the best fit first, then other places to refit it from.
        """
        self.rivals = [list(rival) for rival in rivals]
        self.common = set.intersection(*(set(rival[0].names) for rival in rivals))
        signals = torch.stack([rival[0].fit.columns @ rival[0].fit.amplitudes for rival in rivals], dim=1)
        self.reduced = [[_reduced(one, signals) for one in rival] for rival in rivals]

    @property
    def own_names(self) -> list[str]:
        """Of each rival, the effects that not all of them have, as the catalogue calls them."""
        own = [{name: effect for name, effect in rival[0].model.named_effects() if name not in self.common} for rival in self.rivals]
        return [" + ".join(kinds(one, one)) or "neither" for one in own]

    def own(self, place: int) -> tuple[list[int], list[int]]:
        """Which of a rival's columns and tangents belong to effects that not all of them have, and which do not."""
        model, mine = self.rivals[place][0].model, []
        for name, effect in model.named_effects():
            mine += [name not in self.common] * len(effect.amplitudes)
        mine += [owner != "coil" and owner not in self.common for owner, _ in model.parameters_of_theta()]
        return [i for i, one in enumerate(mine) if one], [i for i, one in enumerate(mine) if not one]


def elsewhere(bench: Workbench, rival: Solved, common: set[str]) -> list[Solved]:
    """The same explanation with its own effect's shape where the runs at hand would allow it as well; none where not one effect is its own."""
    own = [name for name in rival.names if name not in common]
    if len(own) != 1 or not bench.effects[own[0]].shape:
        return []
    before = bench.known(tuple(name for name in rival.names if name not in own)) or bench.without(rival, own[0])
    effect, target = bench.effects[own[0]], complement(before.fit.residual.unsqueeze(1), before.basis).squeeze(1)
    shapes = bench.shapes(own[0]).to(target)
    columns = complement(before.design.effect_columns(effect, before.design.places(before.fit.theta), shapes), before.basis)
    cost = project(columns, target).cost
    order = cost.argsort()
    allowed = [int(place) for place in order[cost[order] < cost.min() + OPEN_CHI2]]
    return [bench.peek(before, own[0], shapes[place]) for place in allowed[:: max(1, len(allowed) // MOST_PLACES)][:MOST_PLACES]]


def answer(rival: Solved, new: Predicted) -> Answer:
    """Columns, tangents and signal of an explanation on a new run."""
    design = Design(rival.model, [new.run], new.whitener, [UNSEEN])
    theta = rival.fit.theta
    steps = torch.where(theta > 0.5, -STEP, STEP)
    batch = design.plain_columns(torch.cat([theta.unsqueeze(0), theta + torch.diag(steps)]))
    signals = batch @ rival.fit.amplitudes
    plain = torch.cat([batch[0], ((signals[1:] - signals[0]) / steps.unsqueeze(1)).mT], dim=1)
    white = new.whitener(torch.cat([plain, signals[0].unsqueeze(1)], dim=1))
    return Answer(white[:, :-1], plain, white[:, -1])


def told_apart(old: Old, answers: Sequence[Sequence[Answer]]) -> dict[tuple[int, int], Told]:
    """For every ordered pair (the truth, the other): what would tell them apart, from the runs at hand and the new one together.

    The other is refitted to the truth's noiseless signal, from each of its places to first order and within the bounds of its nonlinear parameters.
    The χ² that the best of them leaves is twice the expected log Bayes factor, as both have nearly the same number of parameters.
    """
    found = {}
    for other in range(len(answers)):
        left = torch.stack([_left(old, other, place, answers) for place in range(len(answers[other]))]).amin(dim=0)
        for truth in range(len(answers)):
            if truth != other:
                chi2 = float(left[truth])
                found[truth, other] = Told(0.5 * chi2, chi2 / max(energy(old, truth, answers[truth][0]), 1e-300))
    return found


def _left(old: Old, other: int, place: int, answers: Sequence[Sequence[Answer]]) -> Tensor:
    """(R,) χ² of each rival's signal that an explanation cannot reproduce from one of its places, beyond what the runs at hand tell anyway."""
    targets = _targets(old, other, place, answers)
    seen = torch.cat([complement(targets, orthonormal(_stacked(old, other, place, answers))), old.reduced[other][place].outside.unsqueeze(0)])
    return seen.square().sum(dim=0) - old.reduced[other][0].outside.square()


def nearest_place(old: Old, answers: Sequence[Sequence[Answer]], truth: int, other: int) -> int:
    """From which of its places an explanation comes nearest to another one's signal."""
    return min(range(len(answers[other])), key=lambda one: float(_left(old, other, one, answers)[truth]))


def difference(old: Old, answers: Sequence[Sequence[Answer]], truth: int, other: int) -> Tensor:
    """(N,) block means of the new run [unit]: the truth's signal less the other explanation, refitted to it."""
    place = nearest_place(old, answers, truth, other)
    columns, targets = _stacked(old, other, place, answers), _targets(old, other, place, answers)[:, truth]
    norm = columns.norm(dim=0).clamp_min(1e-300)
    weights = (torch.linalg.pinv(columns / norm, rtol=1e-7) @ targets) / norm
    amplitudes = old.rivals[truth][0].fit.amplitudes
    return answers[truth][0].plain[:, : len(amplitudes)] @ amplitudes - answers[other][place].plain @ weights


def _stacked(old: Old, other: int, place: int, answers: Sequence[Sequence[Answer]]) -> Tensor:
    """One explanation's triangle, its columns on the new run, and a row for each nonlinear parameter that holds it."""
    columns, free = answers[other][place].columns, len(old.rivals[other][place].fit.theta)
    hold = torch.eye(columns.shape[1], dtype=columns.dtype, device=columns.device)[columns.shape[1] - free :] / FREE
    return torch.cat([old.reduced[other][place].triangle, columns, hold])


def _targets(old: Old, other: int, place: int, answers: Sequence[Sequence[Answer]]) -> Tensor:
    """What an explanation would have to reproduce: every rival's signal, beside the rows of `_stacked`."""
    signals = torch.stack([rival[0].signal for rival in answers], dim=1)
    return torch.cat([old.reduced[other][place].seen, signals, signals.new_zeros(len(old.rivals[other][place].fit.theta), len(answers))])


def energy(old: Old, truth: int, new: Answer) -> float:
    """χ² of what an explanation's own effects say, with what the common ones could take up left out."""
    own, rest = old.own(truth)
    amplitudes = old.rivals[truth][0].fit.amplitudes
    linear = [i for i in own if i < len(amplitudes)]
    columns = torch.cat([old.reduced[truth][0].triangle, new.columns])
    return float(complement((columns[:, linear] @ amplitudes[linear]).unsqueeze(1), orthonormal(columns[:, rest])).square().sum())


def _reduced(one: Solved, signals: Tensor) -> Reduced:
    basis, triangle = torch.linalg.qr(torch.cat([one.fit.columns, one.fit.tangent], dim=1))
    seen = basis.mT @ signals
    return Reduced(triangle, seen, (signals - basis @ seen).norm(dim=0))
