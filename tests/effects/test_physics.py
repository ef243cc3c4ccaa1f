"""What each effect must do in a hold, in a ramp, round a closed cycle: the signatures by which engineers tell them apart."""

from __future__ import annotations

from itertools import pairwise

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.effects.base import Effect, History
from zoo.effects.hysteresis import play

RAMP = ((0, 20), (1, 20), (2, 50), (8, 50))
"""An hour at 20 °C, an hour at 0.5 K/min, six hours at 50 °C."""
LONG_RAMP = ((0, -40), (10, 80))
CYCLE = ((0, 20), (1, 20), (6, 60), (16, -40), (22, 20), (26, 20))
"""A closed cycle from one isothermal state back to it, at 0.1 to 0.2 K/min."""


def column(effect: Effect, history: History, *shape: float) -> Tensor:
    """(T,) the first column."""
    return effect.columns(history, torch.tensor(shape, dtype=torch.float64) if shape else effect.shape_value.detach())[:, 0]


def integral(time: Tensor, value: Tensor) -> float:
    return float(torch.trapezoid(value, time))


@pytest.mark.parametrize("name", ["mohr", "shupe", "rate_temperature_coupling", "sensor_lag"])
def test_dynamic_effects_vanish_in_a_hold(name, seen) -> None:
    effect = build("effects", name)
    history = seen(effect, knots=RAMP)
    columns = effect.columns(history, effect.shape_value.detach())
    settled = history.time > 7 * 3600
    assert float(columns[settled].abs().max()) < 1e-5 * float(columns.abs().max())
    assert float(columns[history.time <= 3000].abs().max()) < 1e-12, "and in the hold before, for the coil is soaked at the start"


@pytest.mark.parametrize("name", ["static_bias", "hysteresis", "polarization"])
def test_functions_of_the_temperature_stay_in_a_hold(name, seen) -> None:
    effect = build("effects", name)
    history = seen(effect, knots=RAMP)
    columns = effect.columns(history, effect.shape_value.detach())
    assert float(columns[-60:].std(0).max()) < 1e-6
    assert float((columns[-1] - columns[0]).abs().max()) > 1e-3


@pytest.mark.parametrize("name", ["mohr", "shupe", "rate_temperature_coupling"])
def test_the_sign_flips_with_the_rate(name, seen) -> None:
    effect = build("effects", name)
    history = seen(effect)
    flipped = History(**{**vars(history), "rate": -history.rate})
    assert torch.equal(effect.columns(flipped, effect.shape_value), -effect.columns(history, effect.shape_value))


