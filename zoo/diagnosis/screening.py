"""What each candidate could explain of the residual, by projection alone."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

from zoo.diagnosis.shape_search import Beside
from zoo.diagnosis.workbench import Solved, Workbench


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
    """Project the residual on each candidate's columns over its grid of shapes, under the noise that suits the model best.

    Args:
        bench: the runs and effects.
        base: the model as it stands.
        names: candidates.

    Returns:
        Candidates, largest gain first.
    """
    noise, whitener = base.likely.noise, base.mixtures.whitener(base.likely.place)[1]
    beside = Beside.under(base.design, base.fit.theta, base.fit.plain, whitener, bench.span_s)
    total, level = float(beside.residual.square().sum()), (noise.white / base.mixtures.white) ** 2
    found = []
    for name in names:
        effect = bench.effects[name]
        cost, shape = beside.searched(effect, bench.shapes(name))
        found.append(Screened(name, shape, (total - cost) / level, len(effect.amplitudes) + len(effect.shape)))
    return sorted(found, key=lambda candidate: -candidate.gain)
