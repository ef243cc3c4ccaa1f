"""Where the coil may be instead.

A model that lacks an effect bends its coil to make up for it, and at a bent coil the right effect explains little.
"""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.shape_search import Beside
from zoo.effects.base import Effect
from zoo.effects.bounds import to_unit
from zoo.fitting.design import Design, close_starts, coarse_starts
from zoo.fitting.projection import complement, orthonormal, project

ALLOWED = 20.0
"""χ² that a model may lose at another coil for this to be looked at closely, beside what it leaves over its noise in any case."""


def look_elsewhere(design: Design, theta: Tensor, effect: Effect, shapes: Tensor, span_s: float) -> tuple[float, Tensor]:
    """The coil and the shape of an effect that together explain most, everything else being as it is.

    Args:
        design: the model's columns on the runs.
        theta: (P,) its parameters as they are.
        effect: to be added.
        shapes: (G, S) physical, to be tried, at a coarse grid of coils; several of a sharp effect at a close one, as far as the model allows it.
        span_s: length of the longest run [s].

    Returns:
        χ² that is left, and θ (P+S,).
    """
    closely = effect.sharp and len(shapes) > 1
    places = _possible(design, theta) if closely else coarse_starts(design, theta, thinned=len(shapes) > 1)
    known: Tensor | None = None
    found = []
    for coil, columns in zip(places, design.columns(places), strict=True):
        basis = orthonormal(columns)
        if known is None or effect.place == "coil":
            known = (design.effect_columns_at_means if closely else design.effect_columns)(effect, design.histories(coil), shapes)
        residual = complement(design.target.unsqueeze(-1), basis).squeeze(-1)
        cost, best = project(complement(known, basis), residual).cost.min(dim=0)
        found.append((float(cost), coil, shapes[best], columns))
    least, coil, shape, columns = min(found, key=lambda each: each[0])
    if len(shapes) > 1:
        beside = Beside.whitened(design, coil, columns, span_s)
        least, shape = beside.closer(effect, *beside.best(effect, shape.unsqueeze(0)))
    return least, torch.cat([coil, to_unit(shape, effect.shape).to(coil)])


def _possible(design: Design, theta: Tensor) -> Tensor:
    """(G, P) of a close grid, the coils at which the model is not much worse than where it is, and that one."""
    places = torch.cat([theta.unsqueeze(0), close_starts(design, theta)])
    costs = project(design.columns(places), design.target).cost
    return places[costs <= costs[0] + ALLOWED + (costs[0] - len(design.target)).clamp_min(0.0)]
