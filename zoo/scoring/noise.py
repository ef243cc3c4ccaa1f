"""The noise that a complete model would leave: white and flicker, estimated from the data, and how to whiten with it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist

import torch
from torch import Tensor

from zoo.scoring.inverse_root import InverseRoot

CHAIN_RATIO = 4.0
WHITENED_AT_ONCE = 1000
DIFFERENCED = 3
SAME_TIMES = 1e-9
"""Share of a block by which the times of blocks may differ that were recorded alike: means are rounded."""
FEW, MOSTLY_FILLED = 64, 0.7
"""Number of columns below which, and share with anything in them above which sorting them out costs more than it saves."""
LOOKED_AT = 3
"""Rows, about, that most filled columns show something in, so that the others need not be gone through."""
CHECK_ALLOWED = 1.5
"""RMS over the noise floor beyond which a model is not complete, however like noise it is: on runs that were not fitted, or as it was given."""
NORMAL = NormalDist()


@dataclass(frozen=True, eq=False)
class Blocks:
    """When the block means of one run were taken, and what unit noise of each colour makes of them.

    Attributes:
        time: (N,) block centres [s].
        share: (N,) rows behind each mean over those of a usual block.
        begin: when the run began [s]; where None, at the first block.
    """

    time: Tensor
    share: Tensor
    begin: float | None = None

    def begins(self, other: Blocks) -> bool:
        """Whether noise makes of these what it makes of the first of the others, as in runs recorded alike that last as long or not as long."""
        size, (block, taus), (_, others) = len(self.time), self._chain, other._chain
        if self.begin != other.begin or size > len(other.time) or len(taus) != len(others) or not torch.equal(self.share, other.share[:size]):
            return False
        apart = float((self.time - other.time[:size]).abs().max()) if size else 0.0
        return apart <= SAME_TIMES * block and all(math.isclose(one, also, rel_tol=SAME_TIMES) for one, also in zip(taus, others, strict=True))

    def same(self, other: Blocks) -> bool:
        """Whether noise makes the same of both."""
        return len(self.time) == len(other.time) and self.begins(other)

    @cached_property
    def pieces(self) -> list[Blocks]:
        """Consecutive blocks, at most 1000 at a time, of the same run."""
        if self.time.numel() <= WHITENED_AT_ONCE:
            return [self]
        begin = float(self.time[0]) if self.begin is None else self.begin
        parts = zip(self.time.split(WHITENED_AT_ONCE), self.share.split(WHITENED_AT_ONCE), strict=True)
        return [Blocks(time, share, begin) for time, share in parts]

    @cached_property
    def white(self) -> Tensor:
        """(N,) variance of the means of white noise that has variance 1 in a usual block."""
        return 1.0 / self.share.clamp_min(1e-3)

    @property
    def hours(self) -> Tensor:
        """(N,) since the run's start, which is the variance of a random walk with K = 1 per √h."""
        return (self.time - (self.time[0] if self.begin is None else self.begin)) / 3600.0

    @cached_property
    def walk(self) -> Tensor:
        """(N, N) covariance of a random walk from the run's start with K = 1 per √h."""
        return torch.minimum(self.hours.unsqueeze(0), self.hours.unsqueeze(1))

    @cached_property
    def flicker(self) -> Tensor:
        """(N, N) covariance of the means of flicker noise with B = 1.

        A chain of first-order Markov processes whose time constants grow by a factor q = 4, each of variance ln(q)/π (the sum's spectrum is 1/(πf)
        within the chain; Kasdin 1995, Proc. IEEE 83:802).
        """
        return self._flicker((self.time.unsqueeze(0) - self.time.unsqueeze(1)).abs())

    def _flicker(self, delay: Tensor) -> Tensor:
        """The same covariance for any distances [s] of the blocks' centres."""
        matrix = torch.zeros_like(delay)
        block, taus = self._chain
        for tau in taus:
            matrix += math.log(CHAIN_RATIO) / math.pi * _of_means(delay, block, tau)
        return matrix

    @property
    def flickering(self) -> Tensor:
        """(N,) variance of the means of flicker noise with B = 1: the diagonal of its covariance, without the rest."""
        return self._flicker(torch.zeros_like(self.time))

    @cached_property
    def _chain(self) -> tuple[float, tuple[float, ...]]:
        """Length of a block and the time constants of the processes [s]: from far below it to beyond the run."""
        if self.time.numel() < 2:
            return 0.0, ()
        block, span = float(torch.diff(self.time).median()), float(self.time[-1] - self.time[0])
        taus = [block / CHAIN_RATIO**2]
        while taus[-1] < CHAIN_RATIO * span:
            taus.append(taus[-1] * CHAIN_RATIO)
        return block, tuple(taus[:-1])


@dataclass(frozen=True)
class NoiseModel:
    """Noise of block means.

    Attributes:
        white: RMS of the white part of a usual block's mean [output's unit].
        flicker: bias instability B [output's unit], one-sided spectrum B²/(πf), Allan deviation √(2 ln2/π)·B.
        walk: rate random walk K [output's unit per √h], variance K²·t since the run's start.
    """

    white: float
    flicker: float
    walk: float = 0.0

    def scaled(self, factor: float) -> NoiseModel:
        """The same mixture, so many times as loud."""
        return NoiseModel(factor * self.white, factor * self.flicker, factor * self.walk)

    def variance(self, blocks: Blocks) -> Tensor:
        """(N,) of the block means of one run [unit²], however long."""
        return self.white**2 * blocks.white + self.walk**2 * blocks.hours + self.flicker**2 * blocks.flickering

    def covariance(self, blocks: Blocks) -> Tensor:
        """(N, N) covariance of the block means of one run [unit²]."""
        matrix = torch.diag(self.white**2 * blocks.white)
        if self.walk > 0:
            matrix += self.walk**2 * blocks.walk
        if self.flicker > 0:
            matrix += self.flicker**2 * blocks.flicker
        return matrix


