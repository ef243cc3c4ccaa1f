"""`fogzoo simulate gyro=hui2016`: an accelerometer asked for, written and read as gyros are."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest
import torch

from zoo.catalog import build
from zoo.cli.application import run
from zoo.measurements.read import read_runs
from zoo.simulator.accelerometer.preset import HUI2016, PARAMETERS
from zoo.simulator.accelerometer.runs import simulate_accelerometer

FILES = ["check.csv", "run_1.csv", "run_2.csv", "truth_1.csv", "truth_2.csv", "truth_check.csv"]
HELD = "profile.legs=[[20,20,300]]"


def simulated(folder: Path, *arguments: str) -> Path:
    assert run("simulate", ["gyro=hui2016", *arguments, f"hydra.run.dir={folder}"]) == 0
    return folder


def error(folder: Path, name: str = "run_1") -> pd.Series:
    table = pd.read_csv(folder / f"{name}.csv")
    return table["pulses"] - table["reference_pulses"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulated(tmp_path_factory.mktemp("hui2016"), "runs=2")


def test_the_preset_of_the_yaml_is_that_of_the_code() -> None:
    assert build("gyro", "hui2016") == HUI2016


def test_the_yaml_names_every_parameter() -> None:
    text = (Path(__file__).parents[2] / "conf" / "gyro" / "hui2016.yaml").read_text(encoding="utf-8")
    assert all(f"  {key}: null # " in text for key in PARAMETERS)


def test_the_files_are_those_of_any_gyro(folder: Path) -> None:
    assert sorted(path.name for path in folder.glob("*.csv")) == FILES
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    assert (truth["gyro"], truth["unit"], truth["seed"], truth["hidden"]) == ("hui2016", "pulses", 1, [])
    assert [one["truth"] for one in truth["runs"]] == ["truth_1.csv", "truth_2.csv"]
    columns = [f"{effect}_pulses" for effect in truth["effects"]]
    assert list(pd.read_csv(folder / "truth_1.csv")) == ["time_s", *columns, "sum_pulses", "temperature_pulled_c", "temperature_pressed_c"]


def test_without_a_profile_it_is_the_power_on_of_the_paper(folder: Path) -> None:
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    assert [one["legs"] for one in (*truth["runs"], truth["check"])] == [[[-40, -40, 480]], [[-40, -40, 480]], [[-20, -20, 480]]]
    assert 0 < pd.read_csv(folder / "check.csv")["temperature_c"][0] + 20 < 0.5
    made, read = simulate_accelerometer(runs=2), read_runs([str(folder / "run_*.csv")], average_s=None)
    for one, file in zip(made.runs, read, strict=True):
        assert torch.equal(one.error, file.error)
        assert (file.unit, file.rows) == ("pulses", 48)


def test_the_table_speaks_of_an_accelerometer_and_pulses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simulated(tmp_path, "seed=3")
    shown = capsys.readouterr().out
    assert "hui2016 accelerometer, profile hui2016, seed 3" in shown
    assert "error std pulses" in shown
    assert "°/h" not in shown
    assert shown.strip().splitlines()[-1] == str(tmp_path)
    run("simulate", ["profile=legs", f"{HELD}", "runs=1", f"hydra.run.dir={tmp_path / 'gyro'}"])
    shown = capsys.readouterr().out
    assert "medium gyro, profile legs, seed 1" in shown
    assert "error std °/h" in shown


def test_device_k_is_what_its_seed_gives_by_itself(tmp_path: Path, folder: Path) -> None:
    many = simulated(tmp_path, "devices=2", "runs=2")
    assert sorted(path.name for path in many.glob("device_*")) == ["device_1", "device_2"]
    assert all((many / "device_1" / name).read_bytes() == (folder / name).read_bytes() for name in (*FILES, "truth.json"))
    assert (many / "device_2" / "run_1.csv").read_bytes() != (folder / "run_1.csv").read_bytes()


def test_profile_and_step_are_its_own(tmp_path: Path) -> None:
    made = simulated(tmp_path, "profile=legs", "profile.legs=[[20,20,300]]", "profile.check=[[0,0,62]]", "sample_s=5", "runs=1")
    first, check = (pd.read_csv(made / name) for name in ("run_1.csv", "check.csv"))
    assert list(first["time_s"]) == [5.0 * count for count in range(1, 61)]
    assert len(check) == 12
    assert 0 < first["temperature_c"][0] - 20 < 0.5
    assert 0 < check["temperature_c"][0] < 0.5


@pytest.mark.parametrize(("axis", "force"), [("up", 1.0), ("down", -1.0), ("east", 0.0), ("north", 0.0), ("[3,0,4]", 0.8)])
def test_the_axis_says_what_it_feels(tmp_path: Path, axis: str, force: float) -> None:
    made = simulated(tmp_path, f"axis={axis}", "runs=1")
    pulses = 10 * (HUI2016["offset"] + HUI2016["scale"] * force)
    assert pd.read_csv(made / "run_1.csv")["reference_pulses"].unique().tolist() == pytest.approx([pulses], abs=1e-9)


def test_without_noise_the_error_is_the_sum_of_the_causes(tmp_path: Path) -> None:
    made = simulated(tmp_path, "noise=none", "runs=1")
    truth = pd.read_csv(made / "truth_1.csv")
    assert float((error(made) - truth["sum_pulses"]).abs().max()) < 1e-9
    assert (truth["bias_repeatability_pulses"] == truth["bias_repeatability_pulses"][0]).all()


def test_a_number_of_the_accelerometer_can_be_set(tmp_path: Path) -> None:
    made = simulated(tmp_path, "gyro.repeatability=0", "runs=1")
    assert pd.read_csv(made / "truth_1.csv")["bias_repeatability_pulses"].abs().max() == 0
    assert json.loads((made / "truth.json").read_text(encoding="utf-8"))["device"]["repeatability"] == {"value": 0.0, "unit": "µg", "source": "given"}


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        *[([one], one) for one in ("effects=[shupe]", "hidden=1", "latitude_deg=50", "heat=lumped", "reference_dph=3", "amplitude=1")],
        *[([one], one) for one in ("thermometers=3", "noise.random_walk=0.01", "chamber.cycling_k=0.2", "hidden=mohr")],
        (["noise=none", "noise.flicker=0.1"], "noise.flicker=0.1: is for gyros"),
        (["+parameters.mohr.coefficient=1"], "parameters={"),
        (["profile=campaign"], "goes from -40 to 60 °C"),
        (["profile=legs", HELD, "profile.rates=[[10,60]]"], "turns a rate table"),
        (["profile=legs", "profile.legs=[[-100,-100,60]]"], "profile: soak_c=-100: a number from -60 to 85 °C"),
        (["profile=legs", "profile.legs=[[20,20,15]]"], "sample_s=10: makes 1 counts of 15 s"),
        (["sample_s=100"], "sample_s=100: a number from"),
        (["axis=sideways"], "axis=sideways"),
        (["runs=0"], "runs=0"),
        (["devices=0"], "devices=0"),
        (["+gyro.gradent=1"], "did you mean gradient"),
        (["gyro.name=hui"], "did you mean hui2016"),
        (["gyro.offset=-500"], "-offset/scale"),
        (["torch_device=gpu"], "torch_device=gpu"),
    ],
)
def test_what_means_nothing_to_it_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], overrides: list[str], words: str) -> None:
    assert run("simulate", ["gyro=hui2016", *overrides, f"hydra.run.dir={tmp_path}"]) == 2
    message = capsys.readouterr().err
    assert words in message
    assert len(message.strip().splitlines()) <= 2
    assert not list(tmp_path.glob("*.csv"))


def test_a_diagnosis_of_too_few_rows_says_what_helps(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("diagnose", [f"data.files=[{folder}/run_1.csv]", f"hydra.run.dir={tmp_path}"]) == 2
    message = capsys.readouterr().err
    assert "no data.average_s helps, there are only 48 rows: give more runs, or record longer or more often" in message
    assert run("diagnose", [f"data.files=[{folder}/run_*.csv]", "data.average_s=40", f"hydra.run.dir={tmp_path}"]) == 2
    assert "set data.average_s smaller" in capsys.readouterr().err


def test_a_sweep_over_seeds_and_a_model_of_the_first(folder: Path, tmp_path: Path) -> None:
    assert run("simulate", ["-m", "gyro=hui2016", "seed=1,2", "runs=2", f"hydra.sweep.dir={tmp_path}/sweep"]) == 0
    assert (tmp_path / "sweep" / "0" / "run_1.csv").read_bytes() == (folder / "run_1.csv").read_bytes()
    files = f"data.files=[{tmp_path}/sweep/0/run_1.csv]"
    assert run("train", ["model=polynomial", files, "data.average_s=null", f"hydra.run.dir={tmp_path}/line"]) == 0
    others = f"data.files=[{tmp_path}/sweep/1/run_1.csv]"
    assert run("compare", [f"runs=[{tmp_path}/line]", others, "data.average_s=null", f"hydra.run.dir={tmp_path}/compared"]) == 0
    table = pd.read_csv(tmp_path / "compared" / "comparison.csv")
    assert (table["polynomial"] < 0.1 * table["uncompensated"]).all()
