"""A paper's methods trained by its protocol, and what is written of them."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
import torch

from zoo.cli import run


@pytest.mark.slow
def test_every_method_is_fitted_to_the_papers_data_and_to_all_others(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run("reproduce", ["paper=hui2016", "seeds=2", "others.count=1", f"data.folder={tmp_path / 'data'}", f"hydra.run.dir={out}"]) == 0
    table = pd.read_csv(out / "table.csv")
    assert list(table.columns[:6]) == ["quantity", "stage", "sample", "model", "paper", "ours"]
    methods = ["uncompensated", "line", "wavelet network", "wavelet network by L-BFGS", "wavelet network by LM", "BP by LM", "LS-SVM"]
    assert list(table[table.quantity == "variance"].model.unique()) == methods
    assert list(table[table["sample"] == "alignment"].model.unique()) == [*methods, "known point by point"]
    # The line's figures in the fit are those that the accelerometer was made to have (0.138 pulses²).
    line = table[(table.model == "line") & (table.quantity == "variance") & (table["sample"] == "fitted")]
    assert line.ours.item() == pytest.approx(line.paper.item(), rel=0.1)
    assert "units" in (out / "table.md").read_text()
    assert len(list((out / "methods").iterdir())) == len(methods) - 1
    assert len(list((out / "figures").glob("*.png"))) == 8


MODEL = """
from zoo.models.polynomial import Polynomial


class Mine(Polynomial):
    fitted_by = "mine"
"""
EXPERIMENT = """# @package _global_
defaults: [hui2016]
methods:
  line: [model=mine, optimizer=auto]
  wavelet network: [model=mine, optimizer=auto]
  wavelet network by L-BFGS: [model=mine, optimizer=auto]
  wavelet network by LM: [model=mine, optimizer=auto]
  BP by LM: [model=mine, optimizer=auto]
  LS-SVM: [model=mine, optimizer=auto]
"""


def test_the_users_own_configs_are_found_in_processes_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my_model.py").write_text(MODEL)
    for name, text in {
        "model/mine": "_target_: my_model.Mine\nfeatures: [temperature]\n",
        "optimizer/mine": "_target_: zoo.training.least_squares.LeastSquares\n",
        "experiment/mine": EXPERIMENT,
    }.items():
        path = tmp_path / "conf" / f"{name}.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    arguments = ["seeds=1", "others.count=1", f"data.folder={tmp_path / 'data'}", f"hydra.searchpath=[file://{tmp_path / 'conf'}]"]
    tables, before = [], torch.get_num_threads()
    for jobs in (1, 2):
        out = tmp_path / f"out_{jobs}"
        torch.set_num_threads(jobs)
        try:
            assert run("reproduce", ["paper=mine", *arguments, f"hydra.run.dir={out}"]) == 0
        finally:
            torch.set_num_threads(before)
        tables.append(pd.read_csv(out / "table.csv"))
    pd.testing.assert_frame_equal(*tables)
