"""Which effects these runs cannot tell apart, from the columns at hand."""

from __future__ import annotations

from zoo.diagnosis.workbench import Solved, Workbench
from zoo.fitting.projection import complement, project

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
    width = len(bench.effects[name].amplitudes)
    signal = more.fit.columns[:, -width:] @ more.fit.amplitudes[-width:]
    signal = complement(signal.unsqueeze(-1), base.basis).squeeze(-1)
    energy = float(signal.square().sum())
    if energy < INDISTINGUISHABLE:
        return []
    places = base.design.histories(base.fit.theta)
    alike = []
    for other in candidates:
        if other == name or other in more.names:
            continue
        columns = complement(base.design.effect_columns(bench.effects[other], places, bench.shapes(other)), base.basis)
        left = float(project(columns, signal).cost.min())
        if left < max(INDISTINGUISHABLE, MODEL_ERROR * energy):
            alike.append(other)
    return alike
