"""Streaming rows into nested bins: nothing is lost, nothing is kept that is not needed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from zoo.measurements.binning import Bins, Level, join, merge
from zoo.measurements.recording import ENOUGH_BLOCKS, Recording, auto_length, numbered


def bins(count: int, seed: int = 0) -> Bins:
    random = np.random.default_rng(seed)
    tick = np.cumsum(random.integers(0, 3, count))
    return Bins(np.arange(count) // (count // 3), tick, random.normal(size=(count, 2)), random.integers(1, 5, count))


@pytest.mark.parametrize("pieces", [1, 2, 7, 100])
@pytest.mark.parametrize("count", [3, 40, 601, 1_017])
def test_a_chain_of_levels_gives_what_merging_everything_gives(count: int, pieces: int) -> None:
    rows = bins(count)
    levels = [Level(1, 0), Level(10, 1), Level(100, 10)]
    cuts = np.linspace(0, count, pieces + 1).astype(int)
    for start, end in pairwise(cuts):
        parts = rows[start:end]
        for level in levels:
            parts = level.push(parts)
    last: Bins | None = None
    for level in levels:
        last = level.close(last)
    for level in levels:
        done, whole = join(level.done or []), merge(rows, level.width)
        assert np.array_equal(done.segment, whole.segment)
        assert np.array_equal(done.tick, whole.tick)
        assert np.array_equal(done.count, whole.count)
        assert np.allclose(done.mean, whole.mean, atol=1e-12)


def test_merging_weighs_by_rows() -> None:
    merged = merge(Bins(np.zeros(3, int), np.array([0, 1, 2]), np.array([[1.0], [4.0], [9.0]]), np.array([3, 1, 5])), 2)
    assert merged.mean.tolist() == [[1.75], [9.0]]
    assert merged.count.tolist() == [4, 5]


def test_blocks_are_numbered_without_the_thin_ones() -> None:
    segment, tick = np.array([0, 0, 0, 0, 1, 1]), np.array([0, 0, 1, 2, 0, 0])
    block, thin = numbered(segment, tick, np.array([5, 5, 4, 5, 2, 3]), expected=10)
    assert block.tolist() == [0, 0, -1, 1, 2, 2]
    assert thin == 1


def test_a_recorder_that_writes_less_often_later_has_no_thin_blocks() -> None:
    """An hour at a row a second, then one at a row in ten; and a block in the middle that lost most of its rows."""
    tick = np.repeat(np.arange(72), [*[100] * 30, 20, *[100] * 5, *[10] * 36])
    rows = np.ones_like(tick)
    block, thin = numbered(np.zeros_like(tick), tick, rows, expected=100)
    assert thin == 1
    assert (block[tick == 30] == -1).all()
    assert block[-1] == 70


def stream(rows: int, step: float, chunk: int = 7_000) -> Recording:
    recording = Recording(step, "auto", 5 * step)
    for start in range(0, rows, chunk):
        time = np.arange(start, min(rows, start + chunk)) * step
        recording.push(np.column_stack([time, np.sin(time)]))
    recording.close()
    return recording


@pytest.mark.parametrize("step", [0.005, 0.04, 0.4])
@pytest.mark.parametrize(("seconds", "bins_a_second", "length"), [(3_900, 11.2, 5.0), (30_000, 1.2, 50.0), (60_000, 0.11, 100.0)])
def test_what_is_kept_follows_the_duration_and_not_the_rate(step: float, seconds: int, bins_a_second: float, length: float) -> None:
    """Up to 4000 s tenths of a second may be needed, up to 40 000 s seconds, then nothing below ten seconds."""
    recording = stream(int(seconds / step), step)
    assert recording.held <= bins_a_second * seconds
    assert auto_length([recording]) == length
    fine, block, _ = recording.grids(length)
    assert fine.count.sum() == recording.rows == int(seconds / step)
    assert block.max() + 1 >= ENOUGH_BLOCKS
