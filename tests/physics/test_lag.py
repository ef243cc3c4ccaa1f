"""A first-order lag is solved exactly for any sampling."""

from __future__ import annotations

from itertools import pairwise

import pytest
import torch
from torch import Tensor

from zoo.physics.lag import behind, lagged, lagged_rate


def uneven(count: int, longest: float, seed: int = 0) -> Tensor:
    """Increasing times from 0 with steps between 0.1 s and `longest`."""
    steps = 0.1 + (longest - 0.1) * torch.rand(count, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return torch.cumsum(steps, 0) - steps[0]


def scalar(value: float) -> Tensor:
    return torch.tensor(value, dtype=torch.float64)


@pytest.mark.parametrize("tau", [1.0, 30.0, 2000.0])
def test_a_ramp_is_exact(tau: float) -> None:
    """From rest: x = u − sτ(1 − exp(−t/τ)) for a ramp of slope s."""
    time = uneven(300, 20.0)
    expected = 5 + 0.02 * (time + tau * torch.expm1(-time / tau))
    assert torch.allclose(lagged(time, 5 + 0.02 * time, scalar(tau)), expected, rtol=1e-11)


@pytest.mark.parametrize("steps", [torch.full((300,), 7.0, dtype=torch.float64), torch.diff(uneven(301, 20.0))], ids=["even", "uneven"])
def test_in_a_steady_ramp_it_is_behind_by_its_time_constant(steps: Tensor) -> None:
    """At another place than the drive's from the start, it forgets that: e = sτ + (e0 − sτ)·exp(−t/τ)."""
    time = torch.cat([torch.zeros(1, dtype=torch.float64), steps.cumsum(0)])
    tau, start = torch.tensor([30.0, 2000.0], dtype=torch.float64), torch.tensor([5.0, 17.0], dtype=torch.float64)
    steady = (0.02 * tau).unsqueeze(1)
    expected = steady + (5.0 - start.unsqueeze(1) - steady) * torch.exp(-time / tau.unsqueeze(1))
    torch.testing.assert_close(behind(time, 5 + 0.02 * time, tau, start), expected, rtol=1e-11, atol=1e-11)


def test_a_step_is_exact() -> None:
    time = uneven(300, 20.0)
    state = lagged(time, torch.ones_like(time), scalar(50.0), start=scalar(0.0))
    assert torch.allclose(state, -torch.expm1(-time / 50), rtol=1e-12)


def sine_error(time: Tensor, tau: float, omega: float) -> float:
    """Largest difference from the closed form for a sine that starts at rest."""
    settled = torch.sin(omega * time) - omega * tau * torch.cos(omega * time)
    expected = (settled + omega * tau * torch.exp(-time / tau)) / (1 + (omega * tau) ** 2)
    return float((lagged(time, torch.sin(omega * time), scalar(tau)) - expected).abs().max())


def test_a_sine_is_followed_to_the_error_of_straight_lines_and_in_second_order() -> None:
    """Lines between samples h apart miss a sine by (ωh)²/8 at most, and a lag is an average: it cannot miss by more."""
    time, errors = uneven(2000, 4.0), []
    for _ in range(4):
        errors.append(sine_error(time, 40.0, 0.05))
        assert errors[-1] <= (0.05 * float(torch.diff(time).max())) ** 2 / 8
        time = torch.cat([time, (time[1:] + time[:-1]) / 2]).sort().values
    assert all(coarse / fine == pytest.approx(4, rel=0.02) for coarse, fine in pairwise(errors))


def test_refining_a_piecewise_linear_drive_changes_nothing() -> None:
    time = uneven(100, 80.0)
    drive = torch.randn(100, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    middle = (time[1:] + time[:-1]) / 2
    finer, order = torch.cat([time, middle]).sort()
    refined = torch.cat([drive, (drive[1:] + drive[:-1]) / 2])[order]
    again = lagged(finer, refined, scalar(30.0))[torch.searchsorted(finer, time)]
    assert torch.allclose(again, lagged(time, drive, scalar(30.0)), atol=1e-13)


def test_it_agrees_with_small_euler_steps() -> None:
    """Against an independent and slower way to solve the same equation."""
    time, tau, parts = uneven(40, 5.0), 7.0, 4000
    drive = torch.cos(time)
    state, states = float(drive[0]), [float(drive[0])]
    for k in range(1, len(time)):
        step = float(time[k] - time[k - 1]) / parts
        for part in range(parts):
            forced = float(drive[k - 1]) + (part + 0.5) / parts * float(drive[k] - drive[k - 1])
            state += step / tau * (forced - state) / (1 + step / tau / 2)
        states.append(state)
    assert torch.allclose(lagged(time, drive, scalar(tau)), torch.tensor(states, dtype=torch.float64), atol=1e-8)


def test_batches_follow_their_own_time_constant() -> None:
    time, tau = uneven(200, 5.0), torch.tensor([[1.0], [10.0], [100.0]], dtype=torch.float64)
    drive = torch.stack([torch.sin(time / 20), time])
    both = lagged(time, drive, tau.expand(3, 2))
    for row in range(3):
        for column in range(2):
            assert torch.allclose(both[row, column], lagged(time, drive[column], tau[row, 0]), atol=1e-12)


def test_the_lagged_rate_jumps_by_a_step_over_tau() -> None:
    time = torch.arange(0, 600, 0.01, dtype=torch.float64)
    rate = lagged_rate(time, torch.where(time >= 100, 0.0625, 0.0).to(torch.float64), scalar(60.0))
    assert float(rate.max()) == pytest.approx(0.0625 / 60, rel=1e-3)
    assert float(rate.max()) <= 0.0625 / 60


def test_gradients_are_those_of_finite_differences() -> None:
    time = uneven(30, 5.0)
    drive = torch.sin(time).requires_grad_()
    tau = torch.tensor([3.0, 30.0], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda u, t: lagged(time, u.expand(2, -1), t), (drive, tau))


@pytest.mark.parametrize("odd", [1, 60, 119])
def test_a_step_that_is_not_like_the_others_changes_nothing_before_it(odd) -> None:
    time = 20.0 * torch.arange(120, dtype=torch.float64)
    drive, taus = torch.sin(time / 200.0), torch.tensor([5.0, 80.0, 900.0], dtype=torch.float64)
    even = lagged(time, drive, taus)
    late = lagged(torch.cat([time[:odd], time[odd:] - 7.0]), drive, taus)
    torch.testing.assert_close(late[:, :odd], even[:, :odd], rtol=1e-12, atol=1e-14)
    ratio = 13.0 / taus
    mean = -torch.expm1(-ratio) / ratio
    expected = torch.exp(-ratio) * late[:, odd - 1] + (mean - torch.exp(-ratio)) * drive[odd - 1] + (1 - mean) * drive[odd]
    torch.testing.assert_close(late[:, odd], expected, rtol=1e-12, atol=1e-14)
