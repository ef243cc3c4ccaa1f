"""Relaxation at a changing speed: closed forms, an independent integrator, order of convergence."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
import torch
from scipy.integrate import solve_ivp
from torch import Tensor

from zoo.physics.relaxation import arrhenius, elapsed, maxwell, shifted


def scalar(value: float) -> Tensor:
    return torch.tensor([value], dtype=torch.float64)


def uneven(count: int, longest: float) -> Tensor:
    """Increasing times from 0 with steps between 0.1 s and `longest`."""
    steps = 0.1 + (longest - 0.1) * torch.rand(count, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    return torch.cumsum(steps, 0) - steps[0]


def test_at_a_constant_speed_a_ramp_is_exact_for_any_sampling() -> None:
    time = uneven(400, 90.0)
    found = maxwell(time, 5 + 0.01 * time, torch.full_like(time, 1 / 700))
    torch.testing.assert_close(found, -0.01 * 700 * torch.expm1(-time / 700), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("speed", [0.0, 1e-14, 1e6])
def test_extremes_neither_relax_nor_keep_anything(speed) -> None:
    time = uneven(100, 90.0)
    drive = torch.sin(time / 1000)
    found = maxwell(time, drive, torch.full_like(time, speed))
    expected = drive - drive[0] if speed < 1 else torch.zeros_like(drive)
    torch.testing.assert_close(found, expected, rtol=0, atol=1e-8)


def error(steps: int) -> float:
    """Largest difference from scipy for a speed that follows a sine over an order of magnitude."""

    def rate(t: float) -> float:
        return 1e-3 * 10 ** math.sin(t / 900)

    def drive_rate(t: float) -> float:
        return math.cos(t / 500) / 500

    time = torch.linspace(0, 9000, steps + 1, dtype=torch.float64)
    solved = solve_ivp(lambda t, s: drive_rate(t) - rate(t) * s, (0, 9000), [0.0], t_eval=time.numpy(), method="DOP853", rtol=1e-12, atol=1e-14)
    found = maxwell(time, torch.sin(time / 500), torch.tensor([rate(float(t)) for t in time], dtype=torch.float64))
    return float((found - torch.tensor(solved.y[0])).abs().max())


def test_a_changing_speed_is_followed_in_second_order() -> None:
    errors = [error(steps) for steps in (200, 400, 800)]
    assert errors[-1] < 1e-4
    assert all(coarse / fine == pytest.approx(4, rel=0.05) for coarse, fine in pairwise(errors))


def test_what_relaxes_within_a_step_follows_the_speed_at_its_end() -> None:
    """Quasi-steady, s = (du/dt)/v, off by the square of half the change of ln v within a step."""
    time = torch.arange(0, 3000, 30.0, dtype=torch.float64)
    speed = 10.0 * torch.exp(time / 300)
    found = maxwell(time, 0.02 * time, speed)
    torch.testing.assert_close(found[1:] * speed[1:], torch.full_like(time[1:], 0.02), rtol=0.1**2 / 4 + 5e-4, atol=0)


def test_a_batch_is_each_by_itself() -> None:
    time = uneven(200, 30.0)
    drive = torch.stack([torch.sin(time / 100), torch.cos(time / 70), time / 500])
    speed = torch.tensor([[1e-2], [1e-3], [1e-4]], dtype=torch.float64) * (1 + 0.5 * torch.sin(time / 300))
    both = maxwell(time, drive, speed)
    for row in range(3):
        torch.testing.assert_close(both[row], maxwell(time, drive[row], speed[row]), rtol=1e-12, atol=1e-12)
    torch.testing.assert_close(maxwell(time, drive[0], speed)[1], maxwell(time, drive[0], speed[1]), rtol=1e-12, atol=1e-12)


def test_gradients_are_those_of_finite_differences() -> None:
    time = uneven(20, 30.0)
    drive, speed = torch.sin(time / 60).requires_grad_(), (0.01 + 0.005 * torch.cos(time / 80)).requires_grad_()
    assert torch.autograd.gradcheck(lambda u, v: maxwell(time, u, v), (drive, speed))
    shape = torch.tensor([40e3, 3.0], dtype=torch.float64, requires_grad=True)
    celsius = torch.linspace(-80, 120, 9, dtype=torch.float64)
    assert torch.autograd.gradcheck(lambda one: arrhenius(celsius, one[:1]) + shifted(celsius, one[1:]), (shape,))


def test_speeds_are_one_at_20_degrees_and_grow_as_declared() -> None:
    celsius = torch.tensor([20.0, 30.0, -40.0], dtype=torch.float64)
    activated = arrhenius(celsius, scalar(50e3))
    assert activated.tolist() == pytest.approx([1.0, 1.96735, 0.0050969], rel=1e-5), "about twice in 10 K; with E/R = 6013.62 K"
    torch.testing.assert_close(
        shifted(celsius, scalar(5.0)), torch.tensor([1.0, 10 ** (0.5 * 293.15 / 303.15), 10 ** (-3 * 293.15 / 233.15)], dtype=torch.float64)
    )
    assert bool(torch.isfinite(arrhenius(torch.tensor([-300.0, 1e4], dtype=torch.float64), scalar(90e3))).all())


def test_elapsed_time_is_an_integral_from_the_first_sample() -> None:
    time = uneven(50, 10.0)
    torch.testing.assert_close(elapsed(time, torch.full((2, 50), 3.0, dtype=torch.float64)), (3 * time).expand(2, -1))
    torch.testing.assert_close(elapsed(time, time), time**2 / 2)
