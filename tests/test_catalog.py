"""A name becomes an object, with what its YAML includes."""

from __future__ import annotations

from pathlib import Path

import pytest

from zoo.catalog import build, load, names
from zoo.errors import InputError


def written(folder: Path, name: str, text: str) -> list[Path]:
    (folder / "gyro").mkdir(exist_ok=True)
    (folder / "gyro" / f"{name}.yaml").write_text(text, encoding="utf-8")
    return [folder]


def test_what_a_yaml_includes_is_there_and_its_own_settings_go_before(tmp_path: Path) -> None:
    text = "defaults:\n  - medium\n  - _self_\ngap: 12\n"
    config = load("gyro", "mine", written(tmp_path, "mine", text))
    assert (config.name, config.gap, config.layers) == ("medium", 12, None)
    assert build("gyro", "mine", [tmp_path]).gap.low == 12


def test_a_yaml_that_chooses_from_other_groups_is_what_stands_below_its_own() -> None:
    config = load("gyro", "qiu2023")
    assert config.name == "qiu2023"
    assert "defaults" not in config
    assert "layers" in config


def test_what_is_included_and_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown gyro 'medum': did you mean medium"):
        load("gyro", "mine", written(tmp_path, "mine", "defaults:\n  - medum\n  - _self_\n"))


@pytest.mark.parametrize("group", ["gyro", "profile", "chamber", "noise"])
def test_every_name_builds(group: str) -> None:
    for name in names(group):
        assert build(group, name) is not None
