"""What depends on how long ago and how hot: relaxing stress, drying, a potting that softens."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from scipy.integrate import solve_ivp
from torch import Tensor

from zoo.catalog import build
from zoo.effects.base import History
from zoo.effects.earlier import before_each
from zoo.effects.moisture import diffusing


def shape_of(*values: float) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)


def columns(name: str, history: History, *shape: float) -> Tensor:
    return build("effects", name).columns(history, shape_of(*shape))


@pytest.fixture
def at(seen, warped):
    """Makes a history from a course of the coil's temperature (T,) at times (T,)."""
    return lambda time, temperature: warped(seen(build("effects", "mohr")), time, temperature)


# Viscoelastic


def test_a_branch_in_a_steady_ramp_relaxes_as_the_closed_form(at) -> None:
    """Stress rτ(1 − e^(−t/τ)), so that the column is r·(1 − e^(−t/τ))."""
    time = torch.arange(0, 36000, 60.0, dtype=torch.float64)
    found = columns("viscoelastic", at(time, 20 + 0.5 * time / 60), 2.0, 0.0, 0.0, 0.0)[:, 0]
    torch.testing.assert_close(found, -0.5 * torch.expm1(-time / 7200), rtol=0, atol=1e-13)


def test_a_strained_branch_in_a_hold_decays_faster_when_hot(at) -> None:
    time = torch.arange(0, 36000, 60.0, dtype=torch.float64)
    for end, tau_h in ((60.0, 2.0 * 10 ** (-3 * 0.4 * 293.15 / 333.15)), (-20.0, 2.0 * 10 ** (3 * 0.4 * 293.15 / 253.15))):
        course = 20 + (end - 20) * (time / 1200).clamp_max(1.0)
        found = columns("viscoelastic", at(time, course), 2.0, 3.0, 0.0, 0.0)[:, 0]
        assert float(found[100]) * (end - 20) > 0
        assert float(found[130] / found[100]) == pytest.approx(math.exp(-30 * 60 / 3600 / tau_h), rel=1e-10)


@pytest.mark.parametrize(("time_h", "shift"), [(2.0, 3.0), (0.3, 6.0), (8.0, 8.0)])
def test_a_branch_in_a_ramp_agrees_with_an_integrator(time_h, shift, at) -> None:
    """ds/dt = dT/dt − s/τ(T) by scipy, an independent way, for a τ that changes by orders of magnitude."""

    def speed(celsius: float) -> float:
        return 10 ** (shift * (celsius - 20) / 100 * 293.15 / (celsius + 273.15)) / (3600 * time_h)

    time = torch.arange(0, 5 * 3600 + 1, 10.0, dtype=torch.float64)
    slope = 120 / (5 * 3600)
    solved = solve_ivp(
        lambda t, s: slope - s * speed(-20 + slope * t), (0, 18000), [0.0], t_eval=time.numpy(), method="LSODA", rtol=1e-10, atol=1e-12
    )
    course = -20 + slope * time
    expected = torch.tensor(solved.y[0]) * torch.tensor([speed(float(one)) for one in course]) * 60
    found = columns("viscoelastic", at(time, course), time_h, shift, 0.0, 0.0)[:, 0]
    torch.testing.assert_close(found, expected, rtol=0, atol=1e-4 * float(expected.max()))


def test_a_fast_branch_and_what_a_slow_one_leaves_are_mohrs_effect(at) -> None:
    """τ → 0: s/τ → dT/dt. τ → ∞: ds/dt = dT/dt − s/τ → dT/dt."""
    time = torch.arange(0, 36000, 10.0, dtype=torch.float64)
    history = at(time, 20 + 15 * torch.sin(time / 5000))
    rate = 15 / 5000 * 60 * torch.cos(time / 5000)
    fast = columns("viscoelastic", history, 1e-3, 0.0, 0.0, 0.0)[:, 0]
    torch.testing.assert_close(fast[50:], rate[50:], rtol=0, atol=2e-3 * float(rate.max()))
    slow = history.rate - columns("viscoelastic", history, 1e6, 3.0, 0.0, 0.0)[:, 0]
    torch.testing.assert_close(slow, columns("mohr", history)[:, 0], rtol=0, atol=1e-6)


