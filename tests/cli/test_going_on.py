"""A training that was killed goes on by itself from its own data only."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import torch

from zoo.cli.application import run

SIMULATED = ["data=simulated", "data.simulated.runs=1", "+data.simulated.profile=sine", "+data.simulated.sample_s=60", "data.files=[run_1.parquet]"]
GYRO = "defaults: [medium]\nrandom_walk: {}\n"


def record(name: str, seed: int) -> None:
    time = np.arange(0, 4 * 3600, 20.0)
    temperature = 40 + 20 * np.sin(time / 2000 + seed)
    columns = np.column_stack([time, temperature, 0.2 * np.tanh((temperature - 35) / 8)])
    np.savetxt(name, columns, "%.6f", ",", header="time_s,temperature_c,rate_dph", comments="")


def simulated(folder: Path) -> tuple[list[str], Path]:
    """Settings that ask for runs of the user's own gyro, and its YAML."""
    gyro = folder / "conf" / "gyro" / "mine.yaml"
    gyro.parent.mkdir(parents=True)
    gyro.write_text(GYRO.format(0.001))
    return [*SIMULATED, "data.simulated.gyro=mine", f"hydra.searchpath=[file://{folder / 'conf'}]"], gyro


def train(*settings: str, epochs: int) -> None:
    assert run("train", [*settings, "data.average_s=100", f"epochs={epochs}", "hydra.run.dir=out"]) == 0


def killed(*settings: str) -> None:
    """Leaves what a training does that is killed after three steps."""
    train(*settings, epochs=3)
    checkpoint = torch.load("out/last.ckpt", weights_only=True)
    shutil.rmtree("out")
    Path("out").mkdir()
    torch.save(checkpoint | {"finished": False}, "out/last.ckpt")


def goes_on(*settings: str, capsys: pytest.CaptureFixture[str]) -> bool:
    capsys.readouterr()
    train(*settings, epochs=6)
    return "going on from" in capsys.readouterr().out


@pytest.mark.parametrize("change", ["nothing", "a run is corrected", "a run to check on is corrected", "there is a run more"])
def test_files_that_are_others_begin_anew(change: str, capsys: pytest.CaptureFixture[str]) -> None:
    for seed, name in enumerate(("run_1.csv", "run_2.csv", "check.csv")):
        record(name, seed)
    settings = ["data.files=[run_*.csv]", "data.check_files=[check.csv]"]
    killed(*settings)
    changed = {"a run is corrected": "run_1.csv", "a run to check on is corrected": "check.csv", "there is a run more": "run_3.csv"}.get(change)
    if changed:
        record(changed, 7)
    assert goes_on(*settings, capsys=capsys) == (change == "nothing")


def test_what_went_on_from_an_older_training_goes_on_from_where_it_was_killed(capsys: pytest.CaptureFixture[str]) -> None:
    record("run_1.csv", 0)
    files = "data.files=[run_1.csv]"
    train(files, epochs=2)
    Path("out").rename("old")
    killed(files, "resume=old")
    assert goes_on(files, "resume=old", capsys=capsys)
    killed(files, "resume=old")
    assert not goes_on(files, capsys=capsys), "which begins with other weights"


@pytest.mark.parametrize("changed", [False, True])
def test_a_simulation_that_is_another_begins_anew(changed: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The settings are the same: what has changed is the YAML of the gyro that they name."""
    settings, gyro = simulated(tmp_path)
    killed(*settings)
    if changed:
        gyro.write_text(GYRO.format(0.1))
    assert goes_on(*settings, capsys=capsys) == (not changed)


@pytest.mark.parametrize("changed", [False, True])
def test_a_sweep_does_again_what_came_of_another_simulation(changed: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    settings, gyro = simulated(tmp_path)
    sweep = ["-m", *settings, "model=polynomial", "hydra.sweep.dir=sweep"]
    assert run("train", sweep) == 0
    if changed:
        gyro.write_text(GYRO.format(0.1))
    capsys.readouterr()
    assert run("train", sweep) == 0
    assert ("finished by an earlier sweep" in capsys.readouterr().out) == (not changed)
