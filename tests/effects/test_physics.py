"""What each effect must do in a hold, in a ramp, round a closed cycle: the signatures by which engineers tell them apart."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.effects.base import Effect, History
from zoo.models.graybox import UNSEEN
from zoo.physics.lag import lagged

RAMP = ((0, 20), (1, 20), (2, 50), (8, 50))
"""An hour at 20 °C, an hour at 0.5 K/min, six hours at 50 °C."""
LONG_RAMP = ((0, -40), (10, 80))


def column(effect: Effect, history: History, *shape: float) -> Tensor:
    """(T,) the first column."""
    return effect.columns(history, torch.tensor(shape, dtype=torch.float64) if shape else effect.shape_value.detach())[:, 0]


def integral(time: Tensor, value: Tensor) -> float:
    return float(torch.trapezoid(value, time))


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


def test_mohr_angle_is_the_change_of_temperature(seen) -> None:
    effect = build("effects", "mohr")
    history = seen(effect, knots=RAMP)
    assert integral(history.time / 60, column(effect, history)) == pytest.approx(30.0, rel=1e-3)


def test_sensor_lag_is_the_lag_times_the_rate_in_a_ramp(seen) -> None:
    """§5: b'·δτ·dT/dt, to first order Mohr's column."""
    effect = build("effects", "sensor_lag")
    history = seen(effect, knots=LONG_RAMP, coil=(300.0, 0.0, 0.0))
    middle = slice(len(history.time) // 2, -120)
    lagging = column(effect, history, 900.0)[middle]
    torch.testing.assert_close(lagging, torch.full_like(lagging, -(900 - 300) / 60 * 0.2), rtol=1e-4, atol=0)


def test_a_thermal_gradient_is_what_the_outer_thermometer_is_ahead(seen) -> None:
    """The outer one leads by 5 min: 0.5 K/min · 5 min in the ramp."""
    effect = build("effects", "thermal_gradient")
    history = seen(effect, knots=RAMP)
    ahead = column(effect, history)
    assert float(ahead[90]) == pytest.approx(2.5)
    assert torch.equal(column(effect, seen(effect, knots=RAMP, coil=(1000.0, 0.9, 60.0))), ahead), "measured, whatever the coil is fitted to be"


def test_a_fixture_follows_a_ramp_with_its_lag(seen, warped) -> None:
    """From rest, r·(1 − e^(−t/τ)), and the whole twist is the change of temperature."""
    effect = build("effects", "fixture_rotation")
    time = torch.arange(0, 36000, 30.0, dtype=torch.float64)
    history = warped(seen(effect), time, 20 + 0.4 * (time / 60).clamp_max(100.0))
    twist = column(effect, history, 900.0)
    ramp = time <= 6000
    torch.testing.assert_close(twist[ramp], -0.4 * torch.expm1(-time[ramp] / 900), rtol=0, atol=1e-12)
    torch.testing.assert_close(twist[~ramp], twist[ramp][-1] * torch.exp(-(time[~ramp] - 6000) / 900), rtol=1e-9, atol=1e-12)
    assert integral(time / 60, twist) == pytest.approx(40.0, rel=1e-3)


@pytest.mark.parametrize(("fixture_s", "housing_s"), [(300.0, 900.0), (1500.0, 600.0)])
def test_a_fixture_in_the_air_is_ahead_of_a_thermometer_in_the_housing(fixture_s, housing_s, seen, warped) -> None:
    """Rate of lag_τf(air) from lag_τh(air), which is all that is measured: (1 − τh/τf) of what lags it by τf, and τh/τf of itself."""
    effect = build("effects", "fixture_rotation")
    time = torch.arange(0, 36000, 5.0, dtype=torch.float64)
    air = 20 + 15 * (1 - torch.cos(time / 3000))
    fixture, housing = (lagged(time, air, torch.tensor(tau, dtype=torch.float64)) for tau in (fixture_s, housing_s))
    history = replace(warped(seen(effect), time, housing), rate=60 * (air - housing) / housing_s)
    columns = effect.columns(history, torch.tensor([fixture_s], dtype=torch.float64))
    share = housing_s / fixture_s
    expected = 60 * (air - fixture) / fixture_s
    torch.testing.assert_close(columns @ torch.tensor([1 - share, share], dtype=torch.float64), expected, rtol=0, atol=1e-4 * float(expected.max()))


def test_a_fixture_without_a_lag_is_mohrs_effect_of_the_housing_until_the_gyro_is_flipped(seen) -> None:
    effect, mohr = build("effects", "fixture_rotation"), build("effects", "mohr")
    history = seen(effect, step_s=5.0)
    history = replace(history, rate=torch.gradient(history.temperature, spacing=(history.time / 60,))[0])
    up, down = (column(effect, replace(history, reference=torch.full_like(history.time, rate)), 1e-3) for rate in (9.66, -9.66))
    bends = torch.nn.functional.pad(torch.diff(history.rate).abs() > 1e-9, (1, 1))
    bends = bends[:-1] | bends[1:]
    torch.testing.assert_close(up[~bends], column(mohr, history)[~bends], rtol=0, atol=1e-9)
    assert int(bends.sum()) < 60
    assert torch.equal(down, -up)


# The others


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


def test_a_step_that_stays_is_there_in_all_later_runs_and_in_those_not_fitted(seen) -> None:
    effect = build("effects", "bias_step")
    for run in (1, 2, 3, -1):
        stays, goes = (column(effect, seen(effect, run=run), 5.0, number) for number in (-2.0, 2.0))
        if run == 2:
            torch.testing.assert_close(stays, goes, rtol=0, atol=0)
        else:
            assert stays.unique().tolist() == [0.0 if run == 1 else 1.0]
    numbers = effect.shapes_to_try(36_000.0, 3)[:, 1].unique().tolist()
    assert numbers == [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0], "in the last run it makes no difference"
    assert effect.shapes_to_try(36_000.0, 1)[:, 1].unique().tolist() == [0.0]


def test_the_supply_counts_in_proportion_and_by_its_square(seen) -> None:
    effect = build("effects", "supply_voltage")
    columns = effect.columns(seen(effect, inputs={"supply_v": 4.5}), effect.shape_value)
    assert columns.reshape(-1, 2).unique(dim=0).tolist() == [[-0.5, 0.25]]


def test_a_field_of_zero_and_a_nominal_supply_do_nothing(seen) -> None:
    for name, column_name, nominal in (("magnetic", "field_ut", 0.0), ("supply_voltage", "supply_v", 5.0)):
        effect = build("effects", name)
        assert float(effect.columns(seen(effect, inputs={column_name: nominal}), effect.shape_value).abs().max()) == 0
        other = column(effect, seen(effect, inputs={column_name: nominal + 0.5}))
        torch.testing.assert_close(other, torch.full_like(other, 0.5))


def test_a_chamber_swings_in_its_own_way_in_each_run(seen) -> None:
    effect = build("effects", "chamber_cycling")
    for run in (1, 2, 3, 4, 5, -1):
        history = seen(effect, run=run)
        columns = effect.columns(history, torch.tensor([300.0], dtype=torch.float64))
        own = slice(2 * (run - 1), 2 * run) if 1 <= run <= 4 else slice(0, 0)
        phase = 2 * torch.pi * history.time / 300
        waves = torch.stack([phase.cos(), phase.sin()], -1) if 1 <= run <= 4 else columns[:, :0]
        torch.testing.assert_close(columns[:, own], waves)
        columns[:, own] = 0
        assert not bool(columns.any()), "nobody knows the phase in another run"


@pytest.mark.parametrize("span_h", [1.0, 12.0, 24.0])
def test_no_line_of_a_chamber_lies_between_the_periods_tried(span_h) -> None:
    """A line at most 1/(2·span) from a period tried first keeps sinc²(1/2) of its power, 41 %; 1/(16·span) from one tried then, sinc²(1/16), 99 %."""
    effect, span = build("effects", "chamber_cycling"), span_h * 3600
    frequency = 1 / effect.shapes_to_try(span, 3)[:, 0].sort(descending=True).values
    step = float(torch.diff(frequency).max())
    assert 0.8 / span < step <= (1 + 1e-9) / span
    assert float(frequency[0] - 1 / 3600) <= (0.5 + 1e-9) / span
    assert float(1 / 120 - frequency[-1]) <= (0.5 + 1e-9) / span
    clock = torch.linspace(0, span, 20001, dtype=torch.float64)
    for place in (0, len(frequency) // 2, -1):
        near = 1 / effect.shapes_near(1 / frequency[place : place + 1 or None], span)[:, 0]
        assert bool(((near >= 1 / 3600 - 1e-12) & (near <= 1 / 120 + 1e-12)).all())
        inwards = 1 if place == 0 else -1
        for tried, offset, power in ((frequency[[place]], 0.5, 0.405), (near, 0.5 - 1 / 16, 0.987)):
            line = frequency[place] + inwards * offset / span
            best = max(float(torch.exp(2j * torch.pi * (line - f) * clock).mean().abs() ** 2) for f in tried)
            assert best == pytest.approx(power, abs=0.002)


@pytest.mark.parametrize(("span_s", "longest_s"), [(100.0, 240.0), (3000.0, 750.0), (10_000.0, 2500.0), (14_400.0, 3600.0), (2e5, 3600.0)])
def test_a_line_of_a_chamber_is_one_that_recurs(span_s, longest_s) -> None:
    effect = build("effects", "chamber_cycling")
    seen = effect.seen_over(span_s)
    assert (seen.shape[0].low, seen.shape[0].high) == (120.0, longest_s)
    assert seen.shape[0].default <= longest_s
    assert seen.seen_over(span_s) is seen
    assert (seen is effect) == (longest_s == 3600.0)
    assert effect.shape[0].high == 3600.0, "what was given stays as it is"
    assert float(seen.shapes_to_try(span_s, 1).max()) <= longest_s


@pytest.mark.parametrize(("span_h", "low", "high"), [(2.0, 0.02, 1.98), (10.0, 1 / 12, 10 - 1 / 12), (60.0, 1 / 12, 24.0), (0.0, 0.0, 24.0)])
def test_a_step_has_something_of_a_run_before_and_after_it(span_h, low, high) -> None:
    effect = build("effects", "bias_step")
    seen = effect.seen_over(span_h * 3600)
    assert (seen.shape[0].low, seen.shape[0].high) == pytest.approx((low, high))
    assert seen.shape[0].low <= seen.shape[0].default <= seen.shape[0].high
    assert seen.shape[1] == effect.shape[1]
    assert seen.seen_over(span_h * 3600) is seen
    tried = seen.shapes_to_try(span_h * 3600, 2)[:, 0]
    assert span_h == 0 or bool(((tried > low) & (tried < min(span_h, 24.0))).all())


@pytest.mark.parametrize("name", ["warm_up", "aging", "bias_step", "supply_voltage", "chamber_cycling", "dead_band"])
def test_some_do_not_know_the_temperature(name, seen) -> None:
    effect = build("effects", name)
    here, elsewhere = seen(effect), seen(effect, knots=((0, 70), (12, -10)))
    if name != "supply_voltage":  # its input is tied to the knots
        assert torch.equal(effect.columns(here, effect.shape_value), effect.columns(elsewhere, effect.shape_value))
    moved = History(**{**vars(here), "temperature": here.temperature + 30, "rate": here.rate + 1, "thermometer": here.thermometer + 30})
    assert torch.equal(effect.columns(here, effect.shape_value), effect.columns(moved, effect.shape_value))


def test_warm_up_is_normalised_and_monotone(seen) -> None:
    warm = build("effects", "warm_up")
    decays = warm.columns(seen(warm), torch.tensor([1200.0, 0.0, 0.0, 10.0], dtype=torch.float64))
    for decay, fold in zip(decays.T, (20, 2), strict=True):  # the body, and the electronics ten times faster
        assert float(decay[0]) == 1
        assert float(decay[fold]) == pytest.approx(math.exp(-1.0))
        assert bool((torch.diff(decay) < 0).all())


@pytest.mark.parametrize(("which", "cold"), [(0, (1, 2, 3, UNSEEN)), (2, (2,)), (-2, (1, 3, UNSEEN))])
def test_warm_up_is_in_all_runs_or_one_or_all_but_one(which, cold, seen) -> None:
    warm = build("effects", "warm_up")
    for run in (1, 2, 3, UNSEEN):
        found = column(warm, seen(warm, run=run), 1200.0, which, 0.0, 10.0)
        assert bool((found > 0).all()) if run in cold else bool((found == 0).all())
    assert sorted(set(warm.shapes_to_try(36000.0, 3)[:, 1].tolist())) == [-3, -2, -1, 0, 1, 2, 3]
    assert sorted(set(warm.shapes_to_try(36000.0, 2)[:, 1].tolist())) == [0, 1, 2], "all but one is the other"
    assert set(warm.shapes_to_try(36000.0, 1)[:, 1].tolist()) == {0}


def test_warm_up_is_the_larger_the_colder_it_begins(seen) -> None:
    """In proportion, as of what is kept at 70 °C: half as large from 45 °C as from 20 °C; its course is the same, wherever the chamber goes then."""
    warm = build("effects", "warm_up")
    cold, room, hot = (column(warm, seen(warm, knots=((0, begin), (12, 60))), 1200.0, 0.0, 0.02, 10.0) for begin in (-5, 20, 45))
    torch.testing.assert_close(room, column(warm, seen(warm), 1200.0, 0.0, 0.0, 10.0), rtol=1e-12, atol=0)
    torch.testing.assert_close(hot, 0.5 * room, rtol=1e-12, atol=0)
    torch.testing.assert_close(cold, 1.5 * room, rtol=1e-12, atol=0)


@pytest.mark.parametrize("bend", [-1.0, -0.3, -0.01, 0.0, 0.01, 0.5, 1.0])
def test_aging_is_normalised_and_monotone_and_one_of_its_laws(bend, seen) -> None:
    age = build("effects", "aging")
    drift, hours = column(age, seen(age), bend, 0.0), seen(age).time / 3600
    assert float(drift[0]) == pytest.approx(0, abs=1e-8)
    assert float(drift[600]) == pytest.approx(1.0), "its amplitude is the drift after 10 h"
    assert bool((torch.diff(drift) > 0).all())
    law = (hours / 10) ** (1 - 0.7 * bend) if bend >= 0 else torch.log1p(-bend * hours) / math.log1p(-bend * 10)
    torch.testing.assert_close(drift, law, rtol=1e-9, atol=1e-8)


def test_aging_by_a_logarithm_goes_over_into_aging_by_a_power(seen) -> None:
    age = build("effects", "aging")
    drifts = [column(age, seen(age), bend, 0.0) for bend in (-1e-7, 0.0, 1e-7)]
    for drift in drifts:
        torch.testing.assert_close(drift, seen(age).time / 36000, rtol=1e-5, atol=1e-7)
    near, goes_on = age.shapes_near(torch.tensor([0.2, 1.0], dtype=torch.float64), 36000.0).T
    assert float(near[0]) == 0.2
    assert goes_on.tolist() == [1.0, *[1.0, 0.0] * (len(near) // 2)], "each anew as well"
    assert int((near < 0).sum()) == int((near > 0).sum()) - 1, "as many of either law"


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


@pytest.mark.parametrize("name", ["scale_factor", "scale_factor_nonlinearity", "misalignment"])
def test_beside_a_constant_input_it_is_a_static_bias_at_the_same_place(name, seen) -> None:
    effect, bias = build("effects", name), build("effects", "static_bias")
    history = seen(effect)
    steady = History(**{**vars(history), "reference": torch.full_like(history.time, 9.66)})
    basis, columns = bias.columns(steady, bias.shape_value).detach(), effect.columns(steady, effect.shape_value)
    scale = basis.abs().amax(0)
    best = torch.linalg.lstsq(basis / scale, columns, driver="gelsd").solution
    torch.testing.assert_close(basis / scale @ best, columns, rtol=0, atol=1e-12 * float(columns.abs().max()))


def test_odd_columns_flip_with_the_input_and_the_even_one_does_not(seen) -> None:
    for name, signs in (("scale_factor", (-1, -1, -1)), ("scale_factor_nonlinearity", (1, -1, -1, -1)), ("misalignment", (-1, -1, -1))):
        effect = build("effects", name)
        rate = torch.linspace(-180, 180, 37, dtype=torch.float64)
        _, columns = turned(effect, seen, rate, 45.0)
        assert torch.equal(columns.flip(0), columns * torch.tensor(signs, dtype=torch.float64))


def test_misalignment_knows_the_sense_of_turning_and_not_how_fast(seen) -> None:
    effect = build("effects", "misalignment")
    rates = torch.tensor([-9.66, 9.66, 1e-3, -1e6, 0.0], dtype=torch.float64)
    _, columns = turned(effect, seen, rates, 50.0)
    theta = torch.tensor([1.0, 30.0, 900.0], dtype=torch.float64)
    torch.testing.assert_close(columns, torch.tensor([[-1.0], [1.0], [1.0], [-1.0], [0.0]], dtype=torch.float64) * theta)


def test_a_dead_band_pulls_small_rates_to_zero_and_leaves_large_ones(seen) -> None:
    effect = build("effects", "dead_band")
    rates = torch.linspace(-2, 2, 4001, dtype=torch.float64)
    here, _ = turned(effect, seen, rates)
    for edge in (2.0, 4.0, 16.0):
        pulled = column(effect, here, 0.1, edge)
        torch.testing.assert_close(pulled.flip(0), -pulled, rtol=0, atol=1e-12)
        assert float(pulled.min()) == pytest.approx(-1.0, abs=1e-12)
        assert float(rates[pulled.argmin()]) == pytest.approx(0.1, abs=1e-9)
        assert float((pulled[2001] - pulled[1999]) / (rates[2001] - rates[1999])) == pytest.approx(-10 * edge / (edge - 1), rel=1e-3)
        torch.testing.assert_close(pulled[3800:], -edge * (rates[3800:] / 0.1).pow(1 - edge), rtol=0.02, atol=0)


def test_a_dead_band_is_one_that_the_input_leaves() -> None:
    effect = build("effects", "dead_band")
    seen = effect.driven_to(15.0)
    assert (seen.shape[0].low, seen.shape[0].high, effect.shape[0].high) == (1e-8, 15.0, 1e7), "what was given stays as it is"
    assert float(seen.shapes_to_try(3600.0, 1)[:, 0].max()) <= 15.0
    assert seen.driven_to(15.0) is seen
    assert effect.driven_to(0.0) is effect, "at rest there is nothing to see"


def test_a_dead_band_is_a_dead_zone_or_locking_at_its_ends(seen) -> None:
    """No output at all below d; and far out the √(Ω² − d²) − Ω of two oscillators that lock, to the next order d⁴/8Ω³."""
    effect = build("effects", "dead_band")
    rates = torch.linspace(0, 2, 2001, dtype=torch.float64)
    here, _ = turned(effect, seen, rates)
    steep, inside, beyond = column(effect, here, 0.5, 1000.0), rates < 0.49, rates > 0.51
    torch.testing.assert_close(steep[inside], -rates[inside] / 0.5, rtol=1.1e-3, atol=0)
    assert float(steep[beyond].abs().max()) < 1e-5
    assert float(column(effect, turned(effect, seen, 1e9 * rates)[0], 0.5, 1000.0).abs().max()) < 1e-15
    far = rates > 1.0
    locked = (rates[far] ** 2 - 0.1**2).sqrt() - rates[far]
    torch.testing.assert_close(0.025 * column(effect, here, 0.1, 2.0)[far], locked, rtol=0.02, atol=0)


def test_a_dead_band_is_the_same_in_any_unit(seen) -> None:
    effect = build("effects", "dead_band")
    rates = torch.linspace(-2, 2, 401, dtype=torch.float64)
    in_dph, in_rad = (column(effect, turned(effect, seen, scale * rates)[0], scale * 0.1, 4.0) for scale in (1.0, 4.8481368e-6 / 3.6))
    torch.testing.assert_close(in_rad, in_dph, rtol=1e-9, atol=1e-12)


SAGNAC_S, RATE, HALF_SPAN_K = 0.13, 3.0, 20.0
"""Gain of a tactical coil, 160 m on 50 mm at 1310 nm [s]; largest rate [rad/s]; half a span of temperature [K]."""


def test_an_open_loop_is_the_cubic_to_the_next_order_of_the_sine(seen) -> None:
    """V0·sin(SΩ) with V0·S = 1 less Ω: −S²/6·Ω³, off by less than S⁴/120·Ω⁵, and by nearly that at full rate."""
    effect = build("effects", "scale_factor_nonlinearity")
    rate = torch.linspace(-RATE, RATE, 61, dtype=torch.float64)
    effect.amplitude.data = torch.tensor([0.0, -1e6 * SAGNAC_S**2 / 6, 0.0, 0.0], dtype=torch.float64)
    history, _ = turned(effect, seen, rate)
    off = torch.sin(SAGNAC_S * rate) / SAGNAC_S - rate - effect(history).detach()
    next_order = SAGNAC_S**4 / 120 * rate**5
    assert bool((off.abs() <= next_order.abs() + 1e-15).all())
    torch.testing.assert_close(off, next_order, rtol=SAGNAC_S**2 * RATE**2 / 42, atol=1e-15)


def test_of_a_cubic_the_line_is_that_of_the_best_fit(seen) -> None:
    """−3/5 of the square of the range, where all of it is as often: the least squares of Ω³ by Ω."""
    effect = build("effects", "scale_factor_nonlinearity")
    rate = torch.linspace(-RATE, RATE, 20001, dtype=torch.float64)
    _, columns = turned(effect, seen, rate)
    cubic, line = columns[:, 1], columns[:, 3]
    assert float(-(cubic @ line) / (line @ line)) == pytest.approx(-3 / 5 * RATE**2, rel=1e-3)


def test_a_warmer_open_loop_is_scale_factor_and_cubic_together(seen) -> None:
    """(1 + vθ)·sin(S(1 + sθ)Ω)/S: slopes of v + s and of (v + 3s)·c3, but for terms of second order in temperature and of fifth in rate."""
    v, s = -100e-6, -350e-6
    rate = torch.linspace(-RATE, RATE, 61, dtype=torch.float64)
    linear, cubic = build("effects", "scale_factor"), build("effects", "scale_factor_nonlinearity")
    c3 = -1e6 * SAGNAC_S**2 / 6
    linear.amplitude.data = torch.tensor([0.0, 1e6 * (v + s), 0.0], dtype=torch.float64)
    cubic.amplitude.data = torch.tensor([0.0, c3, (v + 3 * s) * c3, 0.0], dtype=torch.float64)
    for theta in (-HALF_SPAN_K, HALF_SPAN_K):
        modelled = sum(one(turned(one, seen, rate, 20.0 + theta)[0]).detach() for one in (linear, cubic))
        true = (1 + v * theta) * torch.sin(SAGNAC_S * (1 + s * theta) * rate) / SAGNAC_S - rate
        second_order, fifth_order = 2 * (v * theta) ** 2 + 4 * (s * theta) ** 2, SAGNAC_S**4 / 120 * RATE**4
        assert float((modelled - true).abs().max()) < (second_order + fifth_order) * RATE
        assert float((modelled - true).abs().max()) < 0.02 * float(true.abs().max())
