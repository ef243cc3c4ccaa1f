"""Takagi–Sugeno fuzzy model of a fibre-optic gyroscope over temperature and rate: J. Chongqing University 33(12), 2010."""

from __future__ import annotations

from itertools import pairwise

import torch
from torch import Tensor

from zoo.papers.study import Claim, Row, Study, in_words, row, spread
from zoo.scoring.comparison import UNCOMPENSATED, WHOLE
from zoo.units import convert

LARGEST, SPREAD = "largest error", "standard deviation"
PRINTED = {
    UNCOMPENSATED: ((11.5764, 4.61936), (11.6008, 4.62689)),
    "line": ((3.4732, 1.7316), (3.5006, 1.7306)),
    "LS-SVM": ((0.9287, 0.1924), (0.9301, 0.1923)),
    "BP": ((0.1335, 0.03121), (0.1764, 0.03565)),
    "T-S fuzzy": ((0.12055, 0.02595), (0.14684, 0.02856)),
}
"""The table [°/s]: largest error and what it calls variance, of the points fitted and of those checked on. What is printed can only be a standard
deviation: of BP and of the fuzzy model it is more than the square of the largest error."""
REMARKS = (
    "The paper prints neither how its LS-SVM and its BP were set nor how far its memberships overlap, and its order of methods depends on that.",
    "An LS-SVM whose γ and widths are chosen by leaving out reaches what noise and thermometer allow, hundreds of times below the printed one.",
    "BP is far above the printed figures after plain gradient descent (rate 0.1, 1000 epochs) and far below them after Levenberg–Marquardt.",
    "Four rules come to the printed figures where the memberships are wider than the clusters, and stay ten times above where they are as wide.",
    "The paper's 648 points are 18 temperatures with 36 rates, where it names 19 temperatures: 648 of the 684 are drawn.",
)
"""What there is to know about the claims."""
SAMPLES = ("fitted", "checked")
CHECKED = SAMPLES.index("checked")
LEVELS_APART_K = 1.0
"""Temperatures of two levels are farther apart, readings at one level closer (the levels are 5 K apart)."""
ORDER = ("line", "LS-SVM", "BP", "T-S fuzzy")
"""The paper's methods, from the one that leaves most."""


def largest(left: Tensor) -> Tensor:
    """(E, N) -> (E,) largest error without its sign."""
    return left.abs().amax(dim=-1)


MEASURES = {LARGEST: largest, SPREAD: spread}


def rows(study: Study) -> list[Row]:
    """The table: both figures of the fitted and of the checked points, method by method."""
    found = []
    for model in study.left:
        printed = PRINTED.get(model)
        for sample, name in enumerate(SAMPLES):
            for place, quantity in enumerate(MEASURES):
                paper = printed[sample][place] if printed else None
                found.append(row(figure(study, model, quantity, sample), quantity, "°/s", WHOLE, name, model, paper))
    return found


def figure(study: Study, model: str, quantity: str, sample: int = CHECKED) -> Tensor:
    """(E,) one figure of what a method leaves [°/s]."""
    unit = study.runs[sample].unit
    return torch.as_tensor(convert(MEASURES[quantity](study.left[model][sample]), unit, "dps"))


def claims(study: Study, floors: list[float]) -> list[Claim]:
    """The order of the methods on the points that were not fitted, and how far the best of the zoo goes below the paper's.

    Args:
        study: with the paper's methods and others.
        floors: RMS that a complete model would leave of each run [output's unit].
    """
    found = [_before(study)]
    for more, less in pairwise(ORDER):
        ratio = figure(study, less, SPREAD) / figure(study, more, SPREAD).median()
        found.append(Claim(f"{less} leaves less than {more}", f"{in_words(ratio, '{:.3g}')} of it", float(ratio.median()) < 1.0))
    best = min(study.methods, key=lambda name: float(figure(study, name, SPREAD).median()))
    for name, called in (("T-S fuzzy", "T-S fuzzy"), (best, "the best method")):
        for quantity, printed in zip(MEASURES, PRINTED["T-S fuzzy"][CHECKED], strict=True):
            value = figure(study, name, quantity)
            value_in_words = f"{name}: {in_words(value, '{:.5f}')} °/s"
            found.append(Claim(f"{called}: {quantity} at most the printed {printed:g} °/s", value_in_words, float(value.median()) <= printed))
    over = study.left[best][CHECKED].square().mean(-1).sqrt() / attainable(study, floors[CHECKED])
    text = "the best method leaves at most 1.1 times what the noises of gyro and thermometer make of the error"
    found.append(Claim(text, f"{best}: {in_words(over, '{:.3f}')}", float(over.median()) <= 1.1))
    return found


def attainable(study: Study, floor: float) -> float:
    """RMS of the checked points that noise alone would leave: the output's, and that of the thermometer times the error's slope at each rate.

    Args:
        study: with soaked points, so that at one level a thermometer varies by its noise only.
        floor: RMS of the output's noise [output's unit].

    Returns:
        In the output's unit.
    """
    blocks = [(run.block_mean(run.temperature), run.block_mean(run.table[:, -1])) for run in study.runs]
    temperature, rate = (torch.cat(parts) for parts in zip(*blocks, strict=True))
    error = torch.cat([left[0] for left in study.left[UNCOMPENSATED]])
    order = temperature.argsort()
    level = torch.empty_like(order)
    level[order] = torch.cat([order[:1] * 0, (temperature[order].diff() > LEVELS_APART_K).long().cumsum(0)])
    noise = temperature - _means(temperature, level)[level]
    variance = noise.square().sum() / (len(noise) - 1 - level.max())
    at = torch.unique(rate, return_inverse=True)[1]
    warmer, more = temperature - _means(temperature, at)[at], error - _means(error, at)[at]
    slope = _means(warmer * more, at) / _means(warmer.square(), at)
    checked = slope[at].split([len(one) for one, _ in blocks])[CHECKED]
    return float((floor**2 + variance * checked.square().mean()).sqrt())


def _means(values: Tensor, group: Tensor) -> Tensor:
    """(G,) of values (N,) by group (N,), numbered from 0."""
    zero = values.new_zeros(int(group.max()) + 1)
    return zero.index_add(0, group, values) / zero.index_add(0, group, torch.ones_like(values))


def _before(study: Study) -> Claim:
    """Whether the gyro before compensation is the paper's."""
    apart = [
        float(figure(study, UNCOMPENSATED, quantity, 0)) / printed for quantity, printed in zip(MEASURES, PRINTED[UNCOMPENSATED][0], strict=True)
    ]
    value = " and ".join(f"{one - 1:+.1%}" for one in apart)
    return Claim("uncompensated, both figures are within 5 % of the printed ones", value, all(abs(one - 1) <= 0.05 for one in apart))
