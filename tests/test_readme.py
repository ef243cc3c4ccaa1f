"""What the README shows in Python runs as it stands."""

from __future__ import annotations

import gzip
import re
from pathlib import Path
from typing import Any

import torch

from zoo.catalog import build
from zoo.export.torchscript import to_torchscript
from zoo.models.example import example

ROOT = Path(__file__).resolve().parents[1]
FIRMWARE = "torch.jit.load"
"""Names the part that stands alone, without this package."""


def shown() -> list[str]:
    return re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)


def test_the_python_that_the_readme_shows(tmp_path, monkeypatch, capsys) -> None:
    for copy in (ROOT / "tests" / "golden").glob("mystery_b_*.csv.gz"):
        name = copy.name.removeprefix("mystery_b_").removesuffix(".gz")
        (tmp_path / name).write_bytes(gzip.decompress(copy.read_bytes()))
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec("".join(part for part in shown() if FIRMWARE not in part), names)
    *gyros, verdict = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in gyros] == ["1", "2", "3"]
    assert verdict == "missing ['hysteresis']"
    assert float(names["left"].square().mean().sqrt()) < 1.2 * names["found"].record["noise_floor"]


def test_the_exported_model_that_the_readme_shows(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    model, ranges = build("model", "bp"), {"temperature_c": (-30.0, 55.0)}
    made_up = example(model.inputs, ranges)
    (tmp_path / "model.ts").write_bytes(to_torchscript(model, "dph", made_up, ranges))
    names: dict[str, Any] = {"rows": [*made_up[:50].tolist(), [1e9, 90.0]]}
    exec(next(part for part in shown() if FIRMWARE in part), names)
    assert capsys.readouterr().out == "['time_s', 'temperature_c'] dph\n"
    assert names["inside"].tolist() == [True, False]
    whole = names["model"].forward(torch.tensor(names["rows"], dtype=torch.float64))
    assert float((whole[-1] - names["error"]).abs()) < 1e-12
