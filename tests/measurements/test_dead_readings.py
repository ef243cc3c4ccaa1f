"""A thermometer that jumps as no temperature does is named, and nothing else is."""

from __future__ import annotations

import numpy as np
import pytest

from zoo.measurements.dead_readings import jumps
from zoo.measurements.read import read_runs

TIME_S = np.arange(0.0, 36_000.0, 20.0)
SEGMENT = np.zeros(len(TIME_S), dtype=int)


def chamber(rate_k_per_min: float) -> np.ndarray:
    """From 20 °C up to 80 °C after an hour, as fast as that."""
    return np.minimum(20.0 + rate_k_per_min / 60.0 * np.maximum(TIME_S - 3600.0, 0.0), 80.0)


@pytest.mark.parametrize("rate", [0.5, 5.0, 30.0])
def test_no_chamber_makes_a_thermometer_jump(rate: float) -> None:
    scatter = 0.5 * np.random.default_rng(0).standard_normal(len(TIME_S))
    assert jumps("t", TIME_S, chamber(rate) + scatter, SEGMENT) == []


def test_one_that_read_nothing_for_some_minutes_is_named() -> None:
    readings = chamber(1.0)
    readings[900:950] = 0.0
    (told,) = jumps("temp_case", TIME_S, readings, SEGMENT)
    assert told.startswith("temp_case jumps by up to 80 K within 20 s (about 18000 s, 19000 s): no temperature does; leave these rows out")


def test_many_jumps_are_counted() -> None:
    readings = chamber(1.0)
    readings[100:1000:100] = -200.0
    (told,) = jumps("t", TIME_S, readings, SEGMENT)
    assert "(about 2000 s, 2020 s, 4000 s and 15 more)" in told


def test_over_a_gap_a_temperature_may_have_gone_anywhere() -> None:
    later, far = np.where(TIME_S > 20_000.0, TIME_S + 10.0, TIME_S), np.where(TIME_S > 20_000.0, 60.0, 20.0)
    assert jumps("t", later, far, (TIME_S > 20_000.0).astype(int)) == []
    assert len(jumps("t", later, far, SEGMENT)) == 1


def test_a_run_is_read_with_a_note_of_it(tmp_path) -> None:
    readings = chamber(1.0)
    readings[900] = -200.0
    rows = "\n".join(f"{time:g},{temperature:.3f},{0.01 * np.sin(time):.6f}" for time, temperature in zip(TIME_S, readings, strict=True))
    (tmp_path / "a.csv").write_text(f"time_s,probe_c,gyro_dph\n{rows}\n")
    (run,) = read_runs([str(tmp_path / "a.csv")], columns={"temperature": "probe_c", "output": "gyro_dph"}, reference=0.0)
    assert any(note.startswith("a: probe_c jumps by up to 280 K") for note in run.notes)
