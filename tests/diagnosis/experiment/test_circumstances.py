"""What is read off the runs at hand: range, true input, lags of the thermometers."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch

from zoo.diagnosis.experiment.circumstances import EARTH_DPH, PACKAGE_S, SELF_HEATING_K, circumstances_of, thermometer
from zoo.measurements.run import Run
from zoo.simulator.laboratory.profiles import cycle, staircase
from zoo.simulator.laboratory.program import Program


def recorded(program: Program, lags: tuple[float, ...], offset: float = 0.0, reference: float = 10.0, unit: str = "dph") -> Run:
    """A run whose thermometers follow the chamber with plain lags."""
    time = torch.arange(int(program.seconds / 20), dtype=torch.float64) * 20
    shown = [thermometer(time, program.asked(time), lag, cold_start=False) + offset * place for place, lag in enumerate(lags)]
    names = ("time_s", "temperature_c", "temperature_outer_c")[: len(lags) + 1]
    table = torch.stack([time, *shown, torch.full_like(time, reference)], dim=1)
    block = torch.arange(len(time)) // 5
    return Run("run_1", unit, 100.0, (*names, f"reference_{unit}"), table, torch.zeros_like(time), torch.ones_like(block), block)


PROGRAMS = {"cycle": cycle(-40.0, 60.0, 20.0, 1.0, 3600.0).of(1), "staircase": staircase(-40.0, 60.0, 20.0, 0.5, 2700.0).of(1)}


@pytest.mark.parametrize("lag", [600.0, 1200.0, 2400.0])
@pytest.mark.parametrize("name", PROGRAMS)
def test_the_lag_behind_the_air_is_found_from_the_air_s_corners(name: str, lag: float) -> None:
    (found,) = circumstances_of([recorded(PROGRAMS[name], (lag,))]).lags_s
    assert found == pytest.approx(lag, rel=0.25)  # means over five minutes blur a corner


def test_thermometers_that_never_move_leave_the_prior() -> None:
    still = Program(((20.0, 20.0, 20000.0),))
    assert circumstances_of([recorded(still, (900.0,))]).lags_s == (PACKAGE_S,)


def test_a_thermometer_nearer_to_the_air_leads_and_keeps_its_offset() -> None:
    found = circumstances_of([recorded(PROGRAMS["cycle"], (1500.0, 1200.0), offset=0.7)])
    assert found.lags_s[0] > found.lags_s[1]
    assert found.offsets_k == pytest.approx((0.0, 0.7))


def test_programs_stay_within_what_was_seen_and_below_the_self_heating() -> None:
    run = recorded(PROGRAMS["cycle"], (600.0,))
    found = circumstances_of([run])
    low, high = float(run.temperature.min()), float(run.temperature.max())
    assert low <= found.low_c + 0.5
    assert found.low_c - low < 5.5
    assert found.high_c <= high - SELF_HEATING_K + 0.5
    assert found.low_c <= found.start_c <= found.high_c


def test_a_gyro_without_a_true_input_can_be_turned_against_the_earth_and_an_accelerometer_cannot() -> None:
    none = circumstances_of([recorded(PROGRAMS["cycle"], (600.0,), reference=0.0)])
    assert (none.usual, none.reference) == (0.0, EARTH_DPH)
    assert circumstances_of([recorded(PROGRAMS["cycle"], (600.0,), reference=0.0, unit="ug")]).reference is None


def test_a_cold_start_begins_colder_and_ends_where_it_would() -> None:
    time = torch.arange(2000, dtype=torch.float64) * 20
    cold = thermometer(time, torch.full_like(time, 20.0), 1200.0, cold_start=True)
    assert float(cold[0]) == 20.0 - SELF_HEATING_K
    assert float(cold[60]) == pytest.approx(20.0 - SELF_HEATING_K * math.exp(-1.0), abs=1e-9)
    assert float(cold[-1]) == pytest.approx(20.0, abs=1e-9)


def test_a_range_too_short_for_a_margin_is_used_as_it_was() -> None:
    run = recorded(Program(((20.0, 20.0, 3600.0), (20.0, 30.0, 3600.0), (30.0, 30.0, 7200.0))), (600.0,))
    found = circumstances_of([replace(run)])
    assert (found.low_c, found.high_c) == pytest.approx((20.0, 30.0), abs=0.1)


def test_a_run_shorter_than_some_minutes_is_one_mean() -> None:
    short = recorded(Program(((20.0, 21.0, 200.0),)), (900.0,))
    assert short.blocks == 2
    found = circumstances_of([recorded(PROGRAMS["cycle"], (900.0,)), short])
    assert math.isfinite(found.lags_s[0])
