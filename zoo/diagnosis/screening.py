"""What each candidate could explain of the residual, by projection alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

from torch import Tensor

from zoo.diagnosis.shape_search import Beside
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.effects.base import Effect
from zoo.effects.bounds import to_physical
from zoo.side_by_side import side_by_side

BENT = 1.02
"""RMS of a residual over the white noise above which the coil may have been bent to make up for something."""


@dataclass(frozen=True, eq=False)
class Screened:
    """A candidate's best guess before any refit.

    Attributes:
        name: the effect.
        shape: (S,) physical shape that explains most.
        gain: drop of χ² that its columns give, with everything the model can absorb to first order taken out of them, less the price of an
            unusual shape.
        freedom: parameters it would add, but for those in which nearly all gyros are the same.
        start: θ (P+S,) of the model with it where that explains more at another coil; None at the model's own.
        looked: θ (K, P+S) at the best of other coils, the best first, whether it explains more there or not; None where nobody looked.
    """

    name: str
    shape: Tensor
    gain: float
    freedom: int
    start: Tensor | None = None
    looked: Tensor | None = None


def screen(bench: Workbench, base: Solved, names: list[str]) -> list[Screened]:
    """Project the residual on each candidate's columns over its grid of shapes, under the noise that suits the model best.

    Sharp ones are looked for at other coils as well; every effect that works there is, where the model leaves more than white noise: its coil may be
    bent.

    Args:
        bench: the runs and effects.
        base: the model as it stands.
        names: candidates.

    Returns:
        Candidates, largest gain first.
    """
    here = Here(bench, base)

    def far(effect: Effect) -> bool:
        return effect.sharp or (effect.place == "coil" and base.rms > BENT * bench.mixtures.white)

    def anywhere(name: str) -> Screened:
        return _elsewhere(bench, base, here.screened(name), here.total) if far(bench.effects[name]) else here.screened(name)

    if any(far(bench.effects[name]) for name in names):
        _ = base.elsewhere.some  # known to all copies of this process that will look there, and to what comes after
    longest_first = sorted(names, key=lambda name: -len(bench.shapes(name)) * len(bench.effects[name].amplitudes))
    found = side_by_side(anywhere, longest_first)
    return sorted(found, key=lambda candidate: (-candidate.gain, names.index(candidate.name)))


class Here:
    """What candidates could explain at a model's own coil, under the noise that suits the model best; it leaves `total`."""

    def __init__(self, bench: Workbench, base: Solved) -> None:
        """Keep what all of them are tried beside."""
        noise, whitener = base.likely.noise, base.mixtures.whitener(base.likely.place)[1]
        self._bench = bench
        self._beside = Beside.under(base.design, base.fit.theta, base.fit.plain, whitener, bench.span_s)
        self._level = (noise.white / base.mixtures.white) ** 2
        self.total = float(self._beside.residual.square().sum())

    def screened(self, name: str) -> Screened:
        """The best of a candidate's shapes."""
        effect = self._bench.effects[name]
        cost, shape = self._beside.searched(effect, self._bench.shapes(name))
        return Screened(name, shape, (self.total - cost) / self._level, len(effect.amplitudes) + sum(not one.usual for one in effect.shape))


def _elsewhere(bench: Workbench, base: Solved, here: Screened, total: float) -> Screened:
    """The better of what was found at the model's coil and of what a closer look finds at others.

    Both under the noise that suits the model best, under which it leaves `total`.
    """
    effect, own = bench.effects[here.name], len(base.fit.theta)
    looked = base.elsewhere.look(effect, bench.shapes(here.name), bench.span_s)
    start = looked[0]
    noise, whitener = base.likely.noise, base.mixtures.whitener(base.likely.place)[1]
    shape, coil = to_physical(start[own:], effect.shape), start[:own]
    beside = Beside.under(base.design, coil, base.design.plain_columns(coil.unsqueeze(0)).squeeze(0), whitener, bench.span_s)
    gain = (total - beside.best(effect, shape.unsqueeze(0))[0]) * (base.mixtures.white / noise.white) ** 2
    return replace(here, looked=looked) if gain <= here.gain else replace(here, gain=gain, shape=shape, start=start, looked=looked)
