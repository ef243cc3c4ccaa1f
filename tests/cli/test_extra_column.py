"""A recorded column that the house knows nothing of, for an effect of the user's own."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from zoo.cli.application import run

EFFECT = """
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter, spread


class Airflow(Effect):
    name = "airflow"
    place = "housing"
    amplitudes = (Parameter("coefficient", 0.0, "unit/(m/s)", -10.0, 10.0),)
    needs = ("airflow_m_per_s",)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        return spread(history.inputs["airflow_m_per_s"].unsqueeze(-1), shape)
"""


@pytest.fixture
def fit(tmp_path, monkeypatch) -> list[str]:
    """Settings of a diagnosis of a gyro that feels the air move."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "air_effects", raising=False)
    (tmp_path / "conf" / "effects").mkdir(parents=True)
    (tmp_path / "air_effects.py").write_text(EFFECT)
    (tmp_path / "conf" / "effects" / "airflow.yaml").write_text("airflow:\n  _target_: air_effects.Airflow\n")
    time = np.arange(10, 5 * 3600, 20.0)
    temperature = 20 + 30 * (np.clip(time / 3600 - 1, 0, 1) - np.clip(time / 3600 - 3, 0, 1))
    air = 1 + np.sign(np.sin(time / 500))
    rate = 0.01 * temperature + 0.05 * air + 0.01 * np.random.default_rng(1).normal(size=len(time))
    np.savetxt("a.csv", np.column_stack([time, temperature, rate, air]), "%.6f", ",", header="time_s,temperature_c,rate_dph,air m/s", comments="")
    searchpath = f"hydra.searchpath=[file://{tmp_path}/conf]"
    return ["data.files=[a.csv]", "data.average_s=100", "effects=[static_bias]", "candidates=[airflow]", "hydra.run.dir=out", searchpath]


def test_it_is_found(fit) -> None:
    assert run("diagnose", [*fit, '+data.columns.airflow_m_per_s="air m/s"']) == 0
    assert json.loads(Path("out/diagnosis.json").read_text())["missing"] == ["airflow"]


def test_without_it_the_effect_is_left_out(fit) -> None:
    assert run("diagnose", fit) == 0
    assert json.loads(Path("out/diagnosis.json").read_text())["not_tried"] == {"airflow": ["airflow_m_per_s"]}
