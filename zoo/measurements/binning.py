"""Means over time bins of a stream of rows. Bins count from the start of each gap-free segment, so none straddles a gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# A row on a bin's edge, up to rounding, opens the next bin: 0.3 / 0.1 is 2.9999999999999996. In steps, to be the same for all widths.
EDGE = 1e-4


@dataclass(frozen=True, eq=False)
class Bins:
    """Consecutive rows, or means of consecutive rows.

    Attributes:
        segment: (M,) int64, number of the gap-free segment.
        tick: (M,) int64, whole bin widths since the segment's start.
        mean: (M, C) float64.
        count: (M,) int64, recorded rows behind each.
    """

    segment: np.ndarray
    tick: np.ndarray
    mean: np.ndarray
    count: np.ndarray

    def __len__(self) -> int:
        return len(self.count)

    def __getitem__(self, part: slice) -> Bins:
        return Bins(self.segment[part], self.tick[part], self.mean[part], self.count[part])


def join(parts: Sequence[Bins]) -> Bins:
    """One after the other."""
    return Bins(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("segment", "tick", "mean", "count")))


def starts(segment: np.ndarray, tick: np.ndarray) -> np.ndarray:
    """Indices at which a new bin begins, () for no rows at all."""
    change = (np.diff(segment) != 0) | (np.diff(tick) != 0)
    return np.flatnonzero(np.concatenate([np.ones(min(1, len(tick)), bool), change]))


def merge(bins: Bins, factor: int) -> Bins:
    """Means over bins `factor` times as wide, weighted by the rows behind each.

    Sums are taken of the differences from a bin's first value: a constant stays exactly that constant, and large times lose no digits.
    """
    tick = bins.tick // factor
    first = starts(bins.segment, tick)
    if len(first) == len(bins):
        return Bins(bins.segment, tick, bins.mean, bins.count)
    size = np.diff(first, append=len(bins))
    count = np.add.reduceat(bins.count, first)
    difference = (bins.mean - np.repeat(bins.mean[first], size, axis=0)) * bins.count[:, None]
    mean = bins.mean[first] + np.add.reduceat(difference, first, axis=0) / count[:, None]
    return Bins(bins.segment[first], tick[first], mean, count)


class Clock:
    """Cuts a stream of times at its gaps and counts ticks from the start of each segment.

    Attributes:
        gaps: gaps met so far.
        longest: the longest of them [s], and the time at which it began [s].
    """

    def __init__(self, step_s: float, tick_s: float, gap_s: float) -> None:
        self.gaps = 0
        self.longest = (0.0, 0.0)
        self._edge_s, self._tick_s, self._gap_s = EDGE * step_s, tick_s, gap_s
        self._last: float | None = None
        self._start = 0.0

    def read(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Segment and tick of each row of the next chunk.

        Args:
            time: (M,) increasing [s].

        Returns:
            (M,) int64 each.
        """
        if self._last is None:
            self._last = self._start = float(time[0])
        step = np.diff(time, prepend=self._last)
        gap = step > self._gap_s
        segment = self.gaps + np.cumsum(gap)
        start = np.maximum.accumulate(np.where(gap, time, self._start))
        if gap.any():
            worst = int(np.argmax(step))
            self.longest = max(self.longest, (float(step[worst]), float(time[worst] - step[worst])))
        self.gaps, self._start, self._last = int(segment[-1]), float(start[-1]), float(time[-1])
        return segment, np.floor((time - start + self._edge_s) / self._tick_s).astype(np.int64)

    def told(self) -> str:
        """The gaps met so far, in words."""
        longest, begins = self.longest
        return f"{self.gaps} gap(s) in time, the longest {longest:g} s from {begins:g} s"


class Level:
    """Bins of one width, filled chunk by chunk; parts of the bin that is still open wait, so that no result depends on the chunks' size.

    Attributes:
        width: in ticks of the clock; 0 for the rows as recorded.
        done: finished bins, while they may be needed.
    """

    def __init__(self, width: int, finer: int) -> None:
        self.width = width
        self.done: list[Bins] | None = []
        self._factor = width // max(1, finer)
        self._open: list[Bins] = []

    def push(self, parts: Bins) -> Bins:
        """Takes the next bins of the finer level and returns those of its own that they complete."""
        if self.width == 0:
            return self._keep(parts)
        waiting = join([*self._open, parts])
        first = starts(waiting.segment, waiting.tick // self._factor)
        last = int(first[-1]) if len(first) else 0
        self._open = [waiting[last:]]
        return self._keep(merge(waiting[:last], self._factor))

    def close(self, parts: Bins | None) -> Bins | None:
        """Takes the last bins of the finer level and returns the last ones of its own."""
        if self.width == 0:
            return None
        pushed = [self.push(parts)] if parts is not None else []
        return join([*pushed, self._keep(merge(join(self._open), self._factor))])

    def _keep(self, bins: Bins) -> Bins:
        if self.done is not None:
            self.done.append(bins)
        return bins
