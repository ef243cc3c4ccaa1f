"""Gaps in which nobody knows how the temperature went: what remembers it is wrong for a while after them."""

from __future__ import annotations

import numpy as np

WINDOW_S = 300.0
"""How far on either side of a gap the temperature's slope is read off."""
UNKNOWN_K = 0.5
"""By how much it may have left the straight line through the gap."""
FORGOTTEN_S = 3600.0
"""After which that no longer matters: four times the lag of a coil of the usual size."""


def unsettled(segment: np.ndarray, time: np.ndarray, temperatures: np.ndarray) -> np.ndarray:
    """Samples after gaps through which the temperature is not known.

    It is where it went straight on: a hold that goes on, or a ramp. A ramp that began, ended or turned in the gap did so at a time that the slopes on
    either side tell only where there was one such corner; the most by which such a path leaves the straight line is what is compared.

    Args:
        segment: (T,) number of the gap-free segment.
        time: (T,) [s].
        temperatures: (T, C) of the thermometers [°C].

    Returns:
        (T,) bool.
    """
    lost = np.zeros(len(time), dtype=bool)
    for first in np.flatnonzero(np.diff(segment)) + 1:
        before, after = (slice(*np.searchsorted(segment, [number, number + 1])) for number in (segment[first - 1], segment[first]))
        gap = time[first] - time[first - 1]
        straight = (temperatures[first] - temperatures[first - 1]) / gap
        leaving, arriving = (
            np.abs(_slope(time[part], temperatures[part], time[at], straight) - straight) for part, at in ((before, first - 1), (after, first))
        )
        away = gap * leaving * arriving / np.maximum(leaving + arriving, 1e-300)
        if away.max() > UNKNOWN_K:
            lost |= (time >= time[first]) & (time < time[first] + FORGOTTEN_S)
    return lost


def _slope(time: np.ndarray, temperatures: np.ndarray, edge: float, otherwise: np.ndarray) -> np.ndarray:
    """(C,) slopes [K/s] of what lies within a window of a time; some other where that is a single sample."""
    near = np.abs(time - edge) <= WINDOW_S
    if near.sum() < 2:
        return otherwise
    clock = time[near] - time[near].mean()
    slopes: np.ndarray = clock @ (temperatures[near] - temperatures[near].mean(axis=0)) / (clock @ clock)
    return slopes
