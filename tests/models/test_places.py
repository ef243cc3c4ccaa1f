"""The coil's temperature from the thermometers: limits, planted lags, steps of the resolution."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from zoo.models.places import AHEAD, LAG, LEAD, SECOND, START, STEADY_S, coil, coil_parameters, first_rates, histories, housing_last
from zoo.physics.lag import lagged

HALF_DEGREE_PER_MINUTE = 0.5 / 60


def values(*numbers: float) -> Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


def one(lag: float, lead: float, second: float = 1.0) -> Tensor:
    """What is fitted of a coil that is known by one thermometer."""
    return values(lag, lead, second)


def several(lag: float, *weights: float, lead: float = 0.0) -> Tensor:
    return values(lag, *weights, lead)


@pytest.fixture
def time() -> Tensor:
    return torch.arange(0, 30000, 10.0, dtype=torch.float64)


@pytest.fixture
def ramp(time) -> Tensor:
    """(T,) 20 °C, up by 0.5 K/min for two hours, held, down again."""
    return 20 + HALF_DEGREE_PER_MINUTE * ((time - 3000).clamp(0, 7200) - (time - 18000).clamp(0, 7200))


@pytest.fixture
def two(time, ramp) -> Tensor:
    """(T, 2) a thermometer at the spool and one at the case, which leads it and is a little off."""
    return torch.stack([lagged(time, ramp, values(600.0)[0]), ramp + 0.3 * torch.sin(time / 500)], -1)


def test_what_is_fitted_depends_on_the_thermometers() -> None:
    assert coil_parameters(["temperature_c"]) == (LAG, LEAD, SECOND)
    lag, *weights, lead = coil_parameters(["temperature_c", "temperature_outer_c", "temperature_flange_c"])
    assert (lag, lead, [each.name for each in weights]) == (LAG, AHEAD, ["weight_outer", "weight_flange"])
    assert all((each.low, each.high) == (0.0, 1.0) for each in weights)


def test_the_thermometer_called_the_housings_is_taken_for_it_and_else_the_last() -> None:
    assert housing_last(["temperature_c"]) == ["temperature_c"]
    assert housing_last(["temperature_c", "temperature_outer_c", "temperature_air_c"]) == [
        "temperature_c",
        "temperature_air_c",
        "temperature_outer_c",
    ]
    assert housing_last(["temperature_c", "temperature_pcb_c", "temperature_air_c"]) == ["temperature_c", "temperature_pcb_c", "temperature_air_c"]


@pytest.mark.parametrize("weight", [0, 1])
def test_a_weight_of_one_or_none_picks_the_thermometer(time, two, weight) -> None:
    temperature, rate, gradient = coil(time, two, several(400.0, weight))
    expected = lagged(time, two[:, weight], values(400.0)[0])
    torch.testing.assert_close(temperature, expected, rtol=0, atol=1e-12)
    assert torch.equal(gradient, two[:, 1] - two[:, 0]), "measured"
    torch.testing.assert_close(rate, (two[:, weight] - expected) / 400 * 60, rtol=0, atol=1e-12)


def test_a_weight_between_is_a_mean_of_the_two(time, two) -> None:
    ends = [coil(time, two, several(400.0, weight)) for weight in (0.0, 1.0)]
    for found, first, second in zip(coil(time, two, several(400.0, 0.3)), *ends, strict=True):
        torch.testing.assert_close(found, 0.7 * first + 0.3 * second, rtol=0, atol=1e-11)


def test_a_third_thermometer_has_its_own_weight(time, two) -> None:
    three = torch.cat([two, 15 + 0 * time.unsqueeze(-1)], -1)
    drive = 0.3 * two[:, 0] + 0.5 * two[:, 1] + 0.2 * 15
    torch.testing.assert_close(coil(time, three, several(400.0, 0.5, 0.2))[0], lagged(time, drive, values(400.0)[0]), rtol=0, atol=1e-10)


def test_the_difference_beside_a_ramp_is_measured_where_it_can_be(time) -> None:
    """With one thermometer it is lag·rate in a steady ramp, Mohr's column; with several the last one less the main one, whatever is fitted."""
    line = (20 + HALF_DEGREE_PER_MINUTE * time).unsqueeze(-1)
    alone = coil(time, line, one(300.0, -300.0))
    torch.testing.assert_close(alone[2][-100:], 300 / 60 * alone[1][-100:], rtol=1e-9, atol=0)
    three = torch.cat([line, line + 1, line + torch.sin(time / 700).unsqueeze(-1)], -1)
    for theta in (several(300.0, 0.5, 0.2), several(900.0, 0.1, 0.9, lead=60.0)):
        torch.testing.assert_close(coil(time, three, theta)[2], torch.sin(time / 700), rtol=0, atol=1e-12)
    assert coil(time, three, torch.stack([several(300.0, 0.5, 0.2)] * 4))[2].shape == (4, len(time)), "a batch, as the temperature is"