def test_the_second_branch_is_one_six_times_as_fast(seen) -> None:
    history = seen(build("effects", "viscoelastic"))
    first, second = (columns("viscoelastic", history, time_h, 3.0, 0.0, 0.0) for time_h in (2.4, 0.4))
    torch.testing.assert_close(first[:, 1], second[:, 0], rtol=1e-12, atol=1e-14)
    assert float((first[:, 0] - first[:, 1]).abs().max()) > 0.1 * float(first[:, 1].abs().max())


def test_the_stress_itself_is_what_relaxes_at_a_time_that_stays(seen) -> None:
    """At one τ the two are one curve; where τ falls by decades as it gets hot they are not. Hardly relaxed, the stress is the warming since then."""
    history = seen(build("effects", "viscoelastic"))
    rate, stress = (columns("viscoelastic", history, 2.0, 0.0, of, 0.0) for of in (0.0, 1.0))
    torch.testing.assert_close(stress, rate)
    rate, stress = (columns("viscoelastic", history, 2.0, 4.0, of, 0.0) for of in (0.0, 1.0))
    torch.testing.assert_close(stress * 10 ** (0.04 * (history.temperature - 20.0) * 293.15 / (history.temperature + 273.15)).unsqueeze(-1), rate)
    assert float(torch.corrcoef(torch.stack([stress[:, 0], rate[:, 0]]))[0, 1]) < 0.9
    slow = 60e9 * columns("viscoelastic", history, 1e9, 3.0, 1.0, 0.0)[:, 0]
    torch.testing.assert_close(slow, history.temperature - history.temperature[0], rtol=0, atol=1e-4)


@pytest.mark.parametrize("start", [-30.0, 10.0, 50.0])
@pytest.mark.parametrize("of_stress", [0.0, 1.0])
def test_with_a_past_it_begins_as_if_it_had_just_come_from_room_temperature(start, of_stress, at) -> None:
    """Of which nothing has relaxed, for p = 1: as behind a jump from there, of a millionth of a second."""
    time = torch.arange(0, 36000, 60.0, dtype=torch.float64)
    course = start + 20 * torch.sin(time / 7000)
    jumped = at(torch.cat([time[:1] - 1e-6, time]), torch.cat([course[:1].clamp(15.0, 25.0), course]))
    expected = columns("viscoelastic", jumped, 2.0, 3.0, of_stress, 0.0)[1:]
    torch.testing.assert_close(columns("viscoelastic", at(time, course), 2.0, 3.0, of_stress, 1.0), expected, rtol=1e-6, atol=1e-9)


def test_what_is_left_of_a_past_is_the_less_the_hotter_the_start(at) -> None:
    """The share p at 20 °C, nearly all at a cold start and next to nothing at a hot one; and of the fast branch, less."""
    time = torch.arange(0, 36000, 60.0, dtype=torch.float64)
    left = []
    for start in (-40.0, 0.0, 60.0):
        whole, half = (columns("viscoelastic", at(time, torch.full_like(time, start)), 2.0, 4.0, 0.0, past)[0] for past in (1.0, 0.5))
        left.append(half / whole)
    cold, cool, hot = left
    assert float(cold[0]) > 0.99
    assert float(cold[0]) > float(cool[0]) > float(hot[0])
    assert float(hot[0]) < 0.05
    assert all(float(one[1]) < float(one[0]) for one in left)
    torch.testing.assert_close(cool[0], torch.tensor(1 / (1 + 10 ** (-0.8 * 293.15 / 273.15))).double())


