"""Where in the space of its shapes an effect explains most: its grid, then ever closer around the best."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.effects.base import Effect, History
from zoo.effects.bounds import to_unit
from zoo.fitting.design import Design
from zoo.fitting.projection import complement, orthonormal, project
from zoo.scoring.noise import Whitener

STAGES = 3
"""How often at most the surroundings of the best shape are looked through."""
UNUSUAL, HALF = 6.0, 0.5
"""χ² by which another than the usual value must be better: what a parameter costs with some four hundred independent samples."""
RIVAL = 0.4
"""Share of the best shape's gain that another, apart from it, must have to be looked at as closely: what a line shows of its power midway between
two frequencies of a grid. Means over blocks show a line and its image below their length at one frequency, and the grid meets one of them closer."""
STEPS_APART, SHARE_APART = 1.5, 0.15
"""Steps of the grid, or the share of a range where that is less, by which shapes are apart where the effect does not say what is near."""
FITS = 3
"""How many shapes that are apart a fit starts from: what explains most on a grid often lies in another valley than the best of all."""
MANY = 50
"""Shapes above which the columns of an effect without memory are computed at the means of each block, in single precision, to find the best."""


@dataclass(frozen=True, eq=False)
class Beside:
    """What an effect is tried beside.

    Attributes:
        design: the runs.
        places: histories at one coil.
        basis: (N, R) orthonormal, what is explained already.
        residual: (N,) what is left.
        whitener: by which both were whitened.
        span_s: length of the longest run [s].
    """

    design: Design
    places: list[dict[str, History]]
    basis: Tensor
    residual: Tensor
    whitener: Whitener
    span_s: float

    @classmethod
    def whitened(cls, design: Design, theta: Tensor, columns: Tensor, span_s: float) -> Beside:
        """Beside some columns (N, K) that the design whitened, at one θ (P,)."""
        basis = orthonormal(columns)
        return cls(design, design.places(theta), basis, complement(design.target.unsqueeze(-1), basis).squeeze(-1), design.whitener, span_s)

    @classmethod
    def under(cls, design: Design, theta: Tensor, columns: Tensor, whitener: Whitener, span_s: float) -> Beside:
        """Beside some columns (N, K), not whitened yet, under another noise."""
        basis, target = orthonormal(whitener(columns)), whitener(design.error.unsqueeze(-1))
        return cls(design, design.places(theta), basis, complement(target, basis).squeeze(-1), whitener, span_s)

    def best(self, effect: Effect, shapes: Tensor) -> tuple[float, Tensor]:
        """χ² that the best of some shapes (G, S) leaves, with what an unusual one costs, and that shape (S,)."""
        if effect.instant and len(shapes) > MANY:
            shapes = shapes[self._at_means(effect, shapes).argmin()].unsqueeze(0)
        columns = self.design.effect_columns(effect, self.places, shapes, self.whitener, distinct=True)
        cost, best = self._costs(effect, shapes, columns).min(dim=0)
        return float(cost), shapes[best]

    def _at_means(self, effect: Effect, shapes: Tensor) -> Tensor:
        """(G,) χ² of many shapes (G, S), of columns computed at the means of each block."""
        return self._costs(effect, shapes, self.design.effect_columns_at_means(effect, self.places, shapes, self.whitener))

    def _costs(self, effect: Effect, shapes: Tensor, columns: Tensor) -> Tensor:
        """(G,) of shapes (G, S) with columns (G, N, K), where the shapes are."""
        return costs(columns, self.basis, self.residual).to(shapes.device) + unusual(effect, shapes)

    def closer(self, effect: Effect, cost: float, shape: Tensor) -> tuple[float, Tensor]:
        """The same from the surroundings of a shape, as long as that helps."""
        for _ in range(STAGES):
            near = effect.shapes_near(shape, self.span_s)
            if len(near) < 2:
                break
            found, where = self.best(effect, near)
            if found >= cost - 1e-6 * abs(cost):
                break
            cost, shape = found, where
        return cost, shape

    def searched(self, effect: Effect, shapes: Tensor) -> tuple[float, Tensor]:
        """The best of some shapes, and closer; of many also from the best that is apart from it."""
        return min((self.closer(effect, *self.best(effect, one)) for one in self._starts(effect, shapes)), key=lambda found: found[0])

    def _starts(self, effect: Effect, shapes: Tensor) -> list[Tensor]:
        """Shapes (G, S) from whose best to go closer."""
        if not effect.instant or len(shapes) <= MANY:
            return [shapes]
        costs = self._at_means(effect, shapes)
        least, first = costs.min(dim=0)
        costs[alike(effect, shapes, shapes[first], self.span_s)] = torch.inf
        second, gain = costs.argmin(), float(self.residual.square().sum() - least)
        rival = float(costs[second]) <= float(least) + (1 - RIVAL) * gain
        return [shapes[one].unsqueeze(0) for one in ((first, second) if rival else (first,))]


def says_what_is_near(effect: Effect) -> bool:
    """Whether it has surroundings of its own for a shape, see `Effect.shapes_near`."""
    return type(effect).shapes_near is not Effect.shapes_near


def has_options(effect: Effect) -> bool:
    """Whether one of its shapes is an option, 0 or 1, that nearly all gyros have alike."""
    return any(one.usual and (one.low, one.high) == (0.0, 1.0) for one in effect.shape)


def alike(effect: Effect, shapes: Tensor, shape: Tensor, span_s: float) -> Tensor:
    """(G,) bool: which of some shapes (G, S) are near another (S,), as the effect has it, or else on its grid."""
    if says_what_is_near(effect):
        near = effect.shapes_near(shape, span_s)
        return ((shapes >= near.amin(0)) & (shapes <= near.amax(0))).all(-1)
    most = torch.tensor([min(STEPS_APART / one.grid, SHARE_APART) for one in effect.shape]).to(shapes)
    return ((to_unit(shapes, effect.shape) - to_unit(shape, effect.shape)).abs() < most).all(-1)


def apart(effect: Effect, shapes: Tensor, costs: Tensor, span_s: float) -> list[int]:
    """Places of the cheapest of some shapes (G, S), no two of them near each other.

    One is enough of an effect that has no shape, or that says itself what is near.
    """
    most = 1 if says_what_is_near(effect) or not effect.shape else FITS
    costs, found = costs.clone(), list[int]()
    while len(found) < most and not (found and bool(costs.isinf().all())):
        found.append(int(costs.argmin()))
        costs[alike(effect, shapes, shapes[found[-1]], span_s)] = torch.inf
    return found


def unusual(effect: Effect, shapes: Tensor) -> Tensor:
    """(G,) what shapes (G, S) cost in χ² whose whole numbers are others than nearly every gyro's."""
    usual = [(shapes[:, i] - one.default).abs() >= HALF for i, one in enumerate(effect.shape) if one.usual]
    return UNUSUAL * torch.stack(usual).sum(0) if usual else shapes.new_zeros(len(shapes))


def costs(columns: Tensor, basis: Tensor, residual: Tensor) -> Tensor:
    """(G,) χ² that column sets leave of a residual beside what is explained already; all whitened.

    Args:
        columns: (G, N, K), in the precision that is wanted.
        basis: (N, R) orthonormal.
        residual: (N,) outside of it.
    """
    left = complement(columns, basis.to(columns.dtype))
    return project(left, residual.to(columns.dtype)).cost.nan_to_num(torch.inf)
