"""Programs: set points, true rates, presets, and what is refused."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from zoo.catalog import build, names
from zoo.errors import InputError
from zoo.simulator.laboratory.profiles import LEGS_A_PERIOD, campaign, cycle, legs, sine, staircase, tour
from zoo.simulator.laboratory.program import Campaign, Program
from zoo.simulator.laboratory.rate_table import rate_table


def times(*values: float) -> torch.Tensor:
    return torch.tensor(values, dtype=torch.float64)


def test_legs_hold_and_ramp() -> None:
    program = legs([[20, 20, 3600], [20, 60, 2400]]).of(1)
    asked = program.asked(times(0, 1800, 3599, 4800, 6000, 9000))
    assert asked.tolist() == pytest.approx([20, 20, 20, 40, 60, 60])


def test_a_jump_between_legs_is_a_jump() -> None:
    program = legs([[20, 20, 100], [70, 70, 100]]).of(1)
    assert program.asked(times(99.9, 100.0, 100.1)).tolist() == pytest.approx([20, 70, 70])


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
    shortest, longest = {"hui2016": (480, 480), "liu2010": (0, 7 * 86400)}.get(name, (3600, 24 * 3600))
    assert all(shortest <= program.seconds <= longest for program in profile.runs)


def test_the_default_campaign_has_three_programs_with_minor_loops() -> None:
    profile = build("profile", "campaign")
    assert len(set(profile.runs)) == 3
    rates = {round(abs(end - start) / seconds * 60, 2) for start, end, seconds in profile.of(3).legs if end != start}
    assert {0.3, 0.5, 1.0, 2.0} <= rates


PIECES = st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(0.1, 1e3)), min_size=1, max_size=8)


def turning(pieces: list[tuple[float, float]], still_s: float = 0.0) -> Program:
    return Program(((20, 20, sum(seconds for _, seconds in pieces) + still_s),), tuple(pieces))


@given(PIECES, st.integers(1, 50))
def test_the_rows_of_the_rate_add_up_to_the_angle(pieces: list[tuple[float, float]], rows: int) -> None:
    program = turning(pieces)
    step = program.seconds / rows
    rate = program.rate(torch.arange(rows, dtype=torch.float64) * step, step)
    angle = sum(rate * seconds for rate, seconds in pieces)
    assert float(rate.sum() * step) == pytest.approx(angle, abs=1e-9 * sum(abs(rate) * seconds for rate, seconds in pieces) + 1e-9)
    assert float(rate.abs().max()) <= max(abs(rate) for rate, _ in pieces) * (1 + 1e-9) + 1e-6


@given(PIECES)
def test_rows_on_the_pieces_have_their_rates_to_the_last_digit(pieces: list[tuple[float, float]]) -> None:
    whole = [(rate, 0.5 * math.ceil(seconds)) for rate, seconds in pieces]
    program = turning(whole, 3.0)
    time = torch.arange(0, program.seconds, 0.5, dtype=torch.float64)
    assert torch.equal(program.rate(time, 0.5), program.rate(time))
    assert program.rate(time).tolist() == [rate for rate, seconds in whole for _ in range(round(2 * seconds))] + [0.0] * 6


def test_a_row_across_two_pieces_is_their_mean() -> None:
    program = turning([(100.0, 15.0), (-200.0, 10.0)], 20.0)
    assert program.rate(times(0, 10, 20, 30, 40, 100), 10.0).tolist() == pytest.approx([100, -50, -100, 0, 0, 0])


@given(PIECES, st.floats(0.0, 1e3))
def test_backwards_the_rates_come_backwards(pieces: list[tuple[float, float]], still_s: float) -> None:
    program = turning(pieces, still_s)
    backwards = program.reversed()
    edges = [0.0, *(sum(seconds for _, seconds in pieces[:place]) for place in range(1, len(pieces) + 1)), program.seconds]
    middles = times(*((start + end) / 2 for start, end in pairwise(edges) if end - start > 1e-3))
    assert torch.equal(backwards.rate(program.seconds - middles), program.rate(middles))
    assert torch.equal(backwards.reversed().rate(middles), program.rate(middles))


def test_legs_take_rates_in_degrees_per_second() -> None:
    profile = legs([[20, 20, 100]], rates=[[-10, 30], [10, 30]], check=[[30, 30, 50]], check_rates=[[5, 50]])
    assert profile.of(1).rate(times(0, 30, 60)).tolist() == [-36000.0, 36000.0, 0.0]
    assert profile.check.rate(times(0, 49)).tolist() == [18000.0, 18000.0]
    assert legs([[20, 20, 100]], rates=[[-10, 30], [10, 30]]).check.rate(times(0, 40, 70)).tolist() == [0.0, 36000.0, -36000.0]


def test_a_sine_is_one_within_what_its_legs_allow() -> None:
    program = sine(20, 15, 3600, cycles=3, start_s=600).of(1)
    time = torch.arange(0, 600 + 3 * 3600, 1.0, dtype=torch.float64)
    wanted = 20 + 15 * torch.sin(2 * math.pi * (time - 600).clamp_min(0) / 3600)
    off = float((program.asked(time) - wanted).abs().max()) / 15
    assert off == pytest.approx(1 - math.cos(math.pi / LEGS_A_PERIOD), rel=1e-2)
    assert program.seconds == pytest.approx(600 + 3 * 3600)


def test_a_rate_table_turns_only_at_its_levels_after_the_soak() -> None:
    program = rate_table([10, 40, 40, -20], soak_s=1200, rates_dps=[-5, 5], point_s=60, k_per_min=2.0).of(1)
    time = torch.arange(0, program.seconds, 30.0, dtype=torch.float64)
    asked, rate = program.asked(time), program.rate(time, 30.0)
    assert program.seconds == 4 * (1200 + 2 * 60) + 900 + 1800
    assert {round(float(one), 9) for one in asked[rate != 0]} == {10, 40, -20}
    first = (rate == -18000).nonzero()[::2, 0]
    assert all(float(asked[one - 40]) == float(asked[one]) for one in first)
    assert len(first) == 4


def test_liu2010_has_every_rate_at_every_temperature_once_in_rows_of_ten_minutes() -> None:
    profile = build("profile", "liu2010")
    program = profile.of(1)
    time = torch.arange(0, program.seconds, 600.0, dtype=torch.float64)
    asked, rate = program.asked(time), program.rate(time, 600.0) / 3600
    assert program.seconds / 86400 == pytest.approx(6.5, abs=0.1)
    points = [(round(one, 9), round(other, 9)) for one, other in zip(asked.tolist(), rate.tolist(), strict=True) if other != 0]
    assert sorted(points) == [(level, one) for level in range(-30, 61, 5) for one in range(-180, 181, 10) if one]
    assert not set(profile.check.asked(time)[profile.check.rate(time) != 0].tolist()) & {level for level, _ in points}


def test_the_programs_of_the_other_papers() -> None:
    qiu, tong, hui = (build("profile", name) for name in ("qiu2023", "tong2019", "hui2016"))
    assert [leg[:2] for leg in qiu.of(1).legs if leg[0] != leg[1]] == [(-40, -20), (-20, 0), (0, 20), (20, 40), (40, 60)]
    assert qiu.check == qiu.of(1).reversed()
    assert tong.of(1).asked(times(0, 18000, 36000)).tolist() == [-15, 17.5, 50]
    assert tong.check.seconds == 0.6 * tong.of(1).seconds
    assert hui.of(1).seconds == hui.check.seconds == 48 * 10


def test_minor_loops_reverse_within_loops_at_one_rate() -> None:
    program = build("profile", "minor_loops").of(1)
    moves = [(start, end) for start, end, _ in program.legs if start != end]
    spans = [abs(end - start) for start, end in moves]
    shrinking = max(place for place in range(len(spans)) if all(one > other for one, other in pairwise(spans[1 : place + 1])))
    assert shrinking >= 6
    assert {round(abs(end - start) / seconds * 60, 9) for start, end, seconds in program.legs if start != end} == {1.0}


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
    with pytest.raises(InputError, match="cycles"):
        sine(20, 10, 600, cycles=1.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("rates", "words"),
    [
        ([[10, 0]], "positive duration"),
        ([[10, 600], [10, 3001]], "the program only 3600 s"),
        ([["fast", 600]], "two numbers"),
        ([[math.inf, 600]], "two numbers"),
        ([[10]], "two numbers"),
        ([[1e6, 600]], "out of reach"),
        ([10, 600], "list of"),
        ([[]], "list of"),
    ],
)
def test_absurd_rates_are_refused(rates: list[list[float]], words: str) -> None:
    with pytest.raises(InputError, match=words):
        legs([[20, 20, 3600]], rates=rates)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"levels_c": []}, "levels_c"),
        ({"rates_dps": 10}, "rates_dps"),
        ({"soak_s": -1}, "soak_s"),
        ({"point_s": 0}, "point_s"),
        ({"k_per_min": 0}, "K/min"),
    ],
)
def test_absurd_rate_tables_are_refused(changes: dict[str, Any], words: str) -> None:
    table = {"levels_c": [20, 30], "soak_s": 3600, "rates_dps": [-10, 10], "point_s": 600, "k_per_min": 1.0}
    with pytest.raises(InputError, match=words):
        rate_table(**{**table, **changes})
