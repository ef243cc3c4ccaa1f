"""Runs in which the bias jumps, each at moments of its own: diagnosed, refined, kept, diagnosed again and exported."""

import json
from pathlib import Path

import pandas as pd
import pytest

from zoo.catalog import load_model
from zoo.cli.application import run
from zoo.effects.bias_step import BiasStep

JUMPS = {"run_1": ((1.5, 0.25), (3.0, -0.2)), "run_2": ((2.5, 0.3),)}
"""Hour and height [°/h]."""
FEW = "candidates=[bias_step,aging,hysteresis]"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> Path:
    """Runs with jumps, and one to check on without."""
    folder = tmp_path_factory.mktemp("jumps")
    assert run("simulate", ["runs=2", "sample_s=20", "thermometers=1", "seed=5", "pictures=false", f"hydra.run.dir={folder}"]) == 0
    for name, jumps in JUMPS.items():
        table = pd.read_csv(folder / f"{name}.csv")
        for hour, height in jumps:
            table.loc[table["time_s"] > 3600 * hour, "rate_dph"] += height
        table.to_csv(folder / f"{name}.csv", index=False)
    return folder


def test_jumps_are_named_once_listed_each_and_kept(recorded, tmp_path, capsys) -> None:
    data = f"data.files=[{recorded}/run_*.csv]"
    assert run("refine", ["add=auto", FEW, data, f"data.check_files=[{recorded}/check.csv]", f"hydra.run.dir={tmp_path / 'refined'}"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("bias_step: onset") == 3
    assert "complete with bias_step added" in printed
    assert "bias_step_" not in printed
    ladder = json.loads((tmp_path / "refined" / "refinement.json").read_text())["ladder"]
    assert [rung["added"] for rung in ladder] == [None, "bias_step"]
    kept = dict(load_model(tmp_path / "refined").named_effects())
    assert sum(isinstance(effect, BiasStep) for effect in kept.values()) == 3
    assert run("diagnose", [FEW, data, f"model.folder={tmp_path / 'refined'}", f"hydra.run.dir={tmp_path / 'again'}"]) == 0
    assert json.loads((tmp_path / "again" / "diagnosis.json").read_text())["missing"] == []
    assert run("export", [f"run={tmp_path / 'refined'}", f"hydra.run.dir={tmp_path / 'exported'}"]) == 0
    assert (tmp_path / "exported" / "model.ts").is_file()


def test_the_verdict_says_how_often_and_the_command_adds_all(recorded, tmp_path, capsys) -> None:
    assert run("diagnose", [FEW, f"data.files=[{recorded}/run_*.csv]", f"hydra.run.dir={tmp_path}"]) == 0
    printed = capsys.readouterr().out
    assert "Missing: bias_step, 3 times" in printed
    assert "fogzoo refine 'add=[bias_step]'" in printed
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "bias_step, 3 times" in page