def test_without_a_lag_the_coil_is_the_thermometer(time, two, ramp) -> None:
    for thermometers, theta in ((two, several(1e-3, 0.0)), (two[:, :1], one(1e-3, -2e-3))):
        temperature, rate, gradient = coil(time, thermometers, theta)
        torch.testing.assert_close(temperature, two[:, 0], rtol=0, atol=1e-4)
        torch.testing.assert_close(gradient, thermometers[:, -1] - two[:, 0], rtol=0, atol=1e-4)
        slope = torch.gradient(two[:, 0], spacing=(time / 60,))[0]
        assert float((rate - slope)[2:].abs().median()) < 1e-4


@pytest.mark.parametrize(
    ("count", "theta"),
    [(2, (400.0, 0.3, 0.0)), (2, (400.0, 0.3, 50.0)), (1, (300.0, 100.0, 1.0)), (1, (300.0, -400.0, 0.3)), (1, (300.0, -900.0, 1.0))],
)
def test_the_rate_is_the_derivative_of_the_temperature(time, two, count, theta) -> None:
    thermometers = two[:, :count]
    temperature, rate, _ = coil(time, thermometers, values(*theta))
    slope = torch.gradient(temperature, spacing=(time / 60,))[0]
    assert float((rate - slope)[2:-2].abs().max()) < 0.02 * float(rate.abs().max())
    assert float((rate - slope)[2:-2].square().mean().sqrt()) < 2e-3 * float(rate.abs().max())


@pytest.mark.parametrize(("tau", "lag"), [(120.0, 60.0), (400.0, 100.0)])
def test_lead_and_lag_invert_a_thermometers_lag(time, tau, lag) -> None:
    """A lead of τ_s: exact in a steady ramp, and for slow changes to second order in ωτ."""
    truth = 20 + 15 * torch.sin(time / 3000)
    thermometer = lagged(time, truth, values(tau)[0]).unsqueeze(-1)
    found, rate, _ = coil(time, thermometer, one(lag, tau))
    settled = time > 6000
    left, uncorrected = ((one - truth)[settled].abs().max() for one in (found, thermometer[:, 0]))
    second_order = 15 * (lag**2 + 2 * lag * tau) / 3000**2
    assert float(left) < 1.2 * second_order
    assert float(left) < 0.15 * float(uncorrected)
    assert float((rate - 15 / 3000 * 60 * torch.cos(time / 3000))[settled].abs().max()) < 0.1 * 15 / 3000 * 60
    line = 20 + 0.01 * time
    found = coil(time, lagged(time, line, values(tau)[0]).unsqueeze(-1), one(lag, tau))[0]
    torch.testing.assert_close(found[settled], line[settled], rtol=0, atol=1e-4)