def test_a_past_may_be_the_run_before(at) -> None:
    """From where that ended: with nothing relaxed, as behind a jump from there; nothing where it ended at the start."""
    time = torch.arange(0, 36000, 60.0, dtype=torch.float64)
    runs = [at(time, 20 + (end - 20) * time / time[-1]) for end in (55.0, -30.0)]
    told = build("effects", "viscoelastic").after(before_each([(one.time, one.temperature) for one in runs]))
    second = replace(at(time, -10 + 5 * torch.sin(time / 3000)), run=2)
    jumped = at(torch.cat([time[:1] - 1e-6, time]), torch.cat([second.temperature.new_tensor([55.0]), second.temperature]))
    found = told.columns(second, shape_of(2.0, 3.0, 0.0, -1.0))
    torch.testing.assert_close(found, columns("viscoelastic", jumped, 2.0, 3.0, 0.0, 0.0)[1:], rtol=1e-6, atol=1e-9)
    torch.testing.assert_close(told.columns(second, shape_of(2.0, 3.0, 0.0, 0.0)), columns("viscoelastic", second, 2.0, 3.0, 0.0, 0.0))
    still = replace(at(time, torch.full_like(time, -30.0)), run=3)
    assert not bool(told.columns(still, shape_of(2.0, 3.0, 0.0, -1.0)).any())


@pytest.mark.parametrize("name", ["viscoelastic", "moisture", "glass_transition"])
def test_it_is_finite_wherever_a_thermometer_can_be(name, at) -> None:
    time = torch.arange(0, 200 * 600, 600.0, dtype=torch.float64)
    history = at(time, torch.linspace(-80, 120, 200, dtype=torch.float64))
    declared = build("effects", name).shape
    corners = torch.cartesian_prod(*[shape_of(one.low, one.high) for one in declared])
    assert bool(torch.isfinite(build("effects", name).columns(history, corners)).all())


# Moisture


def test_at_a_constant_temperature_drying_is_a_long_warm_up(at) -> None:
    time = torch.arange(0, 36000, 60.0, dtype=torch.float64)
    cool, hot = (columns("moisture", at(time, torch.full_like(time, celsius)), 15.0, 45.0, 0.0, 0.0) for celsius in (20.0, 60.0))
    torch.testing.assert_close(cool, columns("warm_up", at(time, time), 15.0 * 3600, 0.0, 0.0, 10.0)[:, :1].expand(-1, 2))
    faster = math.exp(45e3 / 8.314462618 * (1 / 293.15 - 1 / 333.15))
    torch.testing.assert_close(hot[:, 0], torch.exp(-faster * time / 54000))
    torch.testing.assert_close(hot[:, 1], faster * hot[:, 0])


def test_the_flux_is_the_rate_at_which_the_water_leaves(seen) -> None:
    history = seen(build("effects", "moisture"), step_s=10.0)
    left, flux = columns("moisture", history, 6.0, 60.0, 0.0, 0.0).T
    leaving = -torch.gradient(left, spacing=(history.time / (6.0 * 3600),))[0]
    torch.testing.assert_close(leaving[1:-1], flux[1:-1], rtol=0, atol=2e-3 * float(flux.max()))


def test_the_second_heating_finds_the_coil_drier(seen) -> None:
    history = seen(build("effects", "moisture"), knots=((0, 20), (1, 70), (4, 70), (5, 20), (6, 70), (9, 70)))
    flux = columns("moisture", history, 10.0, 50.0, 0.0, 0.0)[:, 1]
    first, second = ((history.time >= low * 3600) & (history.time < high * 3600) for low, high in ((1, 4), (6, 9)))
    assert float(flux[second].max()) < 0.5 * float(flux[first].max())


