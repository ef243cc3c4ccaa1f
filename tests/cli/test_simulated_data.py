"""Data that a config asks the simulator for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import hydra
import pandas as pd
import pytest
from hydra.core.hydra_config import HydraConfig

from zoo.catalog import config_folder
from zoo.cli import run
from zoo.cli.inputs import read_data

SHORT = ["data=simulated", "data.simulated.runs=1", "+data.simulated.profile=sine", "+data.simulated.sample_s=60", "data.files=[run_1.parquet]"]


def train(tmp_path: Path, *more: str) -> dict[str, Any]:
    out = tmp_path / "out"
    assert run("train", [*SHORT, "model=polynomial", f'data.folder="{tmp_path}/data"', f'hydra.run.dir="{out}"', *more]) == 0
    found: dict[str, Any] = json.loads((out / "metrics.json").read_text())
    return found


def test_a_recording_is_made_once_and_another_seed_is_another(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also in a folder whose name is a pattern of files, and one of colours."""
    tmp_path = tmp_path / "[red] * [/red]"
    first = train(tmp_path)
    assert f"once, into {tmp_path}" in capsys.readouterr().err
    again = train(tmp_path)
    assert "once, into" not in capsys.readouterr().err
    assert again["rms"] == first["rms"]
    other = train(tmp_path, "data.simulated.seed=2")
    assert other["rms"] != first["rms"]
    assert len(list((tmp_path / "data").iterdir())) == 2


def test_beside_each_run_lies_what_a_gyro_without_noise_would_have_recorded(tmp_path: Path) -> None:
    train(tmp_path)
    (place,) = (tmp_path / "data").iterdir()
    noisy, quiet = (pd.read_parquet(place / f"{name}run_1.parquet") for name in ("", "noiseless_"))
    assert quiet.drop(columns="rate_dph").equals(noisy.drop(columns="rate_dph"))
    noise = noisy.rate_dph - quiet.rate_dph
    assert quiet.rate_dph.diff().diff().std() < 0.05 * noise.diff().diff().std()
    assert noise.mean() == pytest.approx(0.0, abs=4 * noise.std() / len(noise) ** 0.5)


def test_a_wrong_setting_of_the_simulation_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("train", [*SHORT, f"data.folder={tmp_path}", "+data.simulated.colour=red", f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    assert "colour" in capsys.readouterr().err
    assert not list(tmp_path.glob("medium*"))


def test_a_file_that_is_none_of_the_simulated_ones_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    train(tmp_path)
    for key in ("data.files", "data.check_files"):
        capsys.readouterr()
        assert run("train", [*SHORT, f"data.folder={tmp_path / 'data'}", f"{key}=[mine.csv]", f"hydra.run.dir={tmp_path / 'no'}"]) == 2
        assert f"{key}: mine.csv: is none of the simulated runs" in capsys.readouterr().err
    assert train(tmp_path, "data.files=run_1.parquet")["rms"] == train(tmp_path, "data.files=[run_*.parquet]")["rms"]


def test_the_users_own_gyro_is_simulated_and_anew_once_it_is_changed(tmp_path: Path) -> None:
    path = tmp_path / "conf" / "gyro" / "mine.yaml"
    path.parent.mkdir(parents=True)
    found = []
    for walk in (0.001, 0.1):
        path.write_text(f"defaults: [medium]\nrandom_walk: {walk}\n")
        found.append(train(tmp_path, "data.simulated.gyro=mine", f"hydra.searchpath=[file://{tmp_path / 'conf'}]")["rms"])
    assert found[1] > 2 * found[0]
    assert len(list((tmp_path / "data").glob("mine-*"))) == 2


def test_a_config_composed_in_a_program_of_ones_own_is_simulated_as_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(HydraConfig.instance(), "cfg", None)
    with hydra.initialize_config_dir(str(config_folder()), version_base=None):
        runs, checks = read_data(hydra.compose("train", [*SHORT, f"data.folder={tmp_path}"]))
    assert [one.name for one in (*runs, *checks)] == ["run_1", "check"]