@pytest.mark.parametrize("lead", [-300.0, -1000.0])
def test_a_lead_of_minus_two_lags_or_less_is_two_equal_lags(time, two, lead) -> None:
    lag = values(150.0)[0]
    expected = lagged(time, lagged(time, two[:, 0], lag), lag)
    torch.testing.assert_close(coil(time, two[:, :1], one(150.0, lead))[0], expected, rtol=0, atol=1e-11)


def test_a_lead_of_minus_one_lag_is_one_lag(time, two) -> None:
    expected = lagged(time, two[:, 0], values(150.0)[0])
    torch.testing.assert_close(coil(time, two[:, :1], one(150.0, -150.0))[0], expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("tau", [20.0, 120.0])
def test_thermometers_that_are_late_are_made_up_for(time, ramp, tau) -> None:
    """The coil, a lag of 300 s behind what heats it, from thermometers late by τ: to what lies between samples, and the smoothing of several."""
    truth = lagged(time, ramp, values(300.0)[0])
    late = lagged(time, ramp, values(tau)[0]).unsqueeze(-1)
    alone = coil(time, late, one(300.0, tau - 300.0, 1e-3))
    torch.testing.assert_close(alone[0], truth, rtol=0, atol=0.01)
    together = coil(time, late.expand(-1, 2), several(300.0, 0.5, lead=tau))
    behind = STEADY_S / 60 * HALF_DEGREE_PER_MINUTE * 60 * tau / 300
    assert float((together[0] - truth).abs().max()) < 1.1 * behind
    assert float((coil(time, late.expand(-1, 2), several(300.0, 0.5))[0] - truth).abs().max()) > 0.9 * HALF_DEGREE_PER_MINUTE * tau


def test_two_time_constants_may_change_places(time, two) -> None:
    for found, expected in zip(coil(time, two[:, :1], one(300.0, -100.0, 0.2)), coil(time, two[:, :1], one(60.0, -100.0, 5.0)), strict=True):
        torch.testing.assert_close(found, expected, rtol=0, atol=1e-3)


@pytest.mark.parametrize("theta", [(60.0, 60.0), (60.0, 300.0), (300.0, 600.0), (300.0, 3600.0), (5.0, 10.0)])
def test_a_step_of_the_resolution_is_amplified_by_no_more_than_stated(theta) -> None:
    """One thermometer: λ/τ² for λ ≥ τ, whatever the sampling; λ is the lead and two lags."""
    lag, ahead = theta
    for step_s in (0.05 * lag, 0.5 * lag):
        time = torch.arange(0, 30 * lag, step_s, dtype=torch.float64)
        stairs = torch.where(time >= 5 * lag, 0.0625, 0.0).double().unsqueeze(-1)
        rate = coil(time, stairs, one(lag, ahead - 2 * lag))[1] / 60
        assert float(rate.abs().max()) <= 0.0625 * ahead / lag**2 * (1 + 1e-9)
        if step_s < 0.1 * lag:
            assert float(rate.abs().max()) > 0.9 * 0.0625 * ahead / lag**2, "and the bound is reached"


@pytest.mark.parametrize("lead", [-500.0, -400.0, -370.0, -300.0])
def test_with_a_short_lead_the_lag_alone_bounds_it(lead) -> None:
    time = torch.arange(0, 6000, 5.0, dtype=torch.float64)
    stairs = torch.where(time >= 1000, 0.0625, 0.0).double().unsqueeze(-1)
    assert float(coil(time, stairs, one(200.0, lead))[1].abs().max()) <= 0.0625 / 200 * 60


def test_with_two_thermometers_a_step_jumps_by_its_share_over_the_lag() -> None:
    time = torch.arange(0, 6000, 5.0, dtype=torch.float64)
    stairs = torch.where(time >= 1000, 0.0625, 0.0).double()
    rate = coil(time, torch.stack([0 * time, stairs], -1), several(200.0, 0.25))[1]
    assert float(rate.abs().max()) == pytest.approx(0.25 * 0.0625 / 200 * 60, rel=0.03)


@pytest.mark.parametrize("count", [1, 2])
def test_a_record_that_starts_in_motion_has_a_coil_that_lags_from_the_first_sample(time, count) -> None:
    """κ = 1: a ramp long under way, the coil τ behind what heats it (the lead ahead of one thermometer); κ = 0: soaked."""
    line = 20 + HALF_DEGREE_PER_MINUTE * time
    thermometers = torch.stack([line, line + 3], -1)[:, :count]
    theta = (300.0, -500.0, 1.0) if count == 1 else (300.0, 0.5, 0.0)
    behind = (500 if count == 1 else 300) * HALF_DEGREE_PER_MINUTE
    expected = line + (0 if count == 1 else 1.5) - behind
    temperature, rate, _ = coil(time, thermometers, values(*theta, 1.0), in_motion=True)
    torch.testing.assert_close(temperature, expected, rtol=0, atol=1e-9)
    torch.testing.assert_close(rate, torch.full_like(rate, 0.5), rtol=0, atol=1e-9)
    soaked = coil(time, thermometers, values(*theta, 0.0), in_motion=True)
    for found, at_rest in zip(soaked, coil(time, thermometers, values(*theta)), strict=True):
        torch.testing.assert_close(found, at_rest, rtol=0, atol=1e-12)


def test_only_a_record_that_moves_from_the_first_minute_starts_in_motion(time, ramp) -> None:
    line = 20 + HALF_DEGREE_PER_MINUTE * time
    rates = first_rates(time, torch.stack([ramp, line, 0.1 * line, -2 * line], -1))
    torch.testing.assert_close(rates, values(0, HALF_DEGREE_PER_MINUTE, 0, -2 * HALF_DEGREE_PER_MINUTE))
    assert [each.name for each in coil_parameters(["temperature_c"], in_motion=True)] == ["lag", "lead", "second", "start"]
    assert coil_parameters(["temperature_c", "temperature_outer_c"], in_motion=True)[-1] == START


def test_a_batch_is_each_by_itself(time, two) -> None:
    theta = torch.stack([several(100.0, 0.2, lead=20.0), several(400.0, 0.9)])
    batch = coil(time, two, theta)
    for i in range(2):
        for found, alone in zip(batch, coil(time, two, theta[i]), strict=True):
            torch.testing.assert_close(found[i], alone, rtol=1e-12, atol=1e-12)


def test_gradients_to_lag_weight_and_lead_are_those_of_finite_differences() -> None:
    time = torch.arange(0, 600, 30.0, dtype=torch.float64)
    two = torch.stack([20 + torch.sin(time / 100), 21 + torch.cos(time / 90)], -1)
    for thermometers, theta in ((two, (100.0, 0.3, 40.0)), (two[:, :1], (100.0, -50.0, 0.4))):
        assert torch.autograd.gradcheck(lambda t, u=thermometers: coil(time, u, t), (values(*theta).requires_grad_(),))


def test_places_count_time_from_the_first_sample_and_carry_what_was_recorded(time, two) -> None:
    table = {"reference": torch.full_like(time, 9.66), "field_ut": torch.sin(time)}
    here = histories(time + 12345.0, table, two, several(400.0, 0.3), run=7)
    for place, history in here.items():
        assert torch.equal(history.time, time), place
        assert torch.equal(history.thermometer, two[:, 0])
        assert torch.equal(history.inputs["field_ut"], table["field_ut"])
        assert list(history.inputs) == ["field_ut"]
        assert torch.equal(history.reference, table["reference"])
        assert history.run == 7
    assert torch.equal(here["housing"].temperature, two[:, -1]), "the housing is where the last thermometer is"


def test_the_housings_rate_is_in_kelvins_a_minute(time) -> None:
    line = (20 + 0.01 * time).unsqueeze(-1)
    rate = histories(time, {"reference": 0 * time}, line, one(60.0, -60.0), 1)["housing"].rate
    assert float(rate[-1]) == pytest.approx(0.6, rel=1e-6)
