"""A model that takes what the gyro shows, from training to use."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest
import torch

from zoo.cli import run

SCALE, OFFSET = 0.9, 2.0  # the gyro shows 0.9 × the true rate + 2 °/h


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a rate table with half of its rows at rest, and of a line over the output, fitted to the others."""
    folder = tmp_path_factory.mktemp("table")
    reference = [0.0 if k % 2 else 100.0 * k for k in range(40)]
    table = {"time_s": [600.0 * k for k in range(40)], "temperature_c": [20.0 + k / 40 for k in range(40)], "reference_dph": reference}
    shown = [SCALE * one + OFFSET if one else 77.0 for one in reference]
    pd.DataFrame({**table, "rate_dph": shown}).to_csv(folder / "run.csv", index=False)
    points = ["data.average_s=null", 'data.points.where="reference_dph != 0"', "data.points.checked=5"]
    model = ["model=polynomial", "model.features=[output]"]
    assert run("train", [*model, *points, f"data.files=[{folder}/run.csv]", f"hydra.run.dir={folder}/model"]) == 0
    return folder


def test_only_the_points_asked_for_are_fitted(trained: Path) -> None:
    metrics = json.loads((trained / "model" / "metrics.json").read_text())
    assert metrics["rms"] < 1e-9 * metrics["runs"][0]["uncompensated"]
    assert metrics["rms_check"] < 1e-9 * metrics["runs"][0]["uncompensated"]


def test_a_file_in_another_unit_is_compensated_by_its_own_output(trained: Path) -> None:
    shown = [SCALE * one + OFFSET for one in (-3000.0, 50.0, 1234.5, 4000.0)]
    flight = {"time_s": [0.0, 1.0, 2.0, 3.0], "temperature_c": [20.0, 20.1, 20.2, 20.3], "rate_dps": [one / 3600 for one in shown]}
    pd.DataFrame(flight).to_csv(trained / "flight.csv", index=False)
    assert run("compensate", [f"run={trained}/model", f"data.files=[{trained}/flight.csv]", f"hydra.run.dir={trained}/flight"]) == 0
    done = pd.read_csv(trained / "flight" / "flight.csv")
    assert (3600 * done.rate_dps_compensated).tolist() == pytest.approx([-3000.0, 50.0, 1234.5, 4000.0], rel=1e-6)


def test_the_exported_model_takes_the_output_beside_the_columns(trained: Path) -> None:
    assert run("export", [f"run={trained}/model", f"hydra.run.dir={trained}/export"]) == 0
    told = json.loads((trained / "export" / "metadata.json").read_text())
    assert told["inputs"] == ["time_s", "output"]
    assert told["input_units"]["output"] == "°/h"
    model = torch.jit.load(str(trained / "export" / "model.ts"))
    shown = SCALE * 1500.0 + OFFSET
    assert float(model(torch.tensor([[0.0, shown]], dtype=torch.float64))) == pytest.approx(shown - 1500.0)