@pytest.mark.parametrize("goes_on", [0.0, 1.0])
def test_all_modes_of_diffusion_are_the_slowest_and_those_whose_times_are_a_square_shorter(goes_on, seen) -> None:
    history = seen(build("effects", "moisture"))
    each = [columns("moisture", history, 12.0 / n**2, 50.0, goes_on, 0.0) for n in (1, 3, 5, 7)]
    torch.testing.assert_close(columns("moisture", history, 12.0, 50.0, goes_on, 1.0), sum(each[1:], each[0]), rtol=1e-12, atol=1e-15)


def test_they_are_the_gradient_at_the_surface_of_a_plate_that_dries() -> None:
    """Of 400 cells to its middle, stepped implicitly, from when the modes that are left out are over; of the initial water over the half thickness it
    is twice their sum."""
    cells, step = 400, 1e-4
    width = 1.0 / cells
    rate = math.pi**2 / 4 * width**2  # time counts in e-folds of the slowest mode, of a half thickness of 1
    below = torch.ones(cells - 1, dtype=torch.float64)
    flow = torch.diag(below, 1) + torch.diag(below, -1) - 2.0 * torch.eye(cells, dtype=torch.float64)
    flow[0, 0], flow[-1, -1] = -3.0, -1.0  # the surface is half a cell away; nothing goes through the middle
    forward = torch.linalg.inv(torch.eye(cells, dtype=torch.float64) - step / rate * flow)
    water, age, ages, gradients = torch.ones(cells, dtype=torch.float64), 0.0, [], []
    while age < 1.0:
        water, age = forward @ water, age + step
        ages.append(age)
        gradients.append(float(water[0]) / (0.5 * width))
    late = torch.tensor(ages, dtype=torch.float64) > 0.1
    found = diffusing(torch.tensor(ages, dtype=torch.float64), shape_of(1.0))
    torch.testing.assert_close(2.0 * found[late], torch.tensor(gradients, dtype=torch.float64)[late], rtol=2e-3, atol=0)


# Glass transition


def test_through_the_transition_mohrs_coefficient_changes_by_the_jump(at) -> None:
    """The angles are functions of state, w·ln(1 + e^z) and w·tanh z."""
    time = torch.arange(0, 18001, 10.0, dtype=torch.float64)
    history = at(time, -20 + 120 / 18000 * time)
    jump, peak = columns("glass_transition", history, 30.0, 6.0, 1.0).T
    z = (history.temperature - 30.0) / 6.0
    for found, state in ((jump, 6.0 * torch.nn.functional.softplus(z)), (peak, 6.0 * z.tanh())):
        angle = torch.cumulative_trapezoid(found, history.time / 60)
        torch.testing.assert_close(angle, (state - state[0])[1:], rtol=0, atol=1e-3)
    assert float(jump[0]) == pytest.approx(0, abs=1e-3)
    assert float(jump[-1]) == pytest.approx(0.4, rel=1e-4)
    assert float(peak.max()) == pytest.approx(0.4, rel=1e-4)
    assert float(history.temperature[peak.argmax()]) == pytest.approx(30.0, abs=0.1)


def test_far_from_the_transition_it_is_mohrs_effect_or_nothing(seen) -> None:
    history = seen(build("effects", "mohr"))
    rate = columns("mohr", history)[:, 0]
    rubber, glass = (columns("glass_transition", history, transition, 3.0, 1.0) for transition in (-200.0, 200.0))
    torch.testing.assert_close(rubber[:, 0], rate, rtol=0, atol=1e-12)
    assert float(torch.cat([rubber[:, 1:], glass], -1).abs().max()) < 1e-12


def test_a_sharp_transition_is_mohrs_effect_above_it(seen) -> None:
    history = seen(build("effects", "mohr"))
    away = (history.temperature - 17.0).abs() > 1e-3
    sharp = columns("glass_transition", replace(history), 17.0, 1e-5, 1.0)
    expected = torch.where(history.temperature > 17.0, history.rate, 0.0)
    torch.testing.assert_close(sharp[away, 0], expected[away], rtol=0, atol=1e-12)
    assert float(sharp[away, 1].abs().max()) < 1e-12
