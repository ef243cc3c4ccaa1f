"""What to type after a verb, with the settings as they were typed for it."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

from hydra.core.hydra_config import HydraConfig

from zoo.cli.searchpath import searchpath
from zoo.report.unknown_stub import stub_of


def typed_settings() -> list[str]:
    """The settings as they were typed, whichever they are, without what to add; the user's own config folders come last."""
    typed = [one for one in HydraConfig.get().overrides.task if not one.startswith("add=")]
    folders = ",".join(f"file://{folder}" for folder in searchpath())
    return [*typed, *([f"hydra.searchpath=[{folders}]"] if folders else [])]


def refine_words() -> list[str]:
    """The command that refines what was diagnosed, but for what to add."""
    return ["fogzoo", "refine", *typed_settings()]


def next_commands(missing: list[str]) -> list[str]:
    """What to type after a diagnosis to add the missing effects; nothing where none is missing."""
    return [shlex.join(["fogzoo", "refine", f"add=[{','.join(missing)}]", *typed_settings()])] if missing else []


def stub_commands(diagnosis: dict[str, Any], out: Path) -> list[str]:
    """What to type to refit with the class that was written for what nothing explains; nothing where it is only an example.

    Args:
        diagnosis: the record.
        out: the folder that the class was written to.
    """
    form = diagnosis.get("unexplained_form")
    stub = stub_of(diagnosis) if form and not form["todo"] else None
    return [] if stub is None else stub.commands(out, refine_words())


def compare_command(folder: Path) -> str:
    """What to type to see a refined model by stage: on the check runs where there are any, read as they were."""
    typed = {one.partition("=")[0]: one.partition("=")[2] for one in HydraConfig.get().overrides.task if one.lstrip("+").startswith("data")}
    files = typed.pop("data.check_files", None) or typed.get("data.files")
    kept = {key: value for key, value in typed.items() if key not in {"data.files", "data.holdout"}}
    return shlex.join(["fogzoo", "compare", f"runs=[{folder}]", *([f"data.files={files}"] if files else []), *(f"{key}={kept[key]}" for key in kept)])
