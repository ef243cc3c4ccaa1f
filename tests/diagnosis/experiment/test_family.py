"""Laws that every run of the family obeys."""

from __future__ import annotations

from itertools import pairwise

import pytest

from zoo.diagnosis.experiment.circumstances import Circumstances
from zoo.diagnosis.experiment.family import FASTEST_K_PER_MIN, Candidate, family
from zoo.diagnosis.experiment.prediction import true_input
from zoo.simulator.laboratory.program import Program

LABORATORIES = {
    "wide": Circumstances(-40.0, 60.0, 20.0, 10.0, 10.0, (900.0,), (0.0,)),
    "cold": Circumstances(-40.0, -10.0, -10.0, 0.0, 15.041, (900.0,), (0.0,)),
    "narrow": Circumstances(21.3, 30.9, 21.3, -8.0, -8.0, (900.0,), (0.0,)),
}
CASES = [(known, one) for known in LABORATORIES.values() for one in family(known)]


def named(case: object) -> str | None:
    return case.name if isinstance(case, Candidate) else None


@pytest.mark.parametrize(("known", "one"), CASES, ids=named)
def test_a_chamber_can_run_it(known: Circumstances, one: Candidate) -> None:
    program = Program(one.legs, true_input(one, known))
    low, high = program.range_c
    assert known.low_c - 0.11 <= low <= high <= known.high_c + 0.11  # a sine's mean and swing are rounded to 0.1 K
    assert all(abs(before[1] - after[0]) < 1e-9 for before, after in pairwise(one.legs))
    assert all(abs(end - begin) / seconds * 60 <= FASTEST_K_PER_MIN * 1.01 for begin, end, seconds in one.legs)


@pytest.mark.parametrize(("known", "one"), CASES, ids=named)
def test_the_true_input_begins_and_ends_as_it_is_and_lasts_as_long_as_the_program(known: Circumstances, one: Candidate) -> None:
    if not one.turns:
        return
    assert one.turns[0][0] == 1.0
    assert sum(seconds for _, seconds in one.turns) == pytest.approx(one.seconds)
    assert min(factor for factor, _ in one.turns) < 0 < max(factor for factor, _ in one.turns)


def test_names_are_unique_and_there_is_one_for_every_input() -> None:
    found = family(LABORATORIES["wide"])
    assert len({one.name for one in found}) == len(found)
    assert {one.extra for one in found} == {None, "axis_flip", "rate_table", "power_on"}


def test_nothing_is_turned_that_has_no_true_input() -> None:
    without = Circumstances(-40.0, 60.0, 20.0, 0.0, None, (900.0,), (0.0,))
    assert not any(one.turns for one in family(without))


def test_an_input_beside_the_chamber_costs_more() -> None:
    found = {one.extra: one.effort / one.seconds for one in family(LABORATORIES["wide"])}
    assert found[None] < found["power_on"] < found["axis_flip"] < found["rate_table"]
