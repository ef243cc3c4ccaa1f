"""What a gap hides of the temperature, and what of that is judged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from zoo.measurements.gaps import FORGOTTEN_S, UNKNOWN_K, unsettled
from zoo.measurements.read import read_runs
from zoo.measurements.write import write_measurements

STEP_S, NOISE_K = 20.0, 0.02


def chamber(time: np.ndarray) -> np.ndarray:
    """An hour at 20 °C, a ramp of 1 K/min to 60 °C, an hour there, back, and two hours at 20 °C."""
    return np.interp(time / 60, [0, 60, 100, 160, 200, 320], [20, 20, 60, 60, 20, 20])


def cut(begins_min: float, ends_min: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    time = np.arange(0.0, 320 * 60, STEP_S)
    time = time[(time <= begins_min * 60) | (time >= ends_min * 60)]
    noise = NOISE_K * np.random.default_rng(1).normal(size=(len(time), 2))
    return (time > begins_min * 60).astype(int), time, chamber(time)[:, None] + noise


@pytest.mark.parametrize(
    ("begins", "ends", "known"),
    [
        (10, 50, True),  # in a hold
        (65, 95, True),  # in a ramp
        (210, 300, True),  # in a long hold
        (50, 80, False),  # the ramp began
        (90, 120, False),  # it ended
        (55, 105, False),  # from hold to hold: nobody knows when it ran, nor how fast
        (95, 165, False),  # there, and on the way back already
        (99.5, 100.5, True),  # a minute, in which it cannot have gone far
    ],
)
def test_a_gap_matters_where_the_temperature_did_not_go_straight_on(begins, ends, known) -> None:
    segment, time, temperatures = cut(begins, ends)
    lost = unsettled(segment, time, temperatures)
    expected = np.zeros_like(lost) if known else (time >= ends * 60) & (time < ends * 60 + FORGOTTEN_S)
    assert np.array_equal(lost, expected)


def test_one_thermometer_that_turned_is_enough() -> None:
    segment, time, temperatures = cut(50, 80)
    temperatures[:, 1] = 20.0
    assert unsettled(segment, time, temperatures).any()
    assert not unsettled(segment, time, temperatures[:, 1:]).any()


def test_a_corner_hides_as_much_as_its_triangle_is_high() -> None:
    """A ramp of 1 K/min that begins in the middle of a gap of 2·h minutes leaves the straight line by h/2 kelvins."""
    for minutes, told in ((2.2 * UNKNOWN_K, True), (1.8 * UNKNOWN_K, False)):
        time = np.array([*np.arange(-600.0, -60 * minutes, 5), -60 * minutes, 60 * minutes, *np.arange(60 * minutes + 5, 600.0, 5)])
        temperatures = np.maximum(time, 0.0)[:, None] / 60
        assert unsettled((time > 0).astype(int), time, temperatures).any() is np.bool_(told)


def recorded(path: Path, parts: list[tuple[float, float]]) -> Path:
    time = np.concatenate([np.arange(60 * begin, 60 * end, STEP_S) for begin, end in parts])
    chance = np.random.default_rng(2)
    return write_measurements(path, {"time_s": time, "temperature_c": chamber(time), "rate_dph": chance.normal(size=len(time))})


def test_blocks_after_such_a_gap_are_not_judged_and_that_is_told(tmp_path) -> None:
    run = read_runs(recorded(tmp_path / "a.csv", [(0, 50), (80, 320)]), average_s=100.0)[0]
    judged = run.time[run.block >= 0] / 60
    assert not bool(((judged > 51) & (judged < 140)).any())
    assert float(judged.max()) > 318
    assert len(run.time) == 290 * 3, "what comes later still knows the whole past"
    assert run.block.unique().tolist() == list(range(-1, run.blocks))
    assert any("36 block(s) are not judged: nobody knows how the temperature went" in note for note in run.notes)
    whole = read_runs(recorded(tmp_path / "b.csv", [(0, 10), (50, 320)]), average_s=100.0)[0]
    assert not any("nobody knows" in note for note in whole.notes)


def test_where_hardly_anything_would_be_left_all_is_judged_and_that_is_told(tmp_path) -> None:
    run = read_runs(recorded(tmp_path / "a.csv", [(0, 40), (80, 100), (120, 150), (170, 190), (205, 240)]), average_s=100.0)[0]
    assert run.blocks > 80
    assert any("may be wrong for an hour after each" in note for note in run.notes)


def test_a_user_may_say_that_it_is_no_gap(tmp_path) -> None:
    run = read_runs(recorded(tmp_path / "a.csv", [(0, 50), (80, 320)]), average_s=100.0, gap_s=3600.0)[0]
    assert not any("nobody knows" in note for note in run.notes)
