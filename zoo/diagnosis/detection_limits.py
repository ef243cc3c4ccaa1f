"""How large each effect would have to be for these runs to show it.

A limit of detection follows from the columns and the noise alone: the residual has no part in it. What no run at hand can show may still be missing,
and a diagnosis that finds nothing says so with as much confidence as its runs are worth; how much of what is too small to be named the residual
speaks for or against is weighed besides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from zoo.diagnosis.occam import LARGEST, SMALLEST, of_moments, price_of_size, told_apart
from zoo.diagnosis.shape_search import Beside
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.effects.base import Effect
from zoo.effects.bounds import to_physical, to_unit
from zoo.fitting.projection import complement
from zoo.fitting.variable_projection import STEP

SHAPES = 12
"""How many shapes of an effect's grid stand for all of them."""
QUANTILE = 1.2816
"""Standard deviations by which a signal must be above the threshold to be seen with 90 %."""
SIZES = 33
"""How many sizes between them stand for all."""
REFERENCE_S = 10.0
ROUNDS = 6
"""How often the price of a size is looked up at the size it makes necessary."""
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
    level = final.mixtures.white / noise.white
    ten = bench.mixtures.white * math.sqrt(bench.runs[0].average_s / REFERENCE_S)
    amplitudes = ten * torch.logspace(math.log10(SMALLEST), math.log10(LARGEST), SIZES).to(beside.residual)
    found = {}
    for name in names:
        looks, effect = _looks(bench, beside, name), bench.effects[name]
        size, score = looks.size / level, looks.score * level
        whole = [effect.choices(place, len(bench.runs)) for place, one in enumerate(effect.shape) if one.scale == "index" and not one.usual]
        certain = accept + sum(map(math.log, (max(len(names), 1), size.shape[1], *whole)))
        seen = _seen(looks, certain)
        hidden = ((seen * size / (SMALLEST * ten)).log() / math.log(LARGEST / SMALLEST)).clamp(0.0, 1.0)
        odds = _odds(amplitudes / size.unsqueeze(-1), score, seen)
        found[name] = Limit(float((seen * size).median()), float(hidden.mean()), float(odds.mean()))
    return found


def _odds(z: Tensor, score: Tensor, seen: Tensor) -> Tensor:
    """(...) mean likelihood ratio to none over sizes too small to be seen, of either sign, with 0 for those that would be.

    A signal of z standard deviations has the ratio exp(−z²/2) cosh(z·score) (Kay 1998, 4.3). A score beyond what is seen was refused for another
    reason, and counts as that much.

    Args:
        z: (..., A) sizes in standard deviations, of A sizes equally likely.
        score: (...) what the residual has of each, in the same.
        seen: (...) the size that would be seen.
    """
    exponent = torch.minimum(z, seen.unsqueeze(-1)) * torch.minimum(score.abs(), seen).unsqueeze(-1)
    ratio = 0.5 * ((exponent - 0.5 * z.square()).exp() + (-exponent - 0.5 * z.square()).exp())
    return torch.where(z < seen.unsqueeze(-1), ratio, 0.0).mean(dim=-1)


class _Looks(NamedTuple):
    """What the runs see of an effect's columns, of G shapes and K columns that are not empty.

    Attributes:
        size: (G, K) half of peak to peak of each where it is one standard deviation of its own amplitude [unit]; infinite where the model absorbs it.
        score: (G, K) the residual's amplitude in those; 0 where the model absorbs it.
        turned: (G, K, S, S) Gram of its change over the whole range of each parameter, over its own square, with the model and itself left out.
        blocks: (S,) how many blocks the whole range of each passes that is a moment, 0 of what is none.
    """

    size: Tensor
    score: Tensor
    turned: Tensor
    blocks: Tensor


def _looks(bench: Workbench, beside: Beside, name: str) -> _Looks:
    effect = bench.effects[name]
    shapes = bench.shapes(name)
    shapes = shapes[torch.linspace(0, len(shapes) - 1, min(len(shapes), SHAPES)).round().long()]
    plain, steps = _moved(beside, effect, shapes)
    white = beside.whitener(plain)
    outside = complement(white, beside.basis)
    left = outside[0].norm(dim=-2)
    height = 0.5 * (plain[0].amax(dim=-2) - plain[0].amin(dim=-2))
    shown = (height > 0) & (left > ABSORBED * white[0].norm(dim=-2))
    size = torch.where(shown, height / left, torch.inf)
    score = torch.where(shown, torch.einsum("gnk,n->gk", outside[0], beside.residual) / left, 0.0)
    own = torch.where(shown.unsqueeze(-2), outside[0] / left.unsqueeze(-2), 0.0)
    change = torch.where(shown.unsqueeze(-2), (outside[1:] - outside[0]) / steps.unsqueeze(-1).unsqueeze(-1) / left.unsqueeze(-2), 0.0)
    change = change - own * (own * change).sum(dim=-2, keepdim=True)
    turned = torch.einsum("sgnk,tgnk->gkst", change, change)
    filled = (plain[0] != 0).any(dim=-2).any(dim=0)
    filled = filled if bool(filled.any()) else torch.ones_like(filled)
    moving = [one.scale != "index" for one in effect.shape]
    return _Looks(size[:, filled], score[:, filled], turned[:, filled], effect.blocks_of_moments(bench.runs[0].average_s)[moving].to(turned))


def _moved(beside: Beside, effect: Effect, shapes: Tensor) -> tuple[Tensor, Tensor]:
    """(1+S, G, N, K) columns of shapes (G, S), and of each with one parameter that is no whole number moved; (S, G) by how much of its range."""
    unit = to_unit(shapes, effect.shape)
    steps = torch.where(unit > 0.5, -STEP, STEP).mT
    moving = [i for i, one in enumerate(effect.shape) if one.scale != "index"]
    tried = [shapes, *(to_physical(unit + steps[i].unsqueeze(-1) * torch.eye(len(effect.shape))[i].to(unit), effect.shape) for i in moving)]
    columns = beside.design.effect_columns(effect, beside.places, torch.cat(tried), lambda columns: columns)
    return columns.unflatten(0, (len(tried), len(shapes))), steps[moving].to(columns)


def _seen(looks: _Looks, certain: float) -> Tensor:
    """(G, K) sizes in standard deviations that are seen with 90 %: what evidence must reach, and what size and shape cost at the size it is for.

    Args:
        looks: what the runs see of an effect.
        certain: log Bayes factor that is asked for whatever the size.
    """
    z = looks.turned.new_full(looks.turned.shape[:2], math.sqrt(2.0 * certain))
    for _ in range(ROUNDS):
        shape = told_apart(of_moments(looks.turned * z.square().unsqueeze(-1).unsqueeze(-1), looks.blocks))
        z = (2.0 * (certain + price_of_size(1, z.square()) + shape)).clamp_min(0.0).sqrt()
    return z + QUANTILE
