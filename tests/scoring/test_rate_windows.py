"""Holds and movements, cut where the rate over ten minutes passes a limit."""

from __future__ import annotations

from itertools import pairwise

import pytest
import torch

from zoo.scoring.rate_windows import rate_windows

STEP_S, RAMP, LIMIT = 100.0, 0.2, 0.09
"""Blocks of 100 s, and ramps [K/min] with a limit just below half of theirs: a turn, which a window sees half of, belongs to the ramp."""


def lengths(*parts: tuple[int, float]) -> list[int]:
    """Blocks of each stage of a course of so many blocks at a rate [K/min] each; the stages follow each other and cover all."""
    rate = torch.cat([torch.full((blocks,), rate, dtype=torch.float64) for blocks, rate in parts])
    time, temperature = STEP_S * torch.arange(len(rate), dtype=torch.float64), 20.0 + (rate * STEP_S / 60).cumsum(0)
    stages = rate_windows(time, temperature, LIMIT)
    assert (stages[0].start, stages[-1].stop) == (0, len(time))
    assert all(one.stop == other.start for one, other in pairwise(stages))
    return [one.stop - one.start for one in stages]


def test_holds_and_ramps_are_stages_up_and_down() -> None:
    assert lengths((36, 0.0), (60, RAMP), (36, 0.0), (60, -RAMP), (36, 0.0)) == [35, 61, 35, 61, 36]


@pytest.mark.parametrize("rate", [0.0, RAMP, -RAMP])
def test_what_moves_all_the_time_or_never_is_one_stage(rate: float) -> None:
    assert lengths((50, rate)) == [50]


def test_the_moment_in_which_a_ramp_turns_is_no_hold() -> None:
    assert lengths((36, 0.0), (40, RAMP), (40, -RAMP), (36, 0.0)) == [35, 81, 36]


@pytest.mark.parametrize(("around", "between", "blocks"), [(RAMP, 0.0, 8), (0.0, RAMP, 6)], ids=["hold", "ramp"])
def test_what_is_shorter_than_ten_minutes_belongs_to_the_stage_before_it(around: float, between: float, blocks: int) -> None:
    """From the centre of its first block to that of its last: seven blocks, of which a ramp has one at its turn more and a hold one less."""
    assert lengths((40, around), (blocks - 1, between), (40, around)) == [79 + blocks]
    _, shortest, _ = lengths((40, around), (blocks, between), (40, around))
    assert STEP_S * (shortest - 1) == 600


@pytest.mark.parametrize(("rest", "stages"), [(2, [42]), (5, [45]), (7, [40, 7])])
def test_so_does_what_the_end_of_the_recording_cuts_off(rest: int, stages: list[int]) -> None:
    assert lengths((40, RAMP), (rest, 0.0)) == stages


def test_the_first_may_be_shorter_for_there_is_none_before_it() -> None:
    assert lengths((4, 0.0), (40, RAMP), (36, 0.0)) == [3, 41, 36]
