"""One run on its way from rows to blocks.

Until all runs are known, and with them the block length, it keeps the rows or means over a few nested widths, from which any length can
be made.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from zoo.measurements.binning import Bins, Clock, Level, join, merge, starts

AUTO_S = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
ENOUGH_BLOCKS = 400
GAP_STEPS = 5.0
"""Times between rows above which there is a gap, where the user does not say."""
JITTER = 0.01
"""Share by which the times between rows of recordings may differ that are sampled alike."""
FINE_PER_BLOCK = 5
AROUND = 11
"""Blocks by whose rows it is told how often rows came just then: a recorder may change its rate, or write in bursts."""
# In ticks of a fifth of the shortest block: each divides the next, and every fine step is a multiple of one of them.
_NESTED = (1, 10, 100)

Average = float | None | Literal["auto"]


def numbered(segment: np.ndarray, tick: np.ndarray, count: np.ndarray, expected: float, alike: bool = False) -> tuple[np.ndarray, int]:
    """Numbers the blocks in time order, leaving out those with less than half of their rows.

    Args:
        segment: (T,) gap-free segment of each fine sample.
        tick: (T,) block lengths since the segment's start.
        count: (T,) recorded rows behind each.
        expected: rows in a full block, at the time between rows that is usual in the beginning.
        alike: whether all are to have that; else half of what the median of those around has will do.

    Returns:
        (T,) int64 block of each fine sample, −1 where it is left out; and how many blocks were left out.
    """
    first = starts(segment, tick)
    rows = np.add.reduceat(count, first)
    kept = rows >= 0.5 * (expected if alike or len(rows) < AROUND else np.minimum(expected, _around(rows)))
    number = np.where(kept, np.cumsum(kept) - 1, -1)
    return np.repeat(number, np.diff(first, append=len(tick))), int((~kept).sum())


def _around(rows: np.ndarray) -> np.ndarray:
    """(B,) median over each value and its neighbours."""
    padded = np.pad(rows, AROUND // 2, mode="reflect")
    medians: np.ndarray = np.median(np.lib.stride_tricks.sliding_window_view(padded, AROUND), axis=-1)
    return medians


def as_recorded(average_s: float | None, step_s: float) -> bool:
    """Whether blocks would be no longer than the time between rows (to `JITTER`): then every row is one."""
    return average_s is None or average_s <= (1.0 + JITTER) * step_s


class Recording:
    """Takes rows chunk by chunk in memory that follows the duration and not the rate, and gives the two grids of a `Run`.

    Attributes:
        step_s: median time between rows [s].
        clock: cuts the rows into segments.
        rows: rows so far.
        span_s: time from the first of them to the last [s].
        notes: what the reader noticed, one sentence each.
    """

    def __init__(self, step_s: float, average_s: Average, gap_s: float) -> None:
        self.step_s = step_s
        self.rows, self.span_s = 0, 0.0
        self._begin_s: float | None = None
        self.notes: list[str] = []
        if average_s != "auto" and as_recorded(average_s, step_s):
            average_s = None
        length = AUTO_S[0] if average_s == "auto" else average_s or step_s
        self._tick_s = length / FINE_PER_BLOCK
        self.clock = Clock(step_s, self._tick_s, gap_s)
        widths = _NESTED if average_s == "auto" else _NESTED[:1]
        merging = [width for width in widths if average_s is not None and self._merges(width)]
        chain = merging if merging[:1] == [1] else [0, *merging]
        self._levels = [Level(width, finer) for width, finer in zip(chain, [0, *chain[:-1]], strict=True)]

    def _merges(self, width: int) -> bool:
        # Bins of fewer than two rows would be the rows again, only less regular.
        return width * self._tick_s >= 2 * self.step_s

    def push(self, chunk: np.ndarray) -> None:
        """Takes the next rows, (M, C) with the time first."""
        self.rows += len(chunk)
        self._begin_s = float(chunk[0, 0]) if self._begin_s is None else self._begin_s
        self.span_s = float(chunk[-1, 0]) - self._begin_s
        parts = Bins(*self.clock.read(chunk[:, 0]), chunk, np.ones(len(chunk), np.int64))
        for level in self._levels:
            parts = level.push(parts)
        self._release()

    def close(self) -> None:
        """Completes the bins that are open; no rows can follow."""
        parts: Bins | None = None
        for level in self._levels:
            parts = level.close(parts)

    def _release(self) -> None:
        """Forgets bins finer than any still needed: once there are enough blocks of a length, none shorter will be chosen."""
        for place, level in enumerate(self._levels):
            if place and self._levels[place - 1].done is not None and self._blocks(level, level.width * FINE_PER_BLOCK, True) >= ENOUGH_BLOCKS:
                for finer in self._levels[:place]:
                    finer.done = None

    @property
    def held(self) -> int:
        """Rows and bins kept at present."""
        return sum(len(bins) for level in self._levels for bins in level.done or [])

    def blocks(self, average_s: float) -> int:
        """How many blocks of a length there are."""
        ticks = round(average_s / self._tick_s)
        return self._blocks(self._source(ticks), ticks)

    def _blocks(self, level: Level, ticks: int, alike: bool = False) -> int:
        """Blocks of a length so far; those that are `alike` stay, whatever follows."""
        bins = join(level.done or [])
        block, _ = numbered(bins.segment, bins.tick * max(1, level.width) // ticks, bins.count, ticks * self._tick_s / self.step_s, alike)
        return int(block.max(initial=-1)) + 1

    def _source(self, ticks: int) -> Level:
        """The widest level whose bins make up the fine grid of blocks of `ticks`."""
        fine = ticks // FINE_PER_BLOCK
        return [level for level in self._levels if level.done is not None and level.width <= fine and fine % max(1, level.width) == 0][-1]

    def grids(self, average_s: float | None) -> tuple[Bins, np.ndarray, int]:
        """The fine grid and the blocks.

        Args:
            average_s: block length [s], the one given before or one of `AUTO_S`; None for each row its own block.

        Returns:
            T fine samples; (T,) int64 block of each, −1 for none; how many blocks were left out.
        """
        if average_s is None or as_recorded(average_s, self.step_s):
            rows = join(self._levels[0].done or [])
            return rows, np.arange(len(rows)), 0
        ticks = round(average_s / self._tick_s)
        level = self._source(ticks)
        fine, width = join(level.done or []), max(1, level.width)
        if self._merges(ticks // FINE_PER_BLOCK):
            fine, width = merge(fine, ticks // FINE_PER_BLOCK // width), ticks // FINE_PER_BLOCK
        block, thin = numbered(fine.segment, fine.tick * width // ticks, fine.count, average_s / self.step_s)
        return fine, block, thin


def block_means(recording: Recording, average_s: float | None) -> np.ndarray:
    """(N, C) means over the blocks of a length that `auto_length` gave or the recording was made for, the time first; N may be 0."""
    fine, block, _ = recording.grids(average_s)
    kept = block >= 0
    weight = fine.count[kept].astype(float)
    total = np.bincount(block[kept], weight)
    sums = [np.bincount(block[kept], weight * column) for column in fine.mean[kept].T]
    return np.stack(sums, axis=1) / total[:, None]


def auto_length(recordings: Sequence[Recording]) -> float | None:
    """The longest block of which all runs together still have enough; never shorter than the slowest run's step.

    Returns:
        One of `AUTO_S` [s], or None (as recorded) where the rows are farther apart than the longest of them.
    """
    # A step of 1.0000001 s is one of 1 s.
    possible = [length for length in AUTO_S if length >= 0.99 * max(one.step_s for one in recordings)]
    # From the longest on, as bins that only shorter ones would need may have been forgotten.
    enough = (length for length in reversed(possible) if sum(one.blocks(length) for one in recordings) >= ENOUGH_BLOCKS)
    return next(enough, possible[0] if possible else None)
