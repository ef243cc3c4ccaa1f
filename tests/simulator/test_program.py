"""Chamber programs: set points, the chamber's lag, presets, and what is refused."""

from __future__ import annotations

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from zoo.catalog import build, names
from zoo.errors import InputError
from zoo.simulator.profiles import campaign, cycle, legs, staircase, tour
from zoo.simulator.program import Campaign, Program


def times(*values: float) -> torch.Tensor:
    return torch.tensor(values, dtype=torch.float64)


def test_legs_hold_and_ramp() -> None:
    program = legs([[20, 20, 3600], [20, 60, 2400]]).of(1)
    asked = program.asked(times(0, 1800, 3599, 4800, 6000, 9000))
    assert asked.tolist() == pytest.approx([20, 20, 20, 40, 60, 60])


def test_a_jump_between_legs_is_a_jump() -> None:
    program = legs([[20, 20, 100], [70, 70, 100]]).of(1)
    assert program.asked(times(99.9, 100.0, 100.1)).tolist() == pytest.approx([20, 70, 70])


def test_the_air_follows_a_step_as_a_first_order_lag() -> None:
    time = torch.arange(0, 4000, 1.0, dtype=torch.float64)
    air = legs([[20, 20, 0.5], [60, 60, 4000]]).of(1).air(time, 120.0)
    assert air[121] == pytest.approx(60 - 40 * math.exp(-1), abs=0.2)
    assert air[-1] == pytest.approx(60.0)


def test_after_a_hold_the_air_has_the_wanted_temperature() -> None:
    program = legs([[20, 20, 3600], [20, 60, 2400], [60, 60, 3600]]).of(1)
    air = program.air(torch.arange(0, 9601, 10.0, dtype=torch.float64), 120.0)
    assert air[:361].tolist() == pytest.approx([20.0] * 361)
    assert float(air[-1]) == pytest.approx(60.0, abs=1e-9)


def test_the_ramp_of_the_air_is_late_by_the_chambers_time_constant() -> None:
    air = legs([[0, 100, 6000]]).of(1).air(torch.arange(0, 6001, 10.0, dtype=torch.float64), 120.0)
    assert float(air[-1]) == pytest.approx(100 - 120 / 60, abs=1e-6)


@given(st.lists(st.tuples(st.floats(-100, 100), st.floats(-100, 100), st.floats(1, 1e5)), min_size=1, max_size=8))
def test_backwards_twice_is_forwards(rows: list[tuple[float, float, float]]) -> None:
    program = Program(tuple(rows))
    assert program.reversed().reversed() == program
    assert program.reversed().range_c == program.range_c


def test_staircase_of_qiu2023() -> None:
    program = staircase(-40, 60, 20, 0.2, 3600).of(1)
    assert len(program.legs) == 11
    assert program.seconds == pytest.approx(6 * 3600 + 100 / 0.2 * 60)
    assert program.legs[1] == (-40, -20, 6000.0)


def test_cycle_ends_where_it_starts() -> None:
    program = cycle(-40, 60, 20, 1.0, 3600, cycles=2).of(1)
    assert program.legs[0][0] == program.legs[-1][1] == 20
    assert program.range_c == (-40, 60)


def test_every_run_of_a_campaign_has_its_program_and_more_runs_start_again() -> None:
    first, second, check = cycle(0, 40, 20, 1.0, 600), tour(10, [[30, 1.0, 0]]), staircase(0, 20, 10, 1.0, 600)
    both = campaign([first, second], check)
    assert both.of(1) == both.of(3) == first.of(1)
    assert both.of(2) == second.of(1)
    assert both.check == check.of(1)


@pytest.mark.parametrize("name", names("profile"))
def test_every_preset_is_a_campaign_whose_check_is_another_program(name: str) -> None:
    profile = build("profile", name)
    assert isinstance(profile, Campaign)
    assert profile.check not in profile.runs
    assert all(3600 < program.seconds < 24 * 3600 for program in profile.runs)


def test_the_default_campaign_has_three_programs_with_minor_loops() -> None:
    profile = build("profile", "campaign")
    assert len(set(profile.runs)) == 3
    rates = {round(abs(end - start) / seconds * 60, 2) for start, end, seconds in profile.of(3).legs if end != start}
    assert {0.3, 0.5, 1.0, 2.0} <= rates


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([[20, 60, -5]], "positive duration"),
        ([[20, 60, 0]], "positive duration"),
        ([[20, -300, 60]], "absolute zero"),
        ([[20, math.nan, 60]], "three numbers"),
        ([[20, 60]], "three numbers"),
        ([[20, "hot", 60]], "three numbers"),
        ([], "no legs"),
        ([20, 60, 3600], "list of"),
        ("20", "list of"),
        ([[20, 60, 1e12]], "100 days"),
    ],
)
def test_absurd_legs_are_refused(rows: list[list[float]], words: str) -> None:
    with pytest.raises(InputError, match=words):
        legs(rows)


def test_absurd_presets_are_refused() -> None:
    with pytest.raises(InputError, match="K/min"):
        tour(20, [[30, 0, 600]])
    with pytest.raises(InputError, match="low_c < high_c"):
        staircase(60, -40, 20, 1.0, 600)
    with pytest.raises(InputError, match="steps"):
        staircase(-40, 60, 1e-6, 1.0, 600)
    with pytest.raises(InputError, match="cycles"):
        cycle(-40, 60, 20, 1.0, 600, cycles=0)
    with pytest.raises(InputError, match="empty"):
        campaign([], cycle(-40, 60, 20, 1.0, 600))
