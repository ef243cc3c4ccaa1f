"""What the tool is for, on data that this project did not simulate: name what is missing, and come down to the noise on a run never fitted.

Needs the project's shared data beside the repository; where it is absent, the thinned copies in tests/golden stand in for three of the cases.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from zoo.catalog import build, names
from zoo.diagnosis.refine import Refinement, refine
from zoo.measurements.read import read_runs
from zoo.measurements.run import Run

ROOT = Path(__file__).resolve().parents[1]
SHARED = ROOT.parent / "shared" / "data"
GOLDEN = Path(__file__).resolve().parent / "golden"
BASE = ["static_bias", "shupe", "mohr"]
CASES: dict[str, tuple[str, set[str]]] = {
    "a": ("complete", set()),
    "b": ("missing", {"hysteresis"}),
    "c": ("missing", {"polarization"}),
    "d": ("missing", {"rate_temperature_coupling"}),
    "e": ("missing", {"warm_up"}),
    "f": ("missing", {"aging", "polarization"}),
    "g": ("missing", {"magnetic"}),
    "h": ("unknown", set()),
}
"""Verdict and hidden effects by case, as their truth.json has them."""
REAL = ["gyro_y_rad_per_s", "acc_x_m_per_s2", "gyro_x_rad_per_s"]
HELD_OUT = 0.3


def refined(runs: list[Run], check: list[Run]) -> Refinement:
    return refine(runs, check, BASE, "auto", {name: build("effects", name) for name in names("effects")})


def judge(case: str, found: Refinement, above_floor: float) -> None:
    """Verdict, names, and the error on the check run."""
    verdict, hidden = CASES[case]
    said, record = found.diagnosis.record, json.loads(json.dumps(found.record, allow_nan=False))
    first, last = record["ladder"][0], record["ladder"][-1]
    ratio = last["rms_check"] / record["noise_floor_check"]
    print(f"case {case}: {said['verdict']} {said['missing']}, check {first['rms_check']:.5f} -> {last['rms_check']:.5f}, {ratio:.2f} x floor")
    assert said["verdict"] == verdict
    if verdict == "unknown":
        assert record["verdict"] == "unknown"
        assert said["rms_final"] > 1.5 * said["noise_floor"]
        return
    assert set(said["missing"]) == hidden
    assert record["verdict"] == "complete"
    assert ratio <= above_floor
    assert record["noise_floor_check"] == pytest.approx(0.008, rel=0.15), "white noise of 0.08 °/h at 1 s, in 100 s"


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_gyro_with_something_hidden(case) -> None:
    folder = SHARED / "mystery" / case
    if not folder.is_dir():
        pytest.skip(f"{folder} is not there: the project's shared data")
    truth = json.loads((folder / "truth.json").read_text())
    assert {name for name in truth["hidden"] if " " not in name} == CASES[case][1]
    runs = read_runs([folder / f"run_{number}.csv" for number in (1, 2, 3)], average_s=100.0)
    judge(case, refined(runs, read_runs(folder / "check.csv", average_s=100.0)), 1.15)


@pytest.mark.parametrize("case", ["b", "d", "h"])
def test_a_gyro_with_something_hidden_in_means_over_100_s(case) -> None:
    """The thinned copies, where there is nothing else, so that this is tested on every machine; see tests/golden/README.md."""
    if (SHARED / "mystery" / case).is_dir():
        pytest.skip("judged at full length")
    runs = read_runs([GOLDEN / f"mystery_{case}_run_{number}.csv.gz" for number in (1, 2, 3)])
    assert [run.blocks for run in runs] == [516, 420, 360]
    judge(case, refined(runs, read_runs(GOLDEN / f"mystery_{case}_check.csv.gz")), 1.2)


def test_the_golden_copies_are_small() -> None:
    assert sum(path.stat().st_size for path in GOLDEN.iterdir()) < 400_000


def cubic_rms(fitted: Run, held_out: Run) -> float:
    """RMS over the held-out blocks that a cubic in temperature leaves, fitted to the others by numpy."""

    def parts(run: Run) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        scaled = run.block_mean(run.temperature).numpy() / 50
        return np.stack([scaled**k for k in range(4)], axis=1), run.block_mean(run.error).numpy()

    (columns, error), (unseen, truth) = parts(fitted), parts(held_out)
    weights = np.linalg.lstsq(columns, error, rcond=None)[0]
    return float(np.sqrt(np.mean((truth - unseen @ weights) ** 2)))


@pytest.mark.slow
@pytest.mark.parametrize("output", REAL)
def test_a_real_recording(output) -> None:
    """An IMU in a thermal chamber: sensor, chamber and physics are not documented, so only what must hold for any answer is asked."""
    path = SHARED / "real" / "imu_chamber.csv"
    if not path.is_file():
        pytest.skip(f"{path} is not there: the project's shared data")
    (run,) = read_runs(path, columns={"output": output})
    fitted, held_out = run.split(HELD_OUT)
    assert held_out.blocks / run.blocks == pytest.approx(HELD_OUT, abs=0.02)
    found = refined([fitted], [held_out])
    said, ladder = json.loads(json.dumps(found.diagnosis.record, allow_nan=False)), found.record["ladder"]
    checks, cubic = [step["rms_check"] for step in ladder], cubic_rms(fitted, held_out)
    steps = ", ".join(f"{one:.3g}" for one in checks)
    print(f"{output}: {said['verdict']} {said['missing']}, held out {steps}, cubic {cubic:.3g}, floor {said['noise_floor']:.3g}")
    assert said["missing"] or said["verdict"] == "unknown", "three effects of a gyro's coil are not all there is in this IMU"
    assert all(math.isfinite(one) for one in checks)
    assert ladder[-1]["rms"] < ladder[0]["rms"] or len(ladder) == 1
    assert checks[-1] < cubic, "what PX4 and ArduPilot fit"
    assert said["rms"] < said["rms_uncompensated"]
