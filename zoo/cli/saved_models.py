"""Trained models found by the folders that train and refine left, each with a name of its own."""

from __future__ import annotations

import glob
import json
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

from zoo.catalog import MODEL_FILE, load_model
from zoo.errors import InputError
from zoo.models.base import Model
from zoo.scoring.comparison import UNCOMPENSATED

RESULTS = ("metrics.json", "refinement.json")
TAKEN = ("run", "stage", "blocks", UNCOMPENSATED)
"""Columns of the table that no model may be called like."""


@dataclass(frozen=True, eq=False)
class SavedModel:
    """One trained model.

    Attributes:
        name: its type, with what tells it from others of its type.
        folder: where it was found.
        module: the model, in evaluation mode.
        facts: what the result file beside it says, such as ``seed`` and ``unit``; empty where there is none.
    """

    name: str
    folder: Path
    module: Model
    facts: dict[str, Any]


def find_models(given: list[str]) -> list[SavedModel]:
    """Load the models of output folders.

    Args:
        given: folders, globs, folders of multiruns (all models below them), or files in such folders.

    Raises:
        InputError: one of them leads to no model.
    """
    folders = list(dict.fromkeys(folder for pattern in given for folder in _folders(pattern)))
    if not folders:
        raise InputError("runs=[]: give at least one output folder of a train or refine command")
    return _named([_load(folder) for folder in folders])


def _folders(pattern: str) -> list[Path]:
    matches = sorted((Path(path) for path in glob.glob(pattern, recursive=True)), key=_natural)  # noqa: PTH207 (Path.glob takes no absolute pattern)
    found = [folder for path in matches or [Path(pattern)] for folder in _below(path.parent if path.is_file() else path)]
    if not found:
        raise InputError(f"runs: {pattern}: no {MODEL_FILE} in or below it; give the output folder of a train or refine command")
    return found


def _below(top: Path) -> list[Path]:
    if (top / MODEL_FILE).is_file():
        return [top]
    return [file.parent for file in sorted(top.rglob(MODEL_FILE), key=_natural)]


def _natural(path: Path) -> list[tuple[int, str]]:
    """Sorts job 2 of a multirun before job 10."""
    return [(int(part or 0), text) for part, text in re.findall(r"(\d*)(\D*)", str(path))]


def _load(folder: Path) -> SavedModel:
    facts: dict[str, Any] = {}
    for name in RESULTS:
        if (folder / name).is_file():
            facts |= json.loads((folder / name).read_text(encoding="utf-8"))
    module = cast(Model, load_model(folder))
    return SavedModel(str(facts.get("model") or type(module).__name__.lower()), folder, module, facts)


def _named(models: list[SavedModel]) -> list[SavedModel]:
    """Adds to a name what differs between its bearers: init, optimizer, seed, and at last a number."""
    for key in ("init", "optimizer", "seed"):
        bearers: dict[str, set[Any]] = {}
        for model in models:
            bearers.setdefault(model.name, set()).add(model.facts.get(key))
        prefix = key if key == "seed" else ""
        models = [replace(m, name=f"{m.name}_{prefix}{m.facts.get(key)}") if len(bearers[m.name]) > 1 else m for m in models]
    seen: dict[str, int] = dict.fromkeys(TAKEN, 1)
    for index, model in enumerate(models):
        seen[model.name] = seen.get(model.name, 0) + 1
        if seen[model.name] > 1:
            models[index] = replace(model, name=f"{model.name}_{seen[model.name]}")
    return models
