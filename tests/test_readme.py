"""What the README shows in Python runs as it stands."""

from __future__ import annotations

import gzip
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]


def test_the_python_that_the_readme_shows(tmp_path, monkeypatch, capsys) -> None:
    for copy in (ROOT / "tests" / "golden").glob("mystery_b_*.csv.gz"):
        name = copy.name.removeprefix("mystery_b_").removesuffix(".gz")
        (tmp_path / name).write_bytes(gzip.decompress(copy.read_bytes()))
    monkeypatch.chdir(tmp_path)
    shown = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    names: dict[str, Any] = {}
    exec("".join(shown), names)
    *gyros, verdict = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in gyros] == ["1", "2", "3"]
    assert verdict == "missing ['hysteresis']"
    assert float(names["left"].square().mean().sqrt()) < 1.2 * names["found"].record["noise_floor"]
