"""How well a residual's RMS is known from runs of finite length, whose blocks are not independent of each other."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor

BATCHES, FEWEST = 16, 4
"""Most and fewest: between 8 and 16 do best where each is longer than the values remember (Ibragimov & Müller 2010, J. Bus. Econ. Stat. 28:453)."""
MEMORIES = 3.0
"""Autocorrelation times in a batch, as far as the fewest allow it."""
WINDOW = 5.0
"""Autocorrelation times over which correlations are summed to find it (Sokal 1997, in: Functional Integration, 131)."""
LEAST = 0.3
"""Share of the variance of a mean that the scatter of batches shows at least: with less, it tells nothing."""
Z = 1.959964
"""97.5 % quantile of the normal distribution."""


def rms_interval(left: Sequence[Tensor], samples: float = math.inf) -> tuple[float, float] | None:
    """95 % interval of a residual's RMS, from how the mean square differs among long pieces of the runs.

    Args:
        left: (N_r,) residual of each run [unit].
        samples: how many independent values the blocks are worth if the residual is noise alone, see `zoo.scoring.noise.effective_samples`: the
            interval is no narrower than these would make it.

    Returns:
        Low and high [unit]; None where the runs are too short.
    """
    square = [part.square() for part in left]
    mean = float(torch.cat(square).mean())
    if mean == 0:
        return 0.0, 0.0
    error = _error_of_mean([part / (2.0 * mean) for part in square])
    if error is None:
        return None
    reach = max(error, Z * math.sqrt(0.5 / samples))
    return math.sqrt(mean) * math.exp(-reach), math.sqrt(mean) * math.exp(reach)


def ratio_interval(first: Sequence[Tensor], second: Sequence[Tensor]) -> tuple[float, float] | None:
    """95 % interval of the ratio of two residuals' RMS on the same runs.

    The squares are compared block by block, so that what both fail at counts for neither (Diebold & Mariano 1995, J. Bus. Econ. Stat. 13:253); the
    logarithm of the ratio is linearised, and its standard error is that of means over long pieces, which may be correlated within.

    Args:
        first: (N_r,) residual of each run [unit].
        second: (N_r,) another model's, of the same blocks [unit].

    Returns:
        Low and high; None where the runs are too short or a residual is zero.
    """
    means = [float(torch.cat([part.square() for part in one]).mean()) for one in (first, second)]
    if min(means) == 0:
        return None
    error = _error_of_mean([a.square() / (2.0 * means[0]) - b.square() / (2.0 * means[1]) for a, b in zip(first, second, strict=True)])
    ratio = math.sqrt(means[0] / means[1])
    return None if error is None else (ratio * math.exp(-error), ratio * math.exp(error))


def _error_of_mean(values: Sequence[Tensor]) -> float | None:
    """Half a 95 % interval of the mean of all values, by Student's t over batches, none of which reaches across two runs.

    Batches that are not much longer than the values remember differ less than independent ones would: by as much as is true of an exponential memory.
    """
    memory, total = autocorrelation_time(values), sum(part.numel() for part in values)
    pieces = _batches(values, max(FEWEST, min(BATCHES, round(total / (MEMORIES * memory)))))
    if len(pieces) < FEWEST:
        return None
    weight = torch.tensor([float(piece.numel()) for piece in pieces], dtype=torch.float64)
    weight /= weight.sum()
    means = torch.stack([piece.mean().cpu() for piece in pieces])
    scatter = (weight.square() * (means - (weight * means).sum()).square()).sum() * len(pieces) / (len(pieces) - 1)
    lasts = 2.0 * total / len(pieces) / memory
    shown = 1.0 - (1.0 - math.exp(-lasts)) / lasts if memory > 1 else 1.0
    return student(len(pieces) - 1) * math.sqrt(float(scatter) / max(shown, LEAST))


def autocorrelation_time(values: Sequence[Tensor]) -> float:
    """How many successive values are worth one: 1 + 2 Σ ρ over the lags of a window of `WINDOW` such times; 1 at least.

    Args:
        values: (N_r,) of each run.
    """
    mean = torch.cat(list(values)).mean()
    apart = [part - mean for part in values]
    whole = sum(float(part.square().sum()) for part in apart)
    time, lag = 1.0, 1
    while whole and lag < max(map(len, apart)) and lag < WINDOW * time:
        time += 2.0 * sum(float(part[:-lag] @ part[lag:]) for part in apart if len(part) > lag) / whole
        lag += 1
    return max(time, 1.0)


def _batches(values: Sequence[Tensor], most: int) -> list[Tensor]:
    total = sum(part.numel() for part in values)
    counts = [min(round(most * part.numel() / total), part.numel() // 2) for part in values]
    return [piece for part, count in zip(values, counts, strict=True) if part.numel() for piece in part.tensor_split(max(1, count))]


def student(freedom: int) -> float:
    """97.5 % quantile of Student's t (Abramowitz & Stegun 1964, 26.7.5); good to 0.5 % from 3 degrees of freedom on."""
    z, n = Z, float(freedom)
    first, second = (z**3 + z) / 4, (5 * z**5 + 16 * z**3 + 3 * z) / 96
    third = (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384
    fourth = (79 * z**9 + 776 * z**7 + 1482 * z**5 - 1920 * z**3 - 945 * z) / 92160
    return z + first / n + second / n**2 + third / n**3 + fourth / n**4
