"""Which effects these runs cannot tell apart, from the columns at hand."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.workbench import Solved, Workbench
from zoo.effects.base import History
from zoo.effects.bounds import to_physical, to_unit
from zoo.fitting.projection import complement, orthonormal, project
from zoo.fitting.variable_projection import fit

REFINEMENTS = 10
PROMISING = 0.5
"""Share of a signal's χ² that the best of an effect's grid may leave for a refinement to be worth while."""
INDISTINGUISHABLE = 9.0
"""χ² that a replacement may leave: three sigma for one parameter."""
MODEL_ERROR = 0.005
"""Share of a signal's χ² below which differences are within the accuracy of any effect's formula."""


def indistinguishable(bench: Workbench, base: Solved, more: Solved, candidates: list[str]) -> list[str]:
    """Other effects that reproduce what an added effect explains.

    The added effect's fitted signal is stripped of what the base model can absorb to first order; another effect is indistinguishable if, over its
    grid of shapes, its columns reproduce the rest so well that the remainder could not be seen in this noise.

    Args:
        bench: the runs.
        base: the model before.
        more: the model with one effect added last.
        candidates: effects to compare with.
    """
    name = more.names[-1]
    width, own = len(bench.effects[name].amplitudes), len(bench.effects[name].shape)
    kept = more.fit.tangent[:, : more.fit.tangent.shape[1] - own]
    basis = orthonormal(torch.cat([more.fit.columns[:, :-width], kept], dim=1))  # the base at the coil as refitted with the effect
    signal = complement((more.fit.columns[:, -width:] @ more.fit.amplitudes[-width:]).unsqueeze(-1), basis).squeeze(-1)
    energy = float(signal.square().sum())
    if energy < INDISTINGUISHABLE:
        return []
    places = more.design.histories(more.fit.theta)
    allowed = max(INDISTINGUISHABLE, MODEL_ERROR * energy)
    others = [other for other in candidates if other not in more.names]
    return [other for other in others if _left(bench, more, basis, places, other, signal) < allowed]


def _left(bench: Workbench, more: Solved, basis: Tensor, places: list[dict[str, History]], other: str, signal: Tensor) -> float:
    """χ² of a signal that another effect cannot reproduce, from the best of its grid and refined from there."""
    effect = bench.effects[other]

    def columns(theta: Tensor) -> Tensor:
        return complement(more.design.effect_columns(effect, places, to_physical(theta, effect.shape)), basis)

    grid = to_unit(bench.shapes(other), effect.shape).to(signal)
    least, best = project(columns(grid), signal).cost.min(dim=0)
    if float(least) > PROMISING * float(signal.square().sum()):
        return float(least)
    return fit(columns, signal, grid[best], iterations=REFINEMENTS).cost
