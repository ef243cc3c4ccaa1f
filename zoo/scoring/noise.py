"""The noise that a complete model would leave: white and flicker, estimated from the data, and how to whiten with it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

CHAIN_RATIO = 4.0
WHITENED_AT_ONCE = 1000
DIFFERENCED, KEPT, KEPT_VARIANCE = 3, 0.9, 0.6230


@dataclass(frozen=True)
class NoiseModel:
    """Noise of block means.

    Attributes:
        white: RMS of the white part of a full block's mean [output's unit].
        flicker: bias instability B [output's unit], one-sided spectrum B²/(πf), Allan deviation √(2 ln2/π)·B.
        walk: rate random walk K [output's unit per √h], variance K²·t since the run's start.
    """

    white: float
    flicker: float
    walk: float = 0.0

    def covariance(self, time: Tensor, share: Tensor) -> Tensor:
        """Covariance of the block means of one run.

        Flicker is a chain of first-order Markov processes whose time constants grow by a factor q = 4, each of variance B²·ln(q)/π
        (the sum's spectrum is B²/(πf) within the chain; Kasdin 1995, Proc. IEEE 83:802).

        Args:
            time: (N,) block centres [s].
            share: (N,) rows behind each mean over those of a full block.

        Returns:
            (N, N) [unit²].
        """
        matrix = torch.diag(self.white**2 / share.clamp_min(1e-3))
        if self.walk > 0:
            hours = (time - time[0]) / 3600.0
            matrix = matrix + self.walk**2 * torch.minimum(hours.unsqueeze(0), hours.unsqueeze(1))
        if self.flicker == 0 or time.numel() < 2:
            return matrix
        delay = (time.unsqueeze(0) - time.unsqueeze(1)).abs()
        block, span = float(torch.diff(time).median()), float(time[-1] - time[0])
        variance = self.flicker**2 * math.log(CHAIN_RATIO) / math.pi
        tau = block / CHAIN_RATIO**2
        while tau < CHAIN_RATIO * span:
            matrix = matrix + variance * _of_means(delay, block, tau)
            tau *= CHAIN_RATIO
        return matrix


def _of_means(delay: Tensor, block: float, tau: float) -> Tensor:
    """Correlation of the means over blocks of a first-order Markov process of unit variance, from the distance of their centres."""
    ratio = tau / block
    gone = -math.expm1(-1.0 / ratio)
    apart = (ratio * gone) ** 2 * torch.exp(-(delay - block).clamp_min(0.0) / tau)
    return torch.where(delay > 0, apart, 2.0 * ratio * (1.0 - ratio * gone))


class Whitener:
    """Multiplies the block means of several runs, one after the other, by the inverse root of their noise covariance.

    `log_determinant` is that of the covariance. Long runs are cut into pieces of at most 1000 blocks whose flicker is taken as independent.
    """

    def __init__(self, noise: NoiseModel, times: list[Tensor], shares: list[Tensor]) -> None:
        """Factorise once.

        Args:
            noise: the noise model.
            times: (N_r,) block centres of each run [s].
            shares: (N_r,) rows of each block over those of a full one.
        """
        self.factors: list[Tensor] = []
        self.log_determinant = 0.0
        for time, share in zip(times, shares, strict=True):
            for piece, weight in zip(time.split(WHITENED_AT_ONCE), share.split(WHITENED_AT_ONCE), strict=True):
                factor = torch.linalg.cholesky(noise.covariance(piece, weight))
                self.log_determinant += 2.0 * float(factor.diagonal().log().sum())
                self.factors.append(
                    torch.linalg.solve_triangular(factor, torch.eye(len(piece), dtype=factor.dtype, device=factor.device), upper=False)
                )
        self.sizes = [factor.shape[0] for factor in self.factors]

    def __call__(self, columns: Tensor) -> Tensor:
        """Whiten (..., N, K) -> (..., N, K), dimensionless."""
        wide = columns.movedim(-2, 0).reshape(columns.shape[-2], -1)  # one matrix product a piece, whatever the batch
        pieces = [factor @ piece for factor, piece in zip(self.factors, wide.split(self.sizes), strict=True)]
        return torch.cat(pieces).reshape(columns.shape[-2], *columns.shape[:-2], columns.shape[-1]).movedim(0, -2)


def white_level(values: list[Tensor]) -> float:
    """RMS of white noise from successive differences, blind to whatever is slow and to rare edges and spikes.

    A second difference removes a local slope; its variance is 6 times that of the white noise (1 + 4 + 1; von Neumann 1941, Ann. Math. Stat. 12:367).
    The largest tenth of them is left out, which keeps 0.6230 of a Gaussian's variance (1 − 2zφ(z)/0.9 with z = 1.645).

    Args:
        values: (N_r,) equally spaced means, one tensor a run.

    Returns:
        σ of one mean [unit]; NaN where there are too few.
    """
    differences = [torch.diff(value, n=2) for value in values if value.numel() > DIFFERENCED]
    if not differences:
        return float("nan")
    squares = torch.cat(differences).square().sort().values
    kept = squares[: max(1, round(KEPT * squares.numel()))]
    return math.sqrt(float(kept.mean()) / (6.0 * KEPT_VARIANCE))
