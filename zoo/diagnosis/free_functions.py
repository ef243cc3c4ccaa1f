"""Smooth functions of what a residual may depend on, whatever their physics: what an effect outside the catalogue would have to be like."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from zoo.diagnosis.noise_likelihood import gain, held_cost, with_rows
from zoo.diagnosis.quantities import FLAT, RATE, TEMPERATURE, Quantity, quantities
from zoo.diagnosis.solved import Freed, Solved
from zoo.diagnosis.workbench import Workbench
from zoo.effects.base import Effect, History
from zoo.fitting.projection import project
from zoo.fitting.variable_projection import Fit
from zoo.side_by_side import side_by_side

ORDER, JOINT_DEGREE = 6, 4
SIGNIFICANT = 5.0
"""Log Bayes factor of a free function over none."""
BY_CHANCE = 2.0
"""Standard deviations of χ² that columns may gain without a look at whether another noise would suit them better."""
TOGETHER = "the coil's temperature and its rate together"


@dataclass(frozen=True, eq=False)
class Axis:
    """A quantity over the runs.

    Attributes:
        of: the quantity.
        fine: (T_r,) its samples, one tensor a run.
        means: (N,) its block means.
        low: its smallest sample.
        high: its largest sample.
    """

    of: Quantity
    fine: list[Tensor]
    means: Tensor
    low: float
    high: float

    def chebyshev(self, values: Tensor, order: int) -> Tensor:
        """(M, order) Chebyshev polynomials of order 1 and up of values (M,) scaled to −1…1 over its range."""
        angle = torch.arccos((2 * (values - self.low) / (self.high - self.low) - 1).clamp(-1, 1))
        return torch.stack([torch.cos(k * angle) for k in range(1, order + 1)], dim=-1)


@dataclass(frozen=True, eq=False)
class FreeFunction:
    """A free smooth function of one quantity, or of the coil's temperature and its rate.

    Attributes:
        words: what it depends on.
        axis: the quantity; of the two, the rate.
        beside: the temperature, for the function of two.
        columns: (N, K) block means: means of the function, not the function of means, which differ by the square of what changes within a block.
    """

    words: str
    axis: Axis
    beside: Axis | None
    columns: Tensor

    @property
    def of(self) -> Quantity:
        """The quantity."""
        return self.axis.of

    def at(self, values: Tensor, temperatures: Tensor | None = None) -> Tensor:
        """(M, K) the columns at single values (M,), for the function of two at temperatures (M,) [°C]."""
        return _columns(self.axis, self.beside, values, temperatures)


@dataclass(frozen=True, eq=False)
class WithForm(FreeFunction):
    """A free function of one quantity, and beside it a form of that which no polynomial follows.

    Attributes:
        form: the form as an effect.
        shape: (S,) as it was fitted, physical.
    """

    form: Effect
    shape: Tensor

    def at(self, values: Tensor, temperatures: Tensor | None = None) -> Tensor:
        """(M, K) the columns at single values (M,) of the quantity."""
        history = History(values, values, values, values, values, values, {}, 1)  # whichever of them the form looks at
        return torch.cat([super().at(values, temperatures), self.form.columns(history, self.shape)], dim=1)


def free_functions(bench: Workbench, solved: Solved) -> dict[str, Tensor]:
    """Columns of a free function of each quantity, by what it depends on in words.

    One quantity: Chebyshev polynomials of order 1 to 6. Temperature and rate together: products up to the fourth degree in which the rate is.

    Args:
        bench: the runs.
        solved: the model whose places the quantities are taken at.

    Returns:
        (N, 6) or (N, 10) block means each.
    """
    return {free.words: free.columns for free in functions_of(bench, solved)}


def functions_of(bench: Workbench, solved: Solved) -> list[FreeFunction]:
    """A free function of each quantity that varies, the simplest first, see `free_functions`."""
    places = solved.design.histories(solved.fit.theta)
    axes = {}
    for quantity in quantities(bench):
        fine = [quantity.of(quantity, place[quantity.place]) for place in places]
        low, high = min(float(values.min()) for values in fine), max(float(values.max()) for values in fine)
        if high - low > FLAT:
            means = torch.cat([run.block_mean(values) for run, values in zip(bench.runs, fine, strict=True)])
            axes[quantity] = Axis(quantity, fine, means, low, high)
    pairs: list[tuple[str, Axis, Axis | None]] = [(quantity.words, axis, None) for quantity, axis in axes.items()]
    if TEMPERATURE in axes and RATE in axes:
        pairs.insert(1 + list(axes).index(RATE), (TOGETHER, axes[RATE], axes[TEMPERATURE]))
    return [FreeFunction(words, axis, beside, _means(bench, axis, beside)) for words, axis, beside in pairs]


def _means(bench: Workbench, axis: Axis, beside: Axis | None) -> Tensor:
    """(N, K) block means of the columns."""
    parts = []
    for i, run in enumerate(bench.runs):
        parts.append(run.block_mean_columns(_columns(axis, beside, axis.fine[i], None if beside is None else beside.fine[i])))
    return torch.cat(parts)


def _columns(axis: Axis, beside: Axis | None, values: Tensor, temperatures: Tensor | None) -> Tensor:
    """(M, 6), or for two quantities (M, 10), lower degrees first."""
    if beside is None or temperatures is None:
        return axis.chebyshev(values, ORDER)
    one, other = axis.chebyshev(values, JOINT_DEGREE), beside.chebyshev(temperatures, JOINT_DEGREE - 1)
    other = torch.cat([torch.ones_like(one[:, :1]), other], dim=1)
    return torch.stack([other[:, of_it] * one[:, degree - of_it - 1] for degree in range(1, JOINT_DEGREE + 1) for of_it in range(degree)], dim=1)


def weigh(bench: Workbench, solved: Solved, free: Tensor, beside: Tensor | None = None) -> tuple[float, float]:
    """Share of a model's residual that columns would explain, and the log Bayes factor of having them.

    Args:
        bench: the runs.
        solved: the model; its noise may change with the columns.
        free: (N, K) block means.
        beside: (N, L) further columns that are there already.
    """
    known = solved.fit.plain if beside is None else torch.cat([solved.fit.plain, beside], dim=1)
    before = solved.likelihood if beside is None else solved.likelihood.of(known)
    columns = torch.cat([known, free], dim=1)
    after = before.of(columns)
    gained = after.under(before.likely.place).logarithm - before.likely.logarithm
    if gained > 0.5 * (free.shape[1] + BY_CHANCE * math.sqrt(2.0 * free.shape[1])):
        gained = gain(before, after)
    held = solved.fit.held
    target = solved.design.error.unsqueeze(1)
    left, whole = (held_cost(torch.cat([part, target], dim=1) / bench.mixtures.white, held) for part in (columns, known))
    return 1.0 - left / whole, gained - 0.5 * free.shape[1] * math.log(bench.effective_samples)


def anywhere(bench: Workbench, solved: Solved) -> dict[str, Freed]:
    """What a free function of each quantity is worth, by what it depends on, at whichever coil of a coarse grid suits it best.

    A model that lacks an effect has bent its coil, and a function of the temperature there explains little of what goes with the true one.

    Args:
        bench: the runs.
        solved: the model without it, fitted.
    """
    _, whitener = bench.mixtures.whitener(solved.likely.place)
    target = whitener(solved.design.error.unsqueeze(1))

    def at(theta: Tensor | None) -> tuple[Fit, dict[str, tuple[float, Tensor]]]:
        there = solved if theta is None else bench.moved(solved, theta)
        moved, held, found = there.fit.moved, there.fit.held, {}
        for words, free in free_functions(bench, there).items():
            white = torch.cat([whitener(torch.cat([there.fit.plain, free], dim=1)), target], dim=1)
            found[words] = held_cost(white, held) + moved, free
        return there.fit, found

    def best(words: str) -> Freed:
        # Under the noise that suits it, the coil of least χ² need not be the likeliest.
        least = min(range(len(coils)), key=lambda place: coils[place][1].get(words, (math.inf,))[0])
        tried = dict.fromkeys([least, 0] if words in coils[0][1] else [least])
        return max(worth(bench, solved, coils[place][1][words][1], coils[place][0]) for place in tried)

    coils = side_by_side(at, [None, *(coil.theta for coil in solved.elsewhere.some)])
    every = list(dict.fromkeys(words for _, found in coils for words in found))
    return dict(zip(every, side_by_side(best, every), strict=True))


def freed_of(bench: Workbench, solved: Solved) -> dict[str, Freed]:
    """What a free function of each quantity is worth beside a model, see `anywhere`; reckoned once."""
    if not solved.freed:
        solved.freed.update(anywhere(bench, solved))
    return solved.freed


def worth(bench: Workbench, solved: Solved, free: Tensor, there: Fit | None = None) -> Freed:
    """What further columns are worth beside a model: all of them, or those up to the order that the runs call for.

    A named effect is judged by those of its amplitudes that are called for; what may take its place is judged alike. Else what is proportional to the
    highest temperature is charged for five orders that it has not, and moisture, which bends to it, is not. Each order is half as probable as the one
    below it.

    Args:
        bench: the runs.
        solved: the model.
        free: (N, K) block means.
        there: the model at the coil that they are taken at; by default as it is.
    """
    coil = there or solved.fit
    columns = torch.cat([coil.plain, free], dim=1)
    price, own, further = math.log(bench.effective_samples), coil.plain.shape[1], 0.5 * (coil.moved - solved.fit.moved)
    freed = replace(solved.likelihood.of(columns), held=coil.held)
    likely = freed.likely
    white = bench.mixtures.whitener(likely.place)[1](torch.cat([columns, solved.design.error.unsqueeze(1)], dim=1))
    white = torch.cat([white, with_rows(coil.held, white)]) * (bench.mixtures.white / likely.noise.white)
    costs = [float(project(white[:, :count], white[:, -1]).cost) for count in range(own + 1, white.shape[1])]
    gained = gain(solved.likelihood, freed) - further
    gains = [gained - 0.5 * (cost - costs[-1]) for cost in costs]
    whole = gains[-1] - 0.5 * len(gains) * price
    lower = [Freed(one - order * (0.5 * price + math.log(2.0)), one, whole) for order, one in enumerate(gains, 1)]
    return max(*lower, Freed(whole, gains[-1], whole))