def test_mohr_is_the_rate_in_mid_ramp(seen) -> None:
    effect = build("effects", "mohr")
    history = seen(effect, knots=LONG_RAMP)
    middle = slice(len(history.time) // 2, -120)
    torch.testing.assert_close(column(effect, history)[middle], torch.full_like(history.time[middle], 0.2), rtol=1e-6, atol=0)


def test_shupe_is_nothing_in_mid_ramp_and_a_pair_of_spikes_at_its_ends(seen) -> None:
    """§2.4: a uniform rate gives exactly zero; it shows only at the edges, with opposite signs."""
    effect = build("effects", "shupe")
    history = seen(effect, knots=RAMP)
    spikes = column(effect, history)
    hours = history.time / 3600
    start, middle, end = ((low <= hours) & (hours < high) for low, high in ((0.9, 1.4), (1.7, 1.9), (1.92, 2.5)))
    assert float(spikes[start].max()) == pytest.approx(-float(spikes[end].min()), rel=0.02)
    assert float(spikes[middle].abs().max()) < 0.02 * float(spikes[start].max())
    uniform = History(**{**vars(history), "rate": torch.full_like(history.rate, 0.7)})
    assert float(column(effect, uniform).abs().max()) < 1e-14


def test_shupe_follows_the_second_derivative_for_slow_heat(seen) -> None:
    """§2.4: C_w·τ_d·d²T/dt² for changes slower than the diffusion time."""
    effect = build("effects", "shupe")
    history = seen(effect)
    time = history.time
    slow = History(**{**vars(history), "rate": torch.sin(time / 4000)})
    expected = 60.0 / 4000 * torch.cos((time - 60) / 4000)
    torch.testing.assert_close(column(effect, slow, 60.0)[20:], expected[20:], rtol=0, atol=0.01 * 60 / 4000)


@pytest.mark.parametrize("name", ["mohr", "shupe", "rate_temperature_coupling"])
def test_a_closed_slow_cycle_leaves_no_angle(name, seen) -> None:
    """§2.4, §4: the angle is a function of state, so that it is zero between two equal isothermal states."""
    effect = build("effects", name)
    history = seen(effect, knots=CYCLE)
    columns = effect.columns(history, effect.shape_value.detach())
    for one in columns.T:
        assert abs(integral(history.time, one)) < 1e-3 * integral(history.time, one.abs())


def test_mohr_angle_is_the_change_of_temperature(seen) -> None:
    effect = build("effects", "mohr")
    history = seen(effect, knots=RAMP)
    assert integral(history.time / 60, column(effect, history)) == pytest.approx(30.0, rel=1e-3)


def test_hysteresis_leaves_an_angle_round_a_cycle(seen) -> None:
    effect = build("effects", "hysteresis")
    history = seen(effect, knots=CYCLE)
    loop = column(effect, history, 6.0, 20.0, 40.0) - torch.tanh((history.temperature - 20.0) / 40.0)
    assert abs(integral(history.time, loop)) > 0.05 * integral(history.time, loop.abs())


def test_sensor_lag_is_the_lag_times_the_rate_in_a_ramp(seen) -> None:
    """§5: b'·δτ·dT/dt, to first order Mohr's column."""
    effect = build("effects", "sensor_lag")
    history = seen(effect, knots=LONG_RAMP, coil=(300.0, 0.0))
    middle = slice(len(history.time) // 2, -120)
    lagging = column(effect, history, 900.0)[middle]
    torch.testing.assert_close(lagging, torch.full_like(lagging, -(900 - 300) / 60 * 0.2), rtol=1e-4, atol=0)


# Rate-independent memory


def path(*turns: float, steps: int = 50) -> Tensor:
    """Straight from turn to turn."""
    parts = [torch.linspace(a, b, steps + 1, dtype=torch.float64)[1:] for a, b in pairwise(turns)]
    return torch.cat([torch.tensor([turns[0]], dtype=torch.float64), *parts])


def loop_of(temperature: Tensor, warped, seen, time: Tensor | None = None) -> Tensor:
    effect = build("effects", "hysteresis")
    time = torch.arange(len(temperature), dtype=torch.float64) * 60 if time is None else time
    return column(effect, warped(seen(effect), time, temperature), 6.0, 20.0, 30.0)


def test_hysteresis_does_not_know_the_rate(warped, seen) -> None:
    """The same temperatures in the same order, taken a hundred times slower, faster and with rests in between: the same values."""
    course = path(20, 50, 10, 35, 0, 20)
    once = loop_of(course, warped, seen)
    chance = torch.rand(len(course), generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    assert torch.equal(loop_of(course, warped, seen, time=(chance * 6000 + 1).cumsum(0)), once)
    rests = 1 + (chance * 4).long()
    assert torch.equal(loop_of(course.repeat_interleave(rests), warped, seen), once.repeat_interleave(rests))


def test_hysteresis_passes_through_finer_steps_unchanged(warped, seen) -> None:
    coarse, fine = path(20, 50, 10, 35, 0, 20, steps=50), path(20, 50, 10, 35, 0, 20, steps=200)
    torch.testing.assert_close(loop_of(fine, warped, seen)[::4], loop_of(coarse, warped, seen), rtol=0, atol=1e-12)


def test_a_minor_loop_closes(warped, seen) -> None:
    """Return-point memory (Madelung's second rule): back at a turning point, the state is what it was there."""
    value = loop_of(path(20, 50, 30, 45, 30, 10), warped, seen)
    assert float(value[100] - value[200]) == pytest.approx(0, abs=1e-12)
    assert float(value[75] - value[175]) != pytest.approx(0, abs=1e-3), "it is a loop: at 40 °C, going down, then up again"


def test_a_larger_excursion_wipes_a_minor_loop_out(warped, seen) -> None:
    """Madelung's third rule: past the point where it began, the path goes on as if the loop had not been."""
    with_loop, without = loop_of(path(20, 50, 30, 45, 30, 10), warped, seen), loop_of(path(20, 50, 30, 10), warped, seen)
    assert torch.equal(with_loop[200:], without[100:])
    nested = loop_of(path(20, 50, 30, 45, 35, 42, 35, 45, 30, 10), warped, seen)
    assert torch.equal(nested[400:], without[100:])


def test_up_and_down_differ_at_every_temperature_and_stay_within_one(warped, seen) -> None:
    value = loop_of(path(-60, 100, -60, 100), warped, seen)
    down, up = value[50:101], value[100:151].flip(0)
    assert bool((down[6:-6] > up[6:-6]).all()), "it lags: higher on the way down"
    assert float(value.abs().max()) <= 1.0
    wide = loop_of(path(0, 1, 0), warped, seen)
    assert float((wide - wide[0]).abs().max()) < 1e-12, "an excursion smaller than the narrowest relay moves nothing"


def test_the_play_is_the_loop_of_the_textbook() -> None:
    moved = play(torch.tensor([0.0, 3.0, 5.0, 1.0, -4.0, 0.0], dtype=torch.float64), torch.tensor([2.0], dtype=torch.float64))
    assert moved.tolist() == [0.0, 1.0, 3.0, 3.0, -2.0, -2.0]
    soaked = play(torch.tensor([50.0, 51.0, 49.0], dtype=torch.float64), torch.tensor([2.0], dtype=torch.float64))
    assert soaked.tolist() == [50.0, 50.0, 50.0], "it starts where the first temperature puts it"


# The others


def test_polarization_is_periodic_in_temperature_not_in_time(seen, warped) -> None:
    effect = build("effects", "polarization")
    history = seen(effect)
    shifted = History(**{**vars(history), "temperature": history.temperature + 12.0})
    torch.testing.assert_close(*(effect.columns(one, torch.tensor([12.0], dtype=torch.float64)) for one in (history, shifted)), rtol=0, atol=1e-9)
    up_and_down = path(0, 40, 0)
    time = torch.arange(len(up_and_down), dtype=torch.float64)
    fringes = effect.columns(warped(history, time, up_and_down), torch.tensor([12.0], dtype=torch.float64))
    torch.testing.assert_close(fringes, fringes.flip(0), rtol=0, atol=1e-9)
    fundamental, harmonic = fringes[:, :2].square().sum(1), fringes[:, 2:].square().sum(1)
    torch.testing.assert_close(fundamental, torch.ones_like(fundamental))
    torch.testing.assert_close(harmonic, torch.ones_like(harmonic))


def test_a_step_happens_in_its_run_only(seen) -> None:
    effect = build("effects", "bias_step")
    for run in (1, 2, 3, -1):
        history = seen(effect, run=run)
        stepped = column(effect, history, 5.0, 2.0)
        assert float(stepped.max()) == (1.0 if run == 2 else 0.0)
        assert float(column(effect, history, 5.0, 0.0)[-1]) == 1.0, "0 is every run"
    stepped = column(effect, seen(effect, run=2), 5.0, 2.0)
    assert stepped[:300].abs().max() == 0
    assert stepped[301:].min() == 1


def test_a_field_of_zero_and_a_nominal_supply_do_nothing(seen) -> None:
    for name, column_name, nominal in (("magnetic", "field_ut", 0.0), ("supply_voltage", "supply_v", 5.0)):
        effect = build("effects", name)
        assert float(effect.columns(seen(effect, inputs={column_name: nominal}), effect.shape_value).abs().max()) == 0
        other = column(effect, seen(effect, inputs={column_name: nominal + 0.5}))
        torch.testing.assert_close(other, torch.full_like(other, 0.5))


@pytest.mark.parametrize("name", ["warm_up", "aging", "bias_step", "supply_voltage"])
def test_some_do_not_know_the_temperature(name, seen) -> None:
    effect = build("effects", name)
    here, elsewhere = seen(effect), seen(effect, knots=((0, 70), (12, -10)))
    if name != "supply_voltage":  # its input is tied to the knots
        assert torch.equal(effect.columns(here, effect.shape_value), effect.columns(elsewhere, effect.shape_value))
    moved = History(**{**vars(here), "temperature": here.temperature + 30, "rate": here.rate + 1, "thermometer": here.thermometer + 30})
    assert torch.equal(effect.columns(here, effect.shape_value), effect.columns(moved, effect.shape_value))


def test_warm_up_and_aging_are_normalised_and_monotone(seen) -> None:
    warm, age = build("effects", "warm_up"), build("effects", "aging")
    decay, drift = column(warm, seen(warm), 1200.0), column(age, seen(age), 3.0)
    assert float(decay[0]) == 1
    assert float(decay[20]) == pytest.approx(torch.tensor(-1.0).exp())
    assert bool((torch.diff(decay) < 0).all())
    assert float(drift[0]) == 0
    assert float(drift[600]) == pytest.approx(1.0), "its amplitude is the drift after 10 h"
    assert bool((torch.diff(drift) > 0).all())


def test_static_bias_and_the_coupling_are_polynomials_about_20_degrees(seen) -> None:
    bias, coupling = build("effects", "static_bias"), build("effects", "rate_temperature_coupling")
    history = seen(bias)
    theta = history.temperature - 20.0
    torch.testing.assert_close(bias.columns(history, bias.shape_value), torch.stack([theta**k for k in range(4)], -1))
    expected = torch.stack([theta * history.rate, theta**2 * history.rate], -1)
    torch.testing.assert_close(coupling.columns(history, coupling.shape_value), expected)


def test_magnetic_grows_with_temperature_as_declared(seen) -> None:
    effect = build("effects", "magnetic")
    history = seen(effect, inputs={"field_ut": 50.0})
    columns = effect.columns(history, effect.shape_value)
    torch.testing.assert_close(columns[:, 1], 50.0 * (history.temperature - 20.0))


# The true input


def turned(effect: Effect, seen, rate: Tensor, celsius: float = 20.0) -> tuple[History, Tensor]:
    """A history with as many samples as there are rates, all at one temperature, and its columns."""
    history = seen(effect)
    here = History(**{**vars(history), "temperature": torch.full_like(rate, celsius), "reference": rate})
    return here, effect.columns(here, effect.shape_value.detach())


def test_the_scale_factor_is_a_polynomial_about_20_degrees_times_the_input(seen) -> None:
    effect = build("effects", "scale_factor")
    history = seen(effect)
    theta = history.temperature - 20.0
    expected = 1e-6 * history.reference.unsqueeze(-1) * torch.stack([theta**k for k in range(3)], -1)
    torch.testing.assert_close(effect.columns(history, effect.shape_value), expected)
    _, columns = turned(effect, seen, torch.tensor([15.041], dtype=torch.float64), 80.0)
    assert float(columns[0, 1]) * 400 == pytest.approx(0.361, abs=5e-4), "a source without a cooler, 60 K off, at Earth's rate [°/h]"


@pytest.mark.parametrize("name", ["scale_factor", "scale_factor_nonlinearity"])
def test_beside_a_constant_input_it_is_a_static_bias_at_the_same_place(name, seen) -> None:
    effect, bias = build("effects", name), build("effects", "static_bias")
    history = seen(effect)
    steady = History(**{**vars(history), "reference": torch.full_like(history.time, 9.66)})
    basis, columns = bias.columns(steady, bias.shape_value).detach(), effect.columns(steady, effect.shape_value)
    scale = basis.abs().amax(0)
    best = torch.linalg.lstsq(basis / scale, columns).solution
    torch.testing.assert_close(basis / scale @ best, columns, rtol=0, atol=1e-12 * float(columns.abs().max()))


def test_odd_columns_flip_with_the_input_and_the_even_one_does_not(seen) -> None:
    for name, signs in (("scale_factor", (-1, -1, -1)), ("scale_factor_nonlinearity", (1, -1, -1))):
        effect = build("effects", name)
        rate = torch.linspace(-180, 180, 37, dtype=torch.float64)
        _, columns = turned(effect, seen, rate, 45.0)
        assert torch.equal(columns.flip(0), columns * torch.tensor(signs, dtype=torch.float64))


SAGNAC_S, RATE, HALF_SPAN_K = 0.13, 3.0, 20.0
"""Gain of a tactical coil, 160 m on 50 mm at 1310 nm [s]; largest rate [rad/s]; half a span of temperature [K]."""


def test_an_open_loop_is_the_cubic_to_the_next_order_of_the_sine(seen) -> None:
    """V0·sin(SΩ) with V0·S = 1 less Ω: −S²/6·Ω³, off by less than S⁴/120·Ω⁵, and by nearly that at full rate."""
    effect = build("effects", "scale_factor_nonlinearity")
    rate = torch.linspace(-RATE, RATE, 61, dtype=torch.float64)
    effect.amplitude.data = torch.tensor([0.0, -1e6 * SAGNAC_S**2 / 6, 0.0], dtype=torch.float64)
    history, _ = turned(effect, seen, rate)
    off = torch.sin(SAGNAC_S * rate) / SAGNAC_S - rate - effect(history).detach()
    next_order = SAGNAC_S**4 / 120 * rate**5
    assert bool((off.abs() <= next_order.abs() + 1e-15).all())
    torch.testing.assert_close(off, next_order, rtol=SAGNAC_S**2 * RATE**2 / 42, atol=1e-15)


def test_a_warmer_open_loop_is_scale_factor_and_cubic_together(seen) -> None:
    """(1 + vθ)·sin(S(1 + sθ)Ω)/S: slopes of v + s and of (v + 3s)·c3, but for terms of second order in temperature and of fifth in rate."""
    v, s = -100e-6, -350e-6
    rate = torch.linspace(-RATE, RATE, 61, dtype=torch.float64)
    linear, cubic = build("effects", "scale_factor"), build("effects", "scale_factor_nonlinearity")
    c3 = -1e6 * SAGNAC_S**2 / 6
    linear.amplitude.data = torch.tensor([0.0, 1e6 * (v + s), 0.0], dtype=torch.float64)
    cubic.amplitude.data = torch.tensor([0.0, c3, (v + 3 * s) * c3], dtype=torch.float64)
    for theta in (-HALF_SPAN_K, HALF_SPAN_K):
        modelled = sum(one(turned(one, seen, rate, 20.0 + theta)[0]).detach() for one in (linear, cubic))
        true = (1 + v * theta) * torch.sin(SAGNAC_S * (1 + s * theta) * rate) / SAGNAC_S - rate
        second_order, fifth_order = 2 * (v * theta) ** 2 + 4 * (s * theta) ** 2, SAGNAC_S**4 / 120 * RATE**4
        assert float((modelled - true).abs().max()) < (second_order + fifth_order) * RATE
        assert float((modelled - true).abs().max()) < 0.02 * float(true.abs().max())
