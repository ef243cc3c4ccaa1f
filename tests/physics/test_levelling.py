"""Attitude from gravity: against rotation matrices, against its own inverse, and how errors pass through."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.physics.levelling import attitude, specific_force


def degrees(*values: float) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)


def grid() -> tuple[Tensor, Tensor]:
    pitch, roll = torch.meshgrid(
        torch.linspace(-89, 89, 179, dtype=torch.float64), torch.linspace(-179, 180, 360, dtype=torch.float64), indexing="ij"
    )
    return pitch, roll


def test_it_inverts_the_specific_force() -> None:
    pitch, roll = grid()
    found = attitude(specific_force(pitch, roll))
    assert torch.allclose(found[0], pitch, rtol=0, atol=1e-12)
    assert torch.allclose(found[1], roll, rtol=0, atol=1e-12)


def test_neither_the_unit_nor_the_size_of_gravity_matters() -> None:
    pitch, roll = grid()
    for size in (9.7803, 9.8322, 1e6, 4000.0):
        assert torch.allclose(attitude(size * specific_force(pitch, roll))[1], roll, rtol=0, atol=1e-12)


def test_the_force_is_the_vertical_turned_by_roll_after_pitch_after_heading() -> None:
    """Against the product of three rotation matrices; the heading drops out."""
    pitch, roll, heading = (math.radians(one) for one in (17.0, -64.0, 123.0))
    about_z = degrees(math.cos(heading), -math.sin(heading), 0, math.sin(heading), math.cos(heading), 0, 0, 0, 1).reshape(3, 3)
    about_x = degrees(1, 0, 0, 0, math.cos(pitch), -math.sin(pitch), 0, math.sin(pitch), math.cos(pitch)).reshape(3, 3)
    about_y = degrees(math.cos(roll), 0, math.sin(roll), 0, 1, 0, -math.sin(roll), 0, math.cos(roll)).reshape(3, 3)
    body_to_earth = about_z @ about_x @ about_y
    assert torch.allclose(specific_force(degrees(17.0)[0], degrees(-64.0)[0]), body_to_earth.T @ degrees(0, 0, 1), atol=1e-15)


def test_signs() -> None:
    nose_up, right_side_down = specific_force(degrees(30.0, 0.0), degrees(0.0, 30.0))
    assert torch.allclose(nose_up, degrees(0, 0.5, math.sqrt(0.75)))
    assert torch.allclose(right_side_down, degrees(-0.5, 0, math.sqrt(0.75)))


def test_it_is_groves_in_other_axes() -> None:
    pitch, roll = grid()
    right, forward, up = specific_force(pitch, roll).unbind(-1)
    x, y, z = forward, right, -up
    assert torch.allclose(torch.rad2deg(torch.atan2(-y, -z)), roll, atol=1e-12)
    assert torch.allclose(torch.rad2deg(torch.atan(x / (y**2 + z**2).sqrt())), pitch, atol=1e-12)


@pytest.mark.parametrize(("axis", "angle", "sign"), [(0, 1, -1.0), (1, 0, 1.0)])
def test_87_ug_of_a_level_axis_are_five_thousandths_of_a_degree(axis: int, angle: int, sign: float) -> None:
    force = degrees(0, 0, 1)
    force[axis] += 87.3e-6
    found = attitude(force)
    assert float(found[angle]) == pytest.approx(sign * 0.005, rel=1e-3)
    assert float(found[1 - angle]) == 0


def test_an_error_along_the_vertical_does_nothing_and_gains_are_those_of_the_derivative() -> None:
    pitch, roll = degrees(20.0)[0], degrees(-35.0)[0]
    force = specific_force(pitch, roll)
    slopes = torch.stack(torch.autograd.functional.jacobian(attitude, force))
    assert torch.allclose(slopes @ force, torch.zeros(2, dtype=force.dtype), atol=1e-13)
    assert float(slopes[0].norm()) == pytest.approx(180 / math.pi)
    assert float(slopes[1].norm()) == pytest.approx(180 / math.pi / math.cos(math.radians(20)))


def test_free_fall_has_no_attitude() -> None:
    with pytest.raises(InputError, match="free fall"):
        attitude(torch.zeros(4, 3))
