"""What `fogzoo simulate` leaves on disk."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import torch

from zoo.catalog import build
from zoo.cli.application import run as fogzoo
from zoo.errors import InputError
from zoo.measurements.read import read_runs
from zoo.physics.winding import PATTERNS, shupe_weight
from zoo.simulator.files import write
from zoo.simulator.gyros.presets import MEDIUM, PRESETS, gyro_class
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import legs
from zoo.simulator.simulate import simulate
from zoo.simulator.simulation import Simulation
from zoo.units import convert

PROFILE = legs([[20, 20, 1800], [20, 50, 1800], [50, 50, 3630]])
FILES = ["check.csv", "run_1.csv", "run_2.csv", "truth.json", "truth_1.csv", "truth_2.csv", "truth_check.csv"]


def small(**settings: Any) -> Simulation:
    effects = {name: build("effects", name) for name in ("static_bias", "mohr")}
    return simulate(MEDIUM, PROFILE, effects, **{"runs": 2, **settings})


def test_the_files_and_nothing_else(tmp_path: Path) -> None:
    write(small(), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == FILES


def test_same_seed_same_files(tmp_path: Path) -> None:
    write(small(), tmp_path / "a")
    write(small(), tmp_path / "b")
    write(small(seed=2), tmp_path / "c")
    for name in FILES:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
        assert (tmp_path / "a" / name).read_bytes() != (tmp_path / "c" / name).read_bytes()


def test_files_read_back_as_they_were_simulated(tmp_path: Path) -> None:
    done = small()
    write(done, tmp_path)
    for one in [*done.runs, done.check]:
        table = pd.read_csv(tmp_path / f"{one.name}.csv")
        assert list(table) == list(one.table)
        assert all((table[name].to_numpy() == value.numpy()).all() for name, value in one.table.items())
        truth = pd.read_csv(tmp_path / f"truth_{one.name.removeprefix('run_')}.csv")
        assert list(truth) == ["time_s", "static_bias_dph", "mohr_dph", "sum_dph", "temperature_coil_c"]


@pytest.mark.parametrize("average_s", [100.0, 50.0, 20.0])
def test_in_process_runs_are_those_read_from_the_files(tmp_path: Path, average_s: float) -> None:
    done = small()
    write(done, tmp_path)
    for read, one in zip(read_runs([tmp_path / "run_1.csv", tmp_path / "run_2.csv"], average_s=average_s), done.runs, strict=True):
        made = as_run(one, average_s)
        assert made.columns == read.columns
        assert (made.name, made.unit, made.average_s, made.rows) == (read.name, read.unit, read.average_s, read.rows)
        for field in ("table", "error", "count", "block"):
            assert torch.allclose(getattr(made, field).double(), getattr(read, field).double(), atol=1e-12)


def test_truth_json_names_every_parameter_with_its_unit(tmp_path: Path) -> None:
    catalogue = {"aging": build("effects", "aging")}
    truth = json.loads((write(small_hidden(catalogue), tmp_path) / "truth.json").read_text())
    assert truth["effects"] == ["static_bias"]
    assert truth["hidden"] == ["aging"]
    assert truth["parameters"]["aging"].keys() == {"bend", "goes_on", "drift"}
    assert truth["parameters"]["static_bias"]["slope"]["unit"] == "°/h/K"
    for group in (*truth["parameters"].values(), truth["device"], truth["noise"], truth["rms"]):
        assert all(isinstance(one["value"], float) and one["unit"] for one in group.values())


def small_hidden(catalogue: dict[str, Any]) -> Simulation:
    return simulate(MEDIUM, PROFILE, {"static_bias": build("effects", "static_bias")}, hidden=1, catalogue=catalogue, runs=1)


def winding(tmp_path: Path, **changes: Any) -> tuple[Simulation, dict[str, Any]]:
    """A gyro, and what truth.json says of its winding."""
    effects = {name: build("effects", name) for name in ("shupe", "mohr")}
    done = simulate(gyro_class(**{"name": "medium", **changes}), PROFILE, effects, runs=1, sample_s=30.0)
    truth = json.loads((write(done, tmp_path) / "truth.json").read_text())
    assert (truth["winding"]["layers"], truth["winding"]["turns"]) == (done.device.coil.layers, done.device.coil.turns)
    assert truth["parameters"]["shupe"]["weight"]["value"] == truth["winding"]["shupe_weight"]["value"]
    return done, truth["winding"]


@pytest.mark.parametrize("pattern", [one for one in PATTERNS if one != "crossover_free"])
def test_the_weight_in_the_truth_is_that_of_the_winding(tmp_path: Path, pattern: str) -> None:
    for changes in ({"winding_error_turns": 0}, {}, {"trimmed": 0.8}):
        done, said = winding(tmp_path, pattern=pattern, **changes)
        assert said["pattern"] == pattern
        assert said["shupe_weight"]["value"] == pytest.approx(convert(shupe_weight(done.device.winding), "rad_per_s", "dph"), rel=1e-12)


@pytest.mark.parametrize("name", ["medium", "navigation", "qiu2023", "tong2019"])
def test_the_strain_that_mohrs_effect_takes_is_small(tmp_path: Path, name: str) -> None:
    """The outermost layer's coefficient is off by less than a third of the fibre's 9.4e-6 /K."""
    assert name in PRESETS
    for seed in range(3):
        strain = winding(tmp_path / str(seed), name=name)[1]["strain_for_mohr"]
        assert strain["unit"] == "1/K"
        assert 1e-10 < abs(strain["value"]) < 9.4e-6 / 3


def test_no_strain_is_said_of_a_coil_that_is_blind_to_it(tmp_path: Path) -> None:
    effects = {name: build("effects", name) for name in ("shupe", "mohr")}
    done = simulate(gyro_class("medium", pattern="crossover_free", winding_error_turns=0), PROFILE, effects, runs=1, sample_s=30.0)
    said = json.loads((write(done, tmp_path) / "truth.json").read_text())["winding"]
    assert "strain_for_mohr" not in said
    assert abs(said["shupe_weight"]["value"]) < 1e-9


def test_the_truth_says_how_it_was_recorded(tmp_path: Path) -> None:
    done = small(thermometers=["air", "spool"], latitude_deg=45.0, axis="north", cold_start=True, heat="lumped", sample_s=30.0)
    truth = json.loads((write(done, tmp_path) / "truth.json").read_text())
    assert [one["place"] for one in truth["thermometers"]] == ["air", "spool"]
    assert all(one["time_constant"]["unit"] == "s" and one["offset"]["unit"] == "K" for one in truth["thermometers"])
    assert truth["settings"]["constant_rate"]["value"] == pytest.approx(15.041 / 2**0.5, abs=1e-3)
    assert (truth["settings"]["cold_start"], truth["settings"]["heat"], truth["settings"]["sample_s"]["value"]) == (True, "lumped", 30.0)
    assert truth["settings"]["chamber"]["lag_s"] == 120.0


def test_runs_of_another_simulation_are_not_mixed_in(tmp_path: Path) -> None:
    write(small(runs=3), tmp_path)
    with pytest.raises(InputError, match=r"run_3\.csv"):
        write(small(runs=2), tmp_path)
    write(small(runs=3, seed=2), tmp_path)


@pytest.mark.parametrize("name", ["run_1.csv", "check.csv"])
def test_a_users_own_runs_are_not_overwritten(tmp_path: Path, name: str) -> None:
    own = tmp_path / name
    own.write_text("time_s,temperature_c,rate_dph\n0,20,1\n")
    with pytest.raises(InputError, match=f"holds {name} of something else"):
        write(small(), tmp_path)
    assert list(tmp_path.iterdir()) == [own]


@pytest.fixture(autouse=True)
def _as_a_fresh_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HYDRA_FULL_ERROR", raising=False)
    monkeypatch.setattr(sys, "argv", ["fogzoo"])


def test_the_verb(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    overrides = ["profile=legs", "profile.legs=[[20,20,1800],[20,40,1200]]", "runs=2", "hidden=1", "sample_s=20"]
    code = fogzoo("simulate", [*overrides, f"hydra.run.dir={tmp_path}"])
    output = capsys.readouterr().out
    assert code == 0
    assert output.strip().splitlines()[-1] == str(tmp_path)
    assert {path.name for path in tmp_path.glob("*.csv")} | {"truth.json"} == set(FILES)
    assert len(json.loads((tmp_path / "truth.json").read_text())["hidden"]) == 1


@pytest.mark.parametrize(
    "override",
    [
        *["runs=0", "runs=many", "sample_s=1e9", "hidden=nosuch", "gyro=big", "profile=nosuch", "profile.legs=[[20,-300,60]]", "profile.legs=20"],
        *["gyro.package_s=-1", "nosuch=1", "+gyro.nosuch=1", "noise.random_walk=-1", "+profile.nosuch=1", "effects=[nosuch]", "parameters=3"],
        *["+parameters.mohr.coefficient=big", "+parameters.mohr.coefficient=null", "+parameters.mohr.coefficient=[1]", "gyro.effects=3"],
        *["gyro.conductivity=-1", "gyro.layers=0", "gyro.pattern=spiral", "gyro.trimmed=2"],
        *["gyro.diameter_m=0.005", "heat=3d", "devices=0", "devices=two", "thermometers=[roof]", "thermometers=9", "latitude_deg=100"],
        *["chamber.lag_s=-1", "chamber.overshoot=2", "chamber=nosuch", "cold_start=maybe", "amplitude=-1", "reference_dph=fast"],
    ],
)
def test_wrong_input_is_two_lines_that_name_the_key_and_code_2(tmp_path: Path, capsys: pytest.CaptureFixture[str], override: str) -> None:
    code = fogzoo("simulate", ["profile=legs", override, f"hydra.run.dir={tmp_path}"])
    message = capsys.readouterr().err
    assert code == 2, message
    assert 1 <= len(message.strip().splitlines()) <= 2
    assert "Traceback" not in message
    key, _, value = override.lstrip("+").partition("=")
    assert key.rpartition(".")[2] in message or value.strip("[]") in message.replace(" ", "")
    assert not list(tmp_path.rglob("*.csv"))
