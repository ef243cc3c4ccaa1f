"""The Earth's rotation as a gyro at rest sees it."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zoo.errors import InputError
from zoo.simulator.laboratory.earth import AXES, earth_rate

LATITUDES = st.floats(-90, 90)
STELLAR_DAY_S = 86164.098904
"""One turn against the stars (IERS)."""


def test_at_the_pole_it_is_one_turn_in_a_stellar_day() -> None:
    assert earth_rate(90, "up") == pytest.approx(360 * 3600 / STELLAR_DAY_S, rel=1e-7)
    assert earth_rate(-90, "up") == pytest.approx(-360 * 3600 / STELLAR_DAY_S, rel=1e-7)


def test_on_the_equator_only_the_north_sees_it() -> None:
    assert earth_rate(0, "north") == pytest.approx(15.041, abs=1e-3)
    assert earth_rate(0, "up") == earth_rate(0, "east") == 0.0


def test_at_39_degrees_north() -> None:
    assert earth_rate(39.0, "up") == pytest.approx(9.4656, abs=1e-3)
    assert earth_rate(39.0, "north") == pytest.approx(11.6891, abs=1e-3)


@given(LATITUDES)
def test_three_axes_at_right_angles_see_all_of_it(latitude: float) -> None:
    seen = [earth_rate(latitude, axis) for axis in ("east", "north", "up")]
    assert seen[0] == 0.0
    assert math.hypot(*seen) == pytest.approx(360 * 3600 / STELLAR_DAY_S, rel=1e-7)


@given(LATITUDES)
def test_turned_around_it_changes_sign(latitude: float) -> None:
    for axis, other in (("up", "down"), ("north", "south"), ("east", "west")):
        assert earth_rate(latitude, axis) == -earth_rate(latitude, other)
    assert earth_rate(latitude, "up") == -earth_rate(-latitude, "up")


@given(LATITUDES, st.tuples(*[st.floats(-10, 10)] * 3).filter(lambda axis: math.hypot(*axis) > 1e-3), st.floats(1e-3, 1e3))
def test_the_projection_is_linear_in_the_direction_and_blind_to_the_length(latitude: float, axis: tuple[float, ...], size: float) -> None:
    named = [earth_rate(latitude, name) for name in ("east", "north", "up")]
    wanted = sum(one * rate for one, rate in zip(axis, named, strict=True)) / math.hypot(*axis)
    assert earth_rate(latitude, axis) == pytest.approx(wanted, abs=1e-9)
    assert earth_rate(latitude, [size * one for one in axis]) == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("name", AXES)
def test_a_name_is_its_vector(name: str) -> None:
    assert earth_rate(52.0, name) == earth_rate(52.0, list(AXES[name]))


@pytest.mark.parametrize("latitude", [90.1, -91, math.nan, math.inf, "north", None, True])
def test_absurd_latitudes_are_refused(latitude: Any) -> None:
    with pytest.raises(InputError, match="latitude_deg"):
        earth_rate(latitude, "up")


@pytest.mark.parametrize("axis", [[0, 0, 0], [1, 0], [1, 0, math.nan], [1, 0, "up"], 3.0, None, [True, 0, 0], ""])
def test_absurd_axes_are_refused(axis: Any) -> None:
    with pytest.raises(InputError, match="axis="):
        earth_rate(45.0, axis)


def test_a_mistyped_axis_gets_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean north"):
        earth_rate(45.0, "nort")
