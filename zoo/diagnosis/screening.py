"""What each candidate could explain of the residual, by projection alone."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

from zoo.diagnosis.workbench import Solved, Workbench
from zoo.effects.base import Effect, History
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
        Candidates, largest gain first.
    """
    places = base.design.histories(base.fit.theta)
    residual = complement(base.fit.residual.unsqueeze(-1), base.basis).squeeze(-1)
    total = float(residual.square().sum())
    found = []
    for name in names:
        effect, shapes = bench.effects[name], bench.shapes(name)
        cost, shape = _best(base, effect, places, shapes, residual)
        near = effect.shapes_near(shape, bench.span_s)
        if len(near) > 1:
            cost, shape = _best(base, effect, places, near, residual)
        found.append(Screened(name, shape, total - cost, len(effect.amplitudes) + len(effect.shape)))
    return sorted(found, key=lambda candidate: -candidate.gain)


def _best(base: Solved, effect: Effect, places: list[dict[str, History]], shapes: Tensor, residual: Tensor) -> tuple[float, Tensor]:
    """χ² that the best of some shapes leaves, and that shape."""
    columns = complement(base.design.effect_columns(effect, places, shapes), base.basis)
    cost, best = project(columns, residual).cost.min(dim=0)
    return float(cost), shapes[best]
