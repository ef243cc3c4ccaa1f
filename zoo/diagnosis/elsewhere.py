"""Where the coil may be instead.

A model that lacks an effect bends its coil to make up for it, and at a bent coil the right effect explains little.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import torch
from torch import Tensor

from zoo.diagnosis.shape_search import Beside, apart, costs, unusual
from zoo.effects.base import Effect
from zoo.effects.bounds import to_unit
from zoo.fitting.design import Design, Places, close_starts, coarse_starts
from zoo.fitting.projection import complement, orthonormal, project

ALLOWED = 20.0
"""χ² that a model may lose at another coil for this to be looked at closely, beside what it leaves over its noise in any case."""


@dataclass(frozen=True, eq=False)
class Coil:
    """A model at other parameters of its coil.

    Attributes:
        theta: (P,) all its parameters.
        basis: (N, R) orthonormal, what its columns explain, whitened.
        residual: (N,) what is left.
        places: see `zoo.fitting.design.Design.places`.
    """

    theta: Tensor
    basis: Tensor
    residual: Tensor
    places: Places


class Elsewhere:
    """A model at other coils, each made once for all effects that are tried there."""

    def __init__(self, design: Design, theta: Tensor) -> None:
        """Keep the model.

        Args:
            design: its columns on the runs.
            theta: (P,) its parameters as they are.
        """
        self.design, self.theta = design, theta

    def look(self, effect: Effect, shapes: Tensor, span_s: float) -> Tensor:
        """(K, P+S) θ with coils and shapes of an effect that are likely together, everything else being as it is, the likeliest first.

        Many shapes are tried at the means of blocks, each at the coil that suits it best; the best one's surroundings then by samples. The next ones
        are of shapes apart from those before them.

        Args:
            effect: to be added.
            shapes: (G, S) physical, to be tried, at a coarse grid of coils; several of a sharp effect at a close one, as far as the model allows it.
            span_s: length of the longest run [s].
        """
        many = len(shapes) > 1
        coils = self._close if many and effect.sharp else self.some if many else self._all
        columns = self.design.effect_columns_at_means if many else partial(self.design.effect_columns, distinct=True)
        price = unusual(effect, shapes).to(self.design.error)
        same = None if effect.place == "coil" else columns(effect, coils[0].places, shapes)

        def costs_at(coil: Coil) -> Tensor:
            tried = columns(effect, coil.places, shapes) if same is None else same
            return costs(tried, coil.basis, coil.residual) + price + self.design.prior.cost(coil.theta)

        least, where = torch.stack([costs_at(coil) for coil in coils]).min(dim=0)
        found = apart(effect, shapes, least, span_s)
        coil, shape = coils[where[found[0]]], shapes[found[0]]
        if many:
            beside = Beside(self.design, coil.places, coil.basis, coil.residual, self.design.whitener, span_s)
            shape = beside.closer(effect, *beside.best(effect, shape.unsqueeze(0)))[1]
        starts = [(coil, shape), *((coils[where[one]], shapes[one]) for one in found[1:])]
        return torch.stack([torch.cat([coil.theta, to_unit(shape, effect.shape).to(coil.theta)]) for coil, shape in starts])

    @cached_property
    def _all(self) -> list[Coil]:
        return self._at(*self._columns(coarse_starts(self.design, self.theta)))

    @cached_property
    def some(self) -> list[Coil]:
        """The places of one colour of a coarse grid, as on a chessboard."""
        return self._at(*self._columns(coarse_starts(self.design, self.theta, thinned=True)))

    @cached_property
    def _close(self) -> list[Coil]:
        """Of a close grid, the coils at which the model is not much worse than where it is, and that one."""
        places, columns = self._columns(torch.cat([self.theta.unsqueeze(0), close_starts(self.design, self.theta)]))
        costs = project(columns, self.design.target).cost
        possible = costs <= costs[0] + ALLOWED + (costs[0] - len(self.design.target)).clamp_min(0.0)
        return self._at(places[possible], columns[possible])

    def _columns(self, places: Tensor) -> tuple[Tensor, Tensor]:
        """θ (G, P) and the columns (G, N, K) there."""
        return places, self.design.forgetful().columns(places)

    def _at(self, thetas: Tensor, columns: Tensor) -> list[Coil]:
        def one(theta: Tensor, own: Tensor, places: Places) -> Coil:
            basis = orthonormal(own)
            residual = complement(self.design.target.unsqueeze(-1), basis).squeeze(-1)
            return Coil(theta, basis, residual, places)

        return [one(*each) for each in zip(thetas, columns, self.design.each_place(thetas), strict=True)]
