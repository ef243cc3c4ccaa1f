"""A paper's methods trained by its protocol, and what is written of them."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from zoo.cli import run


@pytest.mark.slow
def test_every_method_is_fitted_to_the_papers_data_and_to_all_others(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run("reproduce", ["paper=hui2016", "seeds=2", "others.count=1", f"data.folder={tmp_path / 'data'}", f"hydra.run.dir={out}"]) == 0
    table = pd.read_csv(out / "table.csv")
    assert list(table.columns[:7]) == ["quantity", "unit", "stage", "sample", "model", "paper", "ours"]
    methods = ["uncompensated", "line", "wavelet network", "wavelet network by L-BFGS", "wavelet network by LM", "BP by LM", "LS-SVM"]
    assert list(table[table.quantity == "variance"].model.unique()) == methods
    assert list(table[table["sample"] == "alignment"].model.unique()) == [*methods, "known point by point"]
    # The line's figures in the fit are those that the accelerometer was made to have (0.138 pulses²).
    line = table[(table.model == "line") & (table.quantity == "variance") & (table["sample"] == "fitted")]
    assert line.ours.item() == pytest.approx(line.paper.item(), rel=0.1)
    assert "units" in (out / "table.md").read_text()
    assert len(list((out / "methods").iterdir())) == len(methods) - 1
    assert len(list((out / "figures").glob("*.png"))) == 8
