"""Where the fit of a sum of effects should start from: the coil and the shapes out of a grid."""

from __future__ import annotations

from torch import Tensor

from zoo.effects.base import Effect
from zoo.effects.bounds import to_physical, to_unit
from zoo.fitting.design import Design, coarse_starts
from zoo.fitting.projection import complement, orthonormal, project


def first_theta(design: Design) -> Tensor:
    """(P,) in 0…1: effect by effect, the coil and the shape that explain most of what the effects before it leave.

    Args:
        design: the sum on its runs.
    """
    theta = design.model.theta()
    span_s = max(float(run.time[-1] - run.time[0]) for run in design.runs)
    place = _Place(len(design.model.coil_parameters), 0)
    for _, effect in design.model.named_effects():
        if effect.shape:
            theta = _searched(design, coarse_starts(design, theta), effect, effect.shapes_to_try(span_s, len(design.runs)), place)
            found = to_physical(theta[place.shapes(effect)], list(effect.shape))
            theta = _searched(design, theta.unsqueeze(0), effect, effect.shapes_near(found, span_s), place)
        place = place.behind(effect)
    return theta


class _Place:
    """Where an effect's shapes stand in θ, and how many columns stand before its own."""

    def __init__(self, shape: int, column: int) -> None:
        self.shape, self.column = shape, column

    def shapes(self, effect: Effect) -> slice:
        return slice(self.shape, self.shape + len(effect.shape))

    def behind(self, effect: Effect) -> _Place:
        return _Place(self.shape + len(effect.shape), self.column + len(effect.amplitudes))


def _searched(design: Design, starts: Tensor, effect: Effect, shapes: Tensor, place: _Place) -> Tensor:
    """The best of some θ (G, P) with one of some physical shapes (H, S) of an effect in it."""
    lowest, best = float("inf"), starts[0]
    for theta, columns in zip(starts, design.columns(starts), strict=True):
        basis = orthonormal(columns[:, : place.column])
        own = complement(design.effect_columns(effect, design.places(theta), shapes), basis)
        cost, index = project(own, complement(design.target.unsqueeze(-1), basis).squeeze(-1)).cost.min(dim=0)
        if float(cost) < lowest:
            lowest, best = float(cost), theta.clone()
            best[place.shapes(effect)] = to_unit(shapes[index], list(effect.shape)).to(theta)
    return best
