"""What each candidate could explain of the residual, by projection alone."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

from zoo.diagnosis.workbench import Solved, Workbench
from zoo.fitting.projection import complement, project


@dataclass(frozen=True, eq=False)
class Screened:
    """A candidate's best guess before any refit.

    Attributes:
        name: the effect.
        shape: (S,) physical shape that explains most.
        gain: drop of χ² that its columns give, with everything the model can absorb to first order taken out of them.
        freedom: parameters it would add.
    """

    name: str
    shape: Tensor
    gain: float
    freedom: int


def screen(bench: Workbench, base: Solved, names: list[str]) -> list[Screened]:
    """Project the residual on each candidate's columns over its grid of shapes.

    Args:
        bench: the runs and effects.
        base: the model as it stands.
        names: candidates.

    Returns:
        Candidates, largest gain per added parameter first.
    """
    places = base.design.histories(base.fit.theta)
    residual = complement(base.fit.residual.unsqueeze(-1), base.basis).squeeze(-1)
    total = float(residual.square().sum())
    found = []
    for name in names:
        effect, shapes = bench.effects[name], bench.shapes(name)
        columns = complement(base.design.effect_columns(effect, places, shapes), base.basis)
        costs = project(columns, residual).cost
        best = int(costs.argmin())
        found.append(Screened(name, shapes[best], total - float(costs[best]), len(effect.amplitudes) + len(effect.shape)))
    return sorted(found, key=lambda candidate: -candidate.gain)
