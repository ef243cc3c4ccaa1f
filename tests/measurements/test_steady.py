"""Thermometers' readings drawn smooth, against temperatures that are known."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from zoo.measurements.run import Run
from zoo.measurements.steady import FEWEST, drawn, scatter, steadied
from zoo.physics.lag import lagged

STEP_S = 20.0


def seconds(count: int = 1500) -> torch.Tensor:
    return STEP_S * torch.arange(count, dtype=torch.float64)


def chamber(time: torch.Tensor, lag_s: float = 300.0) -> torch.Tensor:
    """A body behind air that ramps by 1 K/min between holds [°C]."""
    hours = time / 3600.0
    air = 20.0 + 60.0 * ((hours - 1.0).clamp(0.0, 0.75) - (hours - 3.0).clamp(0.0, 1.25) + (hours - 6.0).clamp(0.0, 0.5))
    return lagged(time, air, torch.tensor(lag_s, dtype=torch.float64))


def noise(count: int, seed: int) -> torch.Tensor:
    return torch.randn(count, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def quantised(values: torch.Tensor, step: float) -> torch.Tensor:
    return step * torch.round(values / step)


@settings(max_examples=20, deadline=None)
@given(st.floats(-40, 70), st.floats(-3, 3), st.integers(FEWEST, 400))
def test_a_steady_ramp_is_what_it_is(start: float, k_per_min: float, count: int) -> None:
    ramp = start + k_per_min * seconds(count) / 60.0
    torch.testing.assert_close(drawn(seconds(count), ramp), ramp, rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("scatter_k", "step_k"), [(0.02, 0.0625), (0.05, 0.0), (0.0, 0.0625), (0.005, 0.25)])
def test_readings_of_a_chamber_run_come_nearer_the_temperature(seed: int, scatter_k: float, step_k: float) -> None:
    true = chamber(seconds())
    readings = true + scatter_k * noise(len(true), seed)
    readings = quantised(readings, step_k) if step_k else readings
    moving = torch.diff(true, append=true[-1:]).abs() > step_k / 5  # a reading that stands still in a hold says nothing of its step
    before, after = (readings - true)[moving].std(), (drawn(seconds(), readings) - true)[moving].std()
    assert after < 0.4 * before


@pytest.mark.parametrize("seed", range(5))
def test_what_the_readings_show_stays(seed: int) -> None:
    """A compressor's wave of a few samples, and a jump: neither is scatter."""
    time = seconds()
    wave = 0.3 * torch.sin(2 * math.pi * time / (8 * STEP_S))
    jump = torch.where(time > time[700], 2.0, 0.0).to(time)
    for shown in (wave, jump):
        readings = chamber(time) + shown + 0.02 * noise(len(time), seed)
        off = drawn(time, readings) - readings
        assert float(off.abs().max()) < 0.02 * 6


def test_scatter_is_that_of_the_readings() -> None:
    true = chamber(seconds())
    for sigma in (0.01, 0.1):
        assert scatter(true + sigma * noise(len(true), 1)) == pytest.approx(sigma, rel=0.1)
    assert scatter(quantised(true + 0.02 * noise(len(true), 1), 0.0625)) == pytest.approx(math.hypot(0.02, 0.0625 / math.sqrt(12)), rel=0.15)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_readings_have_a_scatter_as_well(count: int) -> None:
    """Too few for differences of differences: that of their steps."""
    assert scatter(torch.tensor([20.0, 20.3, 20.3][:count], dtype=torch.float64)) == pytest.approx(0.0 if count < 2 else 0.3 / 12**0.5)


def test_steps_count_where_readings_stand_still() -> None:
    """Without noise most neighbours are alike, and differences show nothing."""
    slow = 20.0 + 0.01 * seconds() / 60.0
    assert scatter(quantised(slow, 0.0625)) == pytest.approx(0.0625 / math.sqrt(12), rel=1e-6)


def a_run(count: int) -> Run:
    time = seconds(count)
    inner, outer = (chamber(time) + 0.05 * noise(count, seed) for seed in (2, 3))
    table = torch.stack([time, inner, outer, noise(count, 4), torch.zeros_like(time)], dim=1)
    columns = ("time_s", "temperature_c", "temperature_outer_c", "supply_v", "reference_dph")
    ones = torch.ones(count, dtype=torch.int64)
    return Run("run_1", "dph", 100.0, columns, table, noise(count, 5), ones, torch.arange(count) // 5)


def test_only_thermometers_are_drawn_and_the_run_that_was_read_stays() -> None:
    run = a_run(600)
    before = run.table.clone()
    steady = steadied(run)
    assert steady.as_read.read is None
    torch.testing.assert_close(steady.as_read.table, before, rtol=0, atol=0)
    assert run.as_read is run
    torch.testing.assert_close(run.table, before, rtol=0, atol=0)
    same = [run.columns.index(name) for name in run.columns if name not in run.thermometers]
    torch.testing.assert_close(steady.table[:, same], run.table[:, same], rtol=0, atol=0)
    for name in run.thermometers:
        assert float((steady.column(name) - chamber(run.time)).std()) < 0.5 * 0.05


def test_too_few_readings_are_as_they_were_read() -> None:
    run = a_run(FEWEST - 1)
    torch.testing.assert_close(steadied(run).table, run.table, rtol=0, atol=0)


def test_a_reading_is_drawn_the_same_on_any_clock() -> None:
    run = a_run(300)
    later = replace(run, table=torch.cat([run.table[:, :1] + 1.7e9, run.table[:, 1:]], dim=1))
    torch.testing.assert_close(steadied(later).table[:, 1:], steadied(run).table[:, 1:], rtol=0, atol=1e-9)
