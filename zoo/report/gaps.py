"""Where a recording was interrupted, or pieces of it are held out: no line may cross, as nothing is known there."""

from __future__ import annotations

import itertools

import numpy as np

LONGER = 1.5
"""A step longer than so many usual ones is a gap."""


def usual_step(x: np.ndarray) -> float:
    """Median distance of neighbours; 0 where there is none.

    Args:
        x: (N,) increasing.
    """
    return float(np.median(np.diff(x))) if len(x) > 1 else 0.0


def pieces(x: np.ndarray) -> list[slice]:
    """The stretches without a gap, in order; none for no points.

    Args:
        x: (N,) increasing.
    """
    cuts = np.flatnonzero(np.diff(x) > LONGER * usual_step(x)) + 1
    return [slice(a, b) for a, b in itertools.pairwise([0, *cuts.tolist(), len(x)]) if b > a]


def interrupted(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve with a point that is no number in every gap, so that it is not drawn across.

    Args:
        x: (N,) increasing.
        y: (N,) ordinate.
    """
    starts = [piece.start for piece in pieces(x)[1:]]
    return np.insert(x, starts, [(x[i - 1] + x[i]) / 2 for i in starts]), np.insert(np.asarray(y, dtype=float), starts, np.nan)


def covered(x: np.ndarray, start: float, end: float) -> list[tuple[float, float]]:
    """What of a stretch is recorded, half a usual step around each point.

    Args:
        x: (N,) increasing.
        start: of the stretch.
        end: of the stretch.
    """
    half = usual_step(x) / 2
    spans = [(max(start, float(x[piece.start]) - half), min(end, float(x[piece.stop - 1]) + half)) for piece in pieces(x)]
    return [(a, b) for a, b in spans if b > a]
