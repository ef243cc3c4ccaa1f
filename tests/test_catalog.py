"""A name becomes an object, with what its YAML includes."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from zoo.catalog import build, load, load_members, load_model, names, save_model
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
    assert names(group)
    for name in names(group):
        assert build(group, name) is not None


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    save_model(
        tmp_path, {"_target_": "zoo.models.bp.BP", "features": ["temperature"], "hidden": 2}, build("model", "bp", features=["temperature"], hidden=2)
    )
    return tmp_path


@pytest.mark.parametrize("target", ["builtins.print", "os.getcwd", "zoo.errors.InputError"])
@pytest.mark.parametrize("nested", [False, True])
def test_a_saved_model_from_elsewhere_calls_nothing_but_modules(saved: Path, capsys: pytest.CaptureFixture[str], target: str, nested: bool) -> None:
    inner = f"_target_: {target}\n"
    (saved / "model.yaml").write_text(f"_target_: zoo.models.graybox.GrayBox\neffects:\n  mine:\n    {inner}" if nested else inner, encoding="utf-8")
    with pytest.raises(InputError, match=f"model.yaml: {target} is no model and no effect"):
        load_model(saved)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("damage", ["empty", "half", "other", "tensor", "text"])
def test_damaged_weights_are_told_with_the_file(saved: Path, damage: str) -> None:
    path = saved / "weights.pt"
    if damage == "other":
        torch.save({"weight": torch.zeros(3)}, path)
    elif damage == "tensor":
        torch.save(torch.zeros(3), path)
    else:
        path.write_bytes({"empty": b"", "half": path.read_bytes()[:300], "text": b"no weights at all"}[damage])
    with pytest.raises(InputError, match=r"weights\.pt: damaged, or of another model"):
        load_model(saved)


def test_weights_with_more_than_numbers_are_refused_for_that(saved: Path) -> None:
    torch.save({"weight": Path("/")}, saved / "weights.pt")
    with pytest.raises(InputError, match=r"weights\.pt: .* more than numbers is in it, which could be a program and is not loaded; train it again$"):
        load_model(saved)


@pytest.mark.parametrize("text", [b"\xff\xfe", b"_target_: [", b"_target_: ${nowhere}", b"- a list"])
def test_a_damaged_config_is_told_with_the_file(saved: Path, text: bytes) -> None:
    (saved / "model.yaml").write_bytes(text)
    with pytest.raises(InputError, match=r"model\.yaml: "):
        load_model(saved)


@pytest.mark.parametrize("kept", [torch.zeros(3), {"seeds": [1]}, {"seeds": [1], "states": [{"weight": torch.zeros(3)}]}])
def test_damaged_members_are_told_with_the_file(saved: Path, kept: object) -> None:
    torch.save(kept, saved / "members.pt")
    with pytest.raises(InputError, match=r"members\.pt: (damaged|of another model)"):
        load_members(saved)
