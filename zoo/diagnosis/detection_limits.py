"""How large each effect would have to be for these runs to show it.

A limit of detection follows from the columns and the noise alone: the residual has no part in it. What no run at hand can show may still be missing,
and a diagnosis that finds nothing says so with as much confidence as its runs are worth; how much of what is too small to be named the residual
speaks for or against is weighed besides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.diagnosis.shape_search import Beside
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.projection import complement

SHAPES = 12
"""How many shapes of an effect's grid stand for all of them."""
QUANTILE = 1.2816
"""Standard deviations by which a signal must be above the threshold to be seen with 90 %."""
SMALLEST, LARGEST = 0.1, 10.0
"""Sizes that a missing effect may have, every factor as likely as any other [white noise of a mean over 10 s]."""
SIZES = 33
"""How many sizes between them stand for all."""
REFERENCE_S = 10.0
ABSORBED = 1e-6
"""Share of a column outside what the model can absorb below which that is rounding."""


@dataclass(frozen=True)
class Limit:
    """What the runs can show of one effect.

    Attributes:
        size: half of peak to peak over the runs that is seen with 90 %, median over the shapes that the effect may have [unit]; infinite where the
            model absorbs it.
        hidden: probability that an effect of unknown size and shape is too small to be seen.
        odds: the same after looking: mean likelihood ratio to none of what is too small to be seen; near ``hidden`` where the runs cannot tell, less
            where the residual has nothing of the effect.
    """

    size: float
    hidden: float
    odds: float


def detection_limits(bench: Workbench, final: Solved, names: list[str], accept: float) -> dict[str, Limit]:
    """The limit of detection of each effect beside a model: the matched filter's, for signals that the model cannot absorb to first order.

    A column c, whitened by the noise that suits the model best and stripped of all that the model can absorb, is seen when a |c| exceeds the square
    root of twice the log evidence that an addition must reach, by what chance may take away (Kay 1998, Fundamentals of Statistical Signal Processing
    II, 4.3).

    Args:
        bench: the runs and effects.
        final: the model, fitted.
        names: effects that it has not.
        accept: log Bayes factor that one must reach, on top of the logarithm of their number.
    """
    noise, whitener = final.likely.noise, final.mixtures.whitener(final.likely.place)[1]
    beside = Beside.under(final.design, final.fit.theta, final.fit.plain, whitener, bench.span_s)
    per_sigma = final.mixtures.white / noise.white
    ten = bench.mixtures.white * math.sqrt(bench.runs[0].average_s / REFERENCE_S)
    amplitudes = ten * torch.logspace(math.log10(SMALLEST), math.log10(LARGEST), SIZES).to(beside.residual)
    found = {}
    for name in names:
        shapes = bench.shapes(name)
        shapes = shapes[torch.linspace(0, len(shapes) - 1, min(len(shapes), SHAPES)).round().long()]
        freedom = 1 + len(bench.effects[name].shape)
        price = accept + math.log(max(len(names), 1)) + 0.5 * freedom * math.log(bench.effective_samples)
        seen = math.sqrt(2.0 * price) + QUANTILE
        size, score = (one.flatten() for one in _one_sigma(bench, beside, name, shapes))
        size, score = size / per_sigma, score * per_sigma
        hidden = ((seen * size / (SMALLEST * ten)).log() / math.log(LARGEST / SMALLEST)).clamp(0.0, 1.0)
        found[name] = Limit(float((seen * size).median()), float(hidden.mean()), float(_odds(amplitudes / size.unsqueeze(-1), score, seen).mean()))
    return found


def _odds(z: Tensor, score: Tensor, seen: float) -> Tensor:
    """(M,) mean likelihood ratio to none over sizes too small to be seen, of either sign, with 0 for those that would be.

    A signal of z standard deviations has the ratio exp(−z²/2) cosh(z·score) (Kay 1998, 4.3). A score beyond what is seen was refused for another
    reason, and counts as that much.

    Args:
        z: (M, A) sizes in standard deviations, of A sizes equally likely.
        score: (M,) what the residual has of each, in the same.
        seen: the size that would be seen.
    """
    exponent = z.clamp_max(seen) * score.abs().clamp_max(seen).unsqueeze(-1)
    ratio = 0.5 * ((exponent - 0.5 * z.square()).exp() + (-exponent - 0.5 * z.square()).exp())
    return torch.where(z < seen, ratio, 0.0).mean(dim=-1)


def _one_sigma(bench: Workbench, beside: Beside, name: str, shapes: Tensor) -> tuple[Tensor, Tensor]:
    """(G, K) half of peak to peak of each column where it is one standard deviation of its own amplitude [unit]; the residual's amplitude in those.

    The first is infinite and the second 0 where the model absorbs it; without columns that no run has anything of, such as those of a third run where
    there are two.
    """
    effect = bench.effects[name]
    plain = beside.design.effect_columns(effect, beside.places, shapes, lambda columns: columns)
    white = beside.whitener(plain)
    outside = complement(white, beside.basis)
    left = outside.norm(dim=-2)
    height = 0.5 * (plain.amax(dim=-2) - plain.amin(dim=-2))
    shown = (height > 0) & (left > ABSORBED * white.norm(dim=-2))
    size = torch.where(shown, height / left, torch.inf)
    score = torch.where(shown, torch.einsum("gnk,n->gk", outside, beside.residual) / left, 0.0)
    filled = (plain != 0).any(dim=-2).any(dim=0)
    return (size[:, filled], score[:, filled]) if bool(filled.any()) else (size, score)
