"""The accelerometer of hui2016: the printed line, the physics behind it, and its files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor

from zoo.artifacts import write_json
from zoo.errors import InputError
from zoo.measurements.read import read_runs
from zoo.measurements.write import write_measurements
from zoo.simulator.accelerometer.beams import beam_temperatures, drift_pulses, over_gate
from zoo.simulator.accelerometer.preset import HUI2016, PARAMETERS, accelerometer, specimen
from zoo.simulator.accelerometer.runs import PowerOnRun, simulate_accelerometer

SILENT = {"random_walk": 0.0, "count_step": 0.0, "thermometer": 0.0, "repeatability": 0.0}
LINE_MAX, LINE_VARIANCE, NETWORK_VARIANCE = 1.3211, 0.138, 2.834e-9


def line_residual(one: PowerOnRun) -> Tensor:
    """(T,) what a least-squares line of the pulses over the temperature rise leaves."""
    rise = one.table["temperature_c"] + 40
    powers = torch.stack([torch.ones_like(rise), rise], dim=1)
    return one.table["pulses"] - powers @ torch.linalg.lstsq(powers, one.table["pulses"].unsqueeze(1), driver="gelsd").solution.squeeze(1)


@pytest.mark.parametrize("seed", range(5))
def test_the_line_leaves_what_the_paper_prints(seed: int) -> None:
    left = line_residual(simulate_accelerometer(seed=seed).runs[0])
    assert len(left) == 48
    assert float(left.abs().max()) == pytest.approx(LINE_MAX, rel=0.01)
    assert float(left.var(correction=0)) == pytest.approx(LINE_VARIANCE, rel=0.01)


def test_the_noise_leaves_room_for_the_network_of_the_paper() -> None:
    done = simulate_accelerometer(runs=40)
    noise = torch.cat([one.noise for one in done.runs])
    white = 10 * HUI2016["scale"] * 1e-6 * HUI2016["random_walk"] / 10**0.5
    assert float(noise.var()) == pytest.approx(white**2 + HUI2016["count_step"] ** 2 / 6, rel=0.1)
    assert float(noise.var()) < 0.1 * NETWORK_VARIANCE


def test_so_does_the_thermometer() -> None:
    """Its noise, times the steepest slope of the pulses over the temperature."""
    one = simulate_accelerometer(accelerometer(**SILENT)).runs[0]
    slope = torch.diff(one.table["pulses"]) / torch.diff(one.table["temperature_c"])
    assert float((slope * HUI2016["thermometer"]).abs().max()) ** 2 < 0.1 * NETWORK_VARIANCE


def test_the_warm_up_is_monotone_so_that_the_pulses_are_a_function_of_the_temperature() -> None:
    table = simulate_accelerometer().runs[0].table
    assert table["time_s"].tolist() == [10.0 * place for place in range(1, 49)]
    assert float(torch.diff(table["temperature_c"]).min()) > 0
    assert -40 < float(table["temperature_c"][0]) < -39.5
    assert -35 < float(table["temperature_c"][-1]) < -25


def test_temperatures_are_means_over_the_count_exactly() -> None:
    """The mean of 1 − exp(−t/τ) over a count from a to b: 1 + τ·(exp(−b/τ) − exp(−a/τ))/(b − a)."""
    ends = torch.arange(10, 490, 10, dtype=torch.float64)
    pulled, pressed = over_gate(beam_temperatures(HUI2016, -40.0, ends, 10.0))

    def risen(tau: float) -> Tensor:
        return 1 + tau / 10 * ((-ends / tau).exp() - (-(ends - 10) / tau).exp())

    common = -40 + HUI2016["unit_heating"] * risen(HUI2016["unit_time"]) + HUI2016["heating"] * risen(HUI2016["heating_time"])
    assert torch.allclose((pulled + pressed) / 2, common, atol=1e-12)
    assert torch.allclose(pulled - pressed, HUI2016["gradient"] * risen(HUI2016["heating_time"]), atol=1e-12)


def test_equal_beams_of_equal_temperature_show_no_temperature() -> None:
    same = accelerometer(offset=0.0, turnover_1=25.0, turnover_2=25.0, gradient=0.0, scale_drift=0.0)
    beams = beam_temperatures(same, -40.0, torch.tensor([10.0, 20.0]), 10.0)
    assert all(float(part.abs().max()) < 1e-9 for part in drift_pulses(same, beams, 0.0, 10.0).values())


def test_a_small_gradient_acts_through_the_slope_of_the_parabola() -> None:
    """dΔf = 2βf(T − T₀)·δT for beams δT apart."""
    device = accelerometer(offset=0.0, turnover_1=25.0, turnover_2=25.0, gradient=1e-3, heating=0.0, unit_heating=0.0, scale_drift=0.0)
    beams = beam_temperatures(device, -40.0, torch.tensor([1e5], dtype=torch.float64), 10.0)
    slope = 2 * HUI2016["parabola"] * HUI2016["frequency"] * (-40 - 25)
    assert float(drift_pulses(device, beams, 0.0, 10.0)["thermal_gradient"]) == pytest.approx(10 * slope * 1e-3, rel=1e-9)


def test_without_noise_the_error_is_the_sum_of_the_causes() -> None:
    one = simulate_accelerometer(accelerometer(**SILENT)).runs[0]
    causes = [value for key, value in one.truth.items() if key.endswith("_pulses") and key != "sum_pulses"]
    assert torch.allclose(torch.stack(causes).sum(0), one.truth["sum_pulses"])
    assert float(one.noise.abs().max()) < 1e-9


def test_the_pulses_follow_the_force() -> None:
    device = accelerometer(**SILENT, scale_drift=0.0, parabola=0.0)
    up, level = (simulate_accelerometer(device, force_g=force).runs[0].table["pulses"] for force in (1.0, 0.0))
    assert torch.allclose(up - level, torch.full_like(up, 10 * HUI2016["scale"]))


@pytest.mark.parametrize("force", [-1.0, 0.0, 1.0, 20.0])
def test_the_pulses_are_those_of_the_two_parabolas_under_load(force: float) -> None:
    """The difference of two beams at f_i·(1 + β(T_i − T_0i)²), f_i as the force pulls and presses them, counted for 10 s."""
    device = accelerometer(**SILENT, scale_drift=0.0, heating_time=1e-9, unit_time=1e9)
    shown = simulate_accelerometer(device, force_g=force).runs[0].table["pulses"]
    warmer = -40 + device["heating"]
    difference = 0.0
    for sign, turnover in ((1, device["turnover_1"]), (-1, device["turnover_2"])):
        frequency = device["frequency"] + sign * (device["offset"] + device["scale"] * force) / 2
        difference += sign * frequency * (1 + device["parabola"] * (warmer + sign * device["gradient"] / 2 - turnover) ** 2)
    assert torch.allclose(shown, torch.full_like(shown, 10 * difference), rtol=0, atol=1e-3)


def test_the_parabola_lowers_the_scale_factor_in_the_cold() -> None:
    """At 1 g and −40 °C by β(T − 25)² of 400 Hz/g, half a pulse in 10 s, a sixth of a pulse of which is gone in the end; the bias knows no force."""
    level, up = (simulate_accelerometer(accelerometer(**SILENT, scale_drift=0.0), force_g=force).runs[0].truth for force in (0.0, 1.0))
    lost = up["scale_factor_pulses"]
    assert float(lost[0]) == pytest.approx(10 * HUI2016["scale"] * HUI2016["parabola"] * (-40 - 25) ** 2, rel=0.02)
    assert float(lost[-1] - lost[0]) == pytest.approx(0.166, abs=0.001)
    assert float(level["scale_factor_pulses"].abs().max()) == 0
    assert torch.equal(level["static_bias_pulses"], up["static_bias_pulses"])


def test_the_seed_reproduces_and_more_runs_change_nothing() -> None:
    first, again, more, other = (simulate_accelerometer(**one) for one in ({}, {}, {"runs": 3}, {"seed": 2}))
    for key, value in first.runs[0].table.items():
        assert torch.equal(value, again.runs[0].table[key])
        assert torch.equal(value, more.runs[0].table[key])
        assert torch.equal(first.check.table[key], more.check.table[key])
    assert not torch.equal(first.runs[0].table["pulses"], other.runs[0].table["pulses"])
    assert not torch.equal(first.runs[0].table["pulses"], first.check.table["pulses"])


def test_specimens_differ_within_their_spread() -> None:
    east, north = (specimen(HUI2016, 1, place) for place in ("east", "north"))
    assert east == specimen(HUI2016, 1, "east")
    assert east["gradient"] != north["gradient"]
    for key in PARAMETERS:
        assert abs(east[key] / HUI2016[key] - 1) <= getattr(HUI2016, key).spread + 1e-12


def test_files_read_back_and_the_truth_has_units(tmp_path: Path) -> None:
    done = simulate_accelerometer(runs=2)
    for one in (*done.runs, done.check):
        write_measurements(tmp_path / f"{one.name}.csv", one.table)
    read = read_runs([str(tmp_path / "run_*.csv")], average_s=None)
    assert [run.unit for run in read] == ["pulses", "pulses"]
    assert torch.allclose(read[0].error, done.runs[0].table["pulses"] - done.runs[0].table["reference_pulses"])
    truth = json.loads(write_json(tmp_path / "truth.json", done.truth()).read_text())
    assert truth["effects"] == ["static_bias", "thermal_gradient", "scale_factor", "bias_repeatability"]
    assert all(isinstance(one["value"], float) and one["unit"] and one["source"] for one in truth["device"].values())
    assert [one["file"] for one in truth["runs"]] == ["run_1.csv", "run_2.csv"]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"runs": 0}, "runs=0"),
        ({"runs": 1.5}, "runs=1.5: a whole number"),
        ({"seed": -1}, "seed=-1"),
        ({"soak_c": -300}, "soak_c=-300"),
        ({"soak_c": "cold"}, "soak_c=cold"),
        ({"seconds": float("nan")}, "seconds=nan"),
        ({"sample_s": 0}, "sample_s=0"),
        ({"sample_s": True}, "sample_s=True"),
        ({"seconds": 15.0}, "makes 1 counts"),
        ({"sample_s": 1e-3, "seconds": 86400.0}, "sample_s=0.001"),
        ({"force_g": -2.5}, "change places"),
    ],
)
def test_absurd_settings_are_refused(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        simulate_accelerometer(**settings)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": "hui2061"}, "did you mean hui2016"),
        ({"gradent": 1.0}, "did you mean gradient"),
        ({"scale": 0.0}, r"gyro\.scale=0.0: a number above 0"),
        ({"random_walk": -1.0}, "from 0 up"),
        ({"heating": "warm"}, r"gyro\.heating=warm"),
        ({"heating": float("inf")}, r"gyro\.heating=inf"),
    ],
)
def test_absurd_accelerometers_are_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        accelerometer(**changes)
