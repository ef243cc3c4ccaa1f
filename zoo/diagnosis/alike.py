"""Which effects these runs cannot tell apart, from the columns at hand."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.shape_search import Beside
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.effects.bounds import to_physical, to_unit
from zoo.fitting.projection import complement, orthonormal, project
from zoo.fitting.variable_projection import fit
from zoo.side_by_side import side_by_side

REFINEMENTS = 10
PROMISING = 0.5
"""Share of a signal's χ² that the best of an effect's grid may leave for a refinement to be worth while."""
INDISTINGUISHABLE = 9.0
"""χ² that a replacement may leave: three sigma for one parameter."""
MODEL_ERROR = 0.005
"""Share of a signal's χ² below which differences are within the accuracy of any effect's formula."""


def indistinguishable(bench: Workbench, more: Solved, name: str, candidates: list[str]) -> list[str]:
    """Other effects that reproduce what one effect of a model explains.

    The effect's fitted signal is stripped of what the rest of the model can absorb to first order; another effect is indistinguishable if, over its
    grid of shapes, its columns reproduce the rest so well that the remainder could not be seen in this noise.

    Args:
        bench: the runs.
        more: a model with the effect.
        name: the effect.
        candidates: effects to compare with.
    """
    own = more.places()[name]
    rest = [i for i in range(more.fit.columns.shape[1]) if i not in own]
    owners = [owner for owner, _ in more.model.parameters_of_theta()]
    kept = more.fit.tangent[:, [i for i, owner in enumerate(owners) if owner != name]]
    basis = orthonormal(torch.cat([more.fit.columns[:, rest], kept], dim=1))  # the rest at the coil as refitted with the effect
    signal = complement((more.fit.columns[:, own] @ more.fit.amplitudes[own]).unsqueeze(-1), basis).squeeze(-1)
    energy = float(signal.square().sum())
    if energy < INDISTINGUISHABLE:
        return []
    beside = Beside(more.design, more.design.places(more.fit.theta), basis, signal, bench.whitener, bench.span_s)
    allowed = max(INDISTINGUISHABLE, MODEL_ERROR * energy)
    others = [other for other in candidates if other not in more.names]
    left = side_by_side(lambda other: _left(bench, beside, other, allowed), others)
    return [other for other, cost in zip(others, left, strict=True) if cost < allowed]


def _left(bench: Workbench, beside: Beside, other: str, allowed: float) -> float:
    """χ² of a signal that another effect cannot reproduce, from the best of its shapes and refined from there.

    All of it, where what leaves no more than is allowed are amplitudes that make no effect by themselves.
    """
    effect = bench.effects[other]

    def columns(theta: Tensor) -> Tensor:
        found = beside.design.effect_columns(effect, beside.places, to_physical(theta, effect.shape), beside.whitener)
        return complement(found, beside.basis)

    least, shape = beside.searched(effect, bench.shapes(other))
    spare = [place for place, one in enumerate(effect.amplitudes) if one.spare]
    if spare and least < allowed and float(project(columns(to_unit(shape, effect.shape).unsqueeze(0))[..., spare], beside.residual).cost) < allowed:
        return float(beside.residual.square().sum())
    if least > PROMISING * float(beside.residual.square().sum()):
        return least
    return min(least, fit(columns, beside.residual, to_unit(shape, effect.shape).to(beside.residual), iterations=REFINEMENTS).cost)
