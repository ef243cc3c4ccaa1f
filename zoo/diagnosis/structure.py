"""Is what is left noise? An absolute test, and what the rest depends on if it is not."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import torch

from zoo.diagnosis.free_functions import SIGNIFICANT, freed_of, functions_of, weigh
from zoo.diagnosis.moments import kurtosis, prominence, rarity
from zoo.diagnosis.outdone import outdone
from zoo.diagnosis.solved import Freed, Solved
from zoo.diagnosis.swings import BAND, BAND_BESIDE, periodograms, swings
from zoo.diagnosis.switching import TWO_LEVELS, TWO_LEVELS_BESIDE, switching
from zoo.diagnosis.workbench import QUIET, Workbench
from zoo.fitting.projection import project
from zoo.side_by_side import side_by_side

LEVEL_ALLOWED = 0.1
"""Excess of χ²/N over 1 that counts as noise: 5 % in RMS, what the noise level itself is uncertain by."""
SHARE_ALLOWED = 0.04
"""Share of the variance explained by the added effects that their simplified form may leave behind (20 % in amplitude)."""
LEVEL_ALLOWED_AFTER = 0.25
"""Most excess that a simplified form may leave (12 % in RMS)."""
MATERIAL = 0.08
"""Share of the noise variance that a free function must explain to matter."""
SLIGHT, CLEAR = 0.03, 1.5
"""Share from which it matters as well, where the evidence is so many times what is needed. Of 86 simulated gyros with nothing hidden none has more
than .6 times that, of 29 of their runs taken alone one .9 times, with a share below .05."""
KURTOSIS = 4.0
"""Standard deviations of the excess kurtosis of normal numbers that chance may give the steps of a walk."""
WANDERS = 0.25
"""Share of what a line explains that a phase which wanders may leave around it."""
LINE = 10.0
"""Largest ordinate of a white periodogram over the mean, less the logarithm of their number, that chance may give (5 in 100 000; Fisher 1929)."""


@dataclass(frozen=True)
class Dependence:
    """What a free smooth function of one quantity would explain of the residual.

    Attributes:
        depends_on: the quantity, in words.
        explains: share of the residual's variance.
        evidence: log Bayes factor over none.
        is_line: whether it is a frequency instead of a smooth function.
    """

    depends_on: str
    explains: float
    evidence: float
    is_line: bool = False

    @property
    def matters(self) -> bool:
        """Whether it is significant and material."""
        return self.evidence > LINE if self.is_line else self.evidence > SIGNIFICANT and self.explains > MATERIAL


@dataclass(frozen=True)
class Structure:
    """Result of the absolute test.

    Attributes:
        strain: the worst of its parts over what is allowed for it; noise has 1 or less.
        excess: χ² per degree of freedom − 1.
        dependences: significant free functions, best first.
        outdone: whether it would be noise, were there no free function of one quantity that explains as much with fewer parameters.
    """

    strain: float
    excess: float
    dependences: tuple[Dependence, ...]
    outdone: bool = False

    @property
    def is_noise(self) -> bool:
        """Whether the residual is noise."""
        return self.strain <= 1.0


def examine(bench: Workbench, final: Solved, base: Solved) -> Structure:
    """Test the residual of a model against noise, absolutely.

    Noise means that the likeliest mixture of white, flicker and random walk within what gyros have reaches χ²/dof = 1, within what the noise level is
    uncertain by, that the steps of a large random walk are normal and nothing happens at few moments or switches between two levels, that what
    this mixture predicts from the past leaves no spectral line or band, and that no smooth function of temperature, rate, time or a recorded input
    explains a material share. Where effects were added to `base`, a small part of what they explained may remain, for a catalogue's form is never
    nature's; and no smooth function of one quantity alone, at whatever coil, may have more evidence than they have, for a right form needs fewer
    parameters. Where none were, neither may noise and a bent coil stand for one.

    Args:
        bench: the runs.
        final: the model to judge.
        base: the model before anything was added.
    """
    test = _Test(bench, final, base)
    strains = list(test.strains())
    strain = max(0.0, *strains)
    strain = min(strain, 1.0) * test.left if test.quiet else strain
    found = (*[one for one in test.tried if one.matters], *([test.line] if test.line is not None and test.line.matters else []))
    *others, last = strains  # where anything was added, that of free functions
    return Structure(strain, test.excess, found, not test.alone and last > 1.0 >= max(others))


def leaves_noise(bench: Workbench, final: Solved, base: Solved) -> bool:
    """Whether the residual of a model is noise: what `examine` finds, no further than it takes to know.

    Args:
        bench: the runs.
        final: the model to judge.
        base: the model before anything was added.
    """
    test = _Test(bench, final, base)
    return test.quiet or all(strain <= 1.0 for strain in test.strains())


@dataclass(frozen=True, eq=False)
class _Test:
    """The parts of the absolute test, see `examine`; each is reckoned when it is asked for."""

    bench: Workbench
    final: Solved
    base: Solved

    @property
    def quiet(self) -> bool:
        """Whether there is nothing left to explain."""
        return self.left < 1.0

    @property
    def left(self) -> float:
        """Variance of the residual over that below which there is nothing left to explain."""
        return (self.final.rms / (QUIET * self.bench.mixtures.white)) ** 2

    @property
    def alone(self) -> bool:
        """Whether nothing was added."""
        return self.final.names == self.base.names

    @property
    def dof(self) -> int:
        """Degrees of freedom that the model leaves."""
        return max(self.bench.blocks - self.final.freedom, 1)

    @cached_property
    def excess(self) -> float:
        """χ² per degree of freedom − 1."""
        return self.final.likely.cost / self.dof - 1.0

    @cached_property
    def forgiven(self) -> float:
        """Share of the noise variance that the simplified form of what was added may leave."""
        explained = float(self.base.residual.square().mean() - self.final.residual.square().mean()) / self.bench.noise_floor(self.final) ** 2
        return min(SHARE_ALLOWED * max(explained, 0.0), LEVEL_ALLOWED_AFTER)

    @cached_property
    def coloured(self) -> float:
        """Share of the noise variance that may go with one quantity or frequency: what is forgiven, and what drawing readings smooth left."""
        return self.forgiven + (self.bench.scatter / self.bench.noise_floor(self.final)) ** 2

    @cached_property
    def lines(self) -> tuple[float, ...]:
        """Frequencies of lines whose surroundings are their own [Hz]."""
        return _lines(self.bench, self.final, self.base)

    @cached_property
    def line(self) -> Dependence | None:
        """The frequency that stands out most."""
        return spectral_line(self.bench, self.final, self.lines)

    @cached_property
    def tried(self) -> list[Dependence]:
        """What free functions would explain."""
        return free_dependences(self.bench, self.final)

    def strains(self) -> Iterator[float]:
        """Each part over what is allowed for it, those first that take least time; the last only where no other is more than allowed."""
        strained = False
        for part in (self._level, self._line, self._swings, self._jumps, self._levels, self._shape, self._outdone):
            strain = part()
            strained = strained or strain > 1.0
            yield strain
        if self.alone and not strained:
            yield _bent_to(self.bench, self.base)

    def _level(self) -> float:
        return self.excess / (LEVEL_ALLOWED + 3.0 * math.sqrt(2.0 / self.dof) + self.forgiven)

    def _line(self) -> float:
        if self.line is None:
            return 0.0
        return self._wave(self.line.evidence / LINE, self.line.explains)

    def _swings(self) -> float:
        band = swings(self.bench, self.final, self.lines)
        return self._wave(band.evidence / (BAND if self.alone else BAND_BESIDE), band.share)

    def _levels(self) -> float:
        levels = switching(self.bench, self.final)
        return self._wave(levels.evidence / (TWO_LEVELS if self.alone else TWO_LEVELS_BESIDE), levels.share)

    def _wave(self, strength: float, share: float) -> float:
        return min(strength, share * (1.0 + self.excess) / self.coloured if self.coloured > 0 else math.inf)

    def _jumps(self) -> float:
        return _jumps(self.bench, self.final, self.alone, self.forgiven)

    def _shape(self) -> float:
        allowed = MATERIAL + self.coloured
        return max((min(one.evidence / SIGNIFICANT, one.explains * (1.0 + self.excess) / allowed) for one in self.tried), default=0.0)

    def _outdone(self) -> float:
        return outdone(self.bench, self.final, self.base)


def _lines(bench: Workbench, final: Solved, base: Solved) -> tuple[float, ...]:
    """Frequencies of the lines that were added [Hz], unless what is left around them is more than a wandering phase leaves."""
    found = [line for name in final.names if name not in base.names for line in bench.effects[name].frequencies(final.shape_of(name))]
    if not found:
        return ()
    whole, rest = (sum(float(power.sum()) for power, _ in periodograms(bench, final, lines)) for lines in ((), tuple(found)))
    explained = 0.0
    for name, own in final.places().items():
        if name not in base.names and bench.effects[name].frequencies(final.shape_of(name)):
            explained += float((final.plain_columns[:, own] @ final.fit.amplitudes[own]).square().sum()) / bench.mixtures.white**2
    return tuple(found) if 2.0 * (whole - rest) < WANDERS * explained else ()


def _jumps(bench: Workbench, final: Solved, alone: bool, forgiven: float) -> float:
    """Excess kurtosis of the whitened residual over what chance may give: of the steps of a walk that is large, and of bursts of any length.

    What the simplified form of an added effect leaves may be short and rare as well. So beside one (not `alone`) only bursts that are no noise count,
    and only as far as their share is more than what is `forgiven`.
    """
    walk = kurtosis(bench, final) / KURTOSIS if bench.mixtures.much_walk(final.likely.noise) else 0.0
    bursts = rarity(bench, final)
    if not alone:
        bursts = min(bursts, prominence(bench, final) / max(forgiven, 1e-9)) if bursts > 1.0 else 0.0
    return max(walk, bursts)


def _bent_to(bench: Workbench, base: Solved) -> float:
    """How far the best free function at another coil and beside another noise is ahead of none, over what is allowed.

    A coil that has bent to what is missing, and flicker or a walk that has taken over the rest, leave little of its variance to be explained. So what
    counts as a share is the gain in χ², of as many blocks. What readings make of the model's output may go with what filters them.
    """
    freed = freed_of(bench, base)
    made = (bench.stirred / bench.mixtures.white) ** 2
    needed = SIGNIFICANT + math.log(max(len(freed), 1))

    def strain(one: Freed) -> float:
        clear, share = one.evidence / needed, 2.0 * one.gain / bench.blocks
        return max(min(clear, share / (MATERIAL + made)), min(clear / CLEAR, share / (SLIGHT + made)))

    return max(map(strain, freed.values()), default=0.0)


def spectral_line(bench: Workbench, final: Solved, lines: tuple[float, ...] = ()) -> Dependence | None:
    """The frequency at which a model's residual, whitened by its likeliest noise, stands out most; None where no run has a spectrum.

    Flicker and random walk can take over the variance of something that recurs in time, but not its frequency. Blocks are taken as evenly spaced, so
    that a gap within a run blurs a line.
    """
    spectra = periodograms(bench, final, lines)
    power, frequency = torch.cat([one for one, _ in spectra]), torch.cat([one for _, one in spectra])
    if not len(power):
        return None
    excess = float(power.max() / power.mean()) - math.log(len(power))
    turns = 2 * torch.pi * float(frequency[power.argmax()]) * torch.cat([run.block_mean(run.time) for run in bench.runs])
    wave = torch.cat([final.plain_columns, turns.cos().unsqueeze(1), turns.sin().unsqueeze(1)], dim=1)
    share = 1.0 - float(project(wave, final.design.error).cost) / float(final.residual.square().sum())
    return Dependence(f"time that recurs every {1.0 / float(frequency[power.argmax()]):.0f} s", share, excess, is_line=True)


def free_dependences(bench: Workbench, final: Solved) -> list[Dependence]:
    """What a free smooth function of each quantity would explain of a model's residual, best first."""
    free = functions_of(bench, final)
    weighed = side_by_side(lambda one: weigh(bench, final, one.columns), free)
    return sorted([Dependence(one.words, *worth) for one, worth in zip(free, weighed, strict=True)], key=lambda item: -item.evidence)