def _of_means(delay: Tensor, block: float, tau: float) -> Tensor:
    """Correlation of the means over blocks of a first-order Markov process of unit variance, from the distance of their centres."""
    ratio = tau / block
    gone = -math.expm1(-1.0 / ratio)
    apart = (ratio * gone) ** 2 * torch.exp(-(delay - block).clamp_min(0.0) / tau)
    return torch.where(delay > 0, apart, 2.0 * ratio * (1.0 - ratio * gone))


class Whitener:
    """Multiplies the block means of several runs, one after the other, by the inverse root of their noise covariance.

    `log_determinant` is that of the covariance. Long runs are cut into pieces of at most 1000 blocks, whose covariances are right and
    which are taken as independent of each other.
    """

    def __init__(self, noise: NoiseModel, runs: list[Blocks]) -> None:
        """Factorise once.

        Args:
            noise: the noise model.
            runs: block means of each run, N_r each.
        """
        pieces = [piece for run in runs for piece in run.pieces]
        roots: dict[Blocks, InverseRoot] = {}
        whose: dict[Blocks, Blocks] = {}
        for piece in sorted(dict.fromkeys(pieces), key=lambda one: -len(one.time)):
            whose[piece] = next((one for one in roots if piece.begins(one)), piece)
            if whose[piece] is piece:
                roots[piece] = InverseRoot(noise.covariance(piece))
        self.sizes = [len(piece.time) for piece in pieces]
        self.factors = [roots[whose[piece]].matrix[:size, :size] for piece, size in zip(pieces, self.sizes, strict=True)]
        self.shared = [(root, [i for i, piece in enumerate(pieces) if whose[piece] is own]) for own, root in roots.items()]
        self.log_determinant = -2.0 * sum(float(factor.diagonal().log().sum()) for factor in self.factors)

    def __call__(self, columns: Tensor) -> Tensor:
        """Whiten (..., N, K) -> (..., N, K), dimensionless, in the precision of what it is given."""
        if not columns.numel():
            return columns
        pieces = list(columns.movedim(-2, 0).reshape(columns.shape[-2], -1).split(self.sizes))
        for root, places in self.shared:
            # One product for all pieces recorded alike, and whatever the batch: with few columns it takes as long as reading the root does.
            product = _product(root, torch.cat([_lasting(pieces[i], len(root)) for i in places], dim=1))
            for i, part in zip(places, product.chunk(len(places), dim=1), strict=True):
                pieces[i] = part[: self.sizes[i]]
        return torch.cat(pieces).reshape(columns.shape[-2], *columns.shape[:-2], columns.shape[-1]).movedim(0, -2)


def _lasting(piece: Tensor, size: int) -> Tensor:
    """A piece (N, K) with nothing behind it: a triangular root lets nobody look ahead."""
    return piece if len(piece) == size else torch.nn.functional.pad(piece, (0, 0, 0, size - len(piece)))


def _product(root: InverseRoot, piece: Tensor) -> Tensor:
    """Root @ piece; where most columns are zero in this piece, as those of other runs are, without them."""
    enough = MOSTLY_FILLED * piece.shape[1]
    if piece.shape[1] < FEW or int(piece[:: max(len(piece) // LOOKED_AT, 1)].any(dim=0).sum()) > enough:
        return root @ piece
    filled = piece.abs().amax(dim=0) != 0
    if int(filled.sum()) > enough:
        return root @ piece
    product = torch.zeros_like(piece)
    if filled.any():  # torch pads no empty columns before 2.5
        product[:, filled] = root @ piece[:, filled]
    return product


def effective_samples(noise: NoiseModel, runs: list[Blocks]) -> float:
    """Number of independent block means whose mean square would scatter as much: (tr Σ)²/tr Σ² (Bretherton et al. 1999, J. Climate 12:1990).

    Args:
        noise: of the block means.
        runs: when they were taken.
    """
    variance = squares = 0.0
    for piece in [piece for run in runs for piece in run.pieces]:
        covariance = noise.covariance(piece)
        variance += float(covariance.trace())
        squares += float(covariance.square().sum())
    return variance**2 / squares


def white_level(values: list[Tensor], kept: float = 0.9) -> float:
    """RMS of white noise from successive differences, blind to whatever is slow and to rare edges and spikes.

    A second difference removes a local slope; its variance is 6 times that of the white noise (1 + 4 + 1; von Neumann 1941, Ann. Math. Stat. 12:367).
    The largest of them are left out, which keeps the share 1 − 2zφ(z)/κ of a Gaussian's variance, with z the quantile that κ lies within.

    Args:
        values: (N_r,) equally spaced means, one tensor a run.
        kept: κ, share of the differences that is looked at; less is blinder to what is fast now and then, and noisier.

    Returns:
        σ of one mean [unit]; NaN where there are too few.
    """
    differences = [torch.diff(value, n=2) for value in values if value.numel() > DIFFERENCED]
    if not differences:
        return float("nan")
    squares = torch.cat(differences).square().sort().values
    quiet = squares[: max(1, round(kept * squares.numel()))]
    z = NORMAL.inv_cdf((1.0 + kept) / 2.0)
    return math.sqrt(float(quiet.mean()) / (6.0 * (1.0 - 2.0 * z * NORMAL.pdf(z) / kept)))
