"""Trained models found by the folders that train and refine left, each with a name of its own."""

from __future__ import annotations

import glob
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import yaml  # type: ignore[import-untyped]

from zoo.catalog import MODEL_FILE, RANGES_FILE, load_model, save_model
from zoo.errors import InputError
from zoo.export.files import FORMATS, METADATA, SCRIPT
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.ranges import fitted_ranges
from zoo.training.files import CHECKPOINT, MEMBERS, PICTURE

MAKERS = ("train", "refine")
"""Verbs that leave models."""
RESULTS = ("metrics.json", "refinement.json")


@dataclass(frozen=True, eq=False)
class SavedModel:
    """One trained model.

    Attributes:
        kind: its type.
        folder: where it was found.
        module: the model, in evaluation mode.
        facts: what the result file beside it says, such as ``seed`` and ``unit``; empty where there is none.
    """

    kind: str
    folder: Path
    module: Model
    facts: dict[str, Any]


def keep_model(folder: Path, config: dict[str, Any], module: Model, runs: Sequence[Run], own: Sequence[str] = ()) -> None:
    """Save a model in place of whatever an earlier command has left of another one in its folder.

    Args:
        folder: an existing folder.
        config: as `create` takes it.
        module: the fitted model.
        runs: that it was fitted to.
        own: names of files there that are this model's already.
    """
    for name in (*RESULTS, *FORMATS, METADATA, RANGES_FILE, MEMBERS, CHECKPOINT, PICTURE):
        if name not in own:
            (folder / name).unlink(missing_ok=True)
    save_model(folder, config, module, fitted_ranges(module, runs))


def command_config(folder: Path) -> Path | None:
    """The settings of the command that left the model in a folder; None where they are not kept, or a later command's lie there instead."""
    kept = folder / ".hydra" / "config.yaml"
    return kept if kept.is_file() and was_made(folder) else None


def was_made(folder: Path) -> bool:
    """Whether the last command in a folder was one that leaves models."""
    return _of_hydra(folder, "job").get("name") in MAKERS


def given_in(folder: Path) -> Path:
    """The folder in which the last command in a folder was given, from which its paths count; this one where that is not known."""
    return Path(_of_hydra(folder, "runtime").get("cwd") or ".")


def _of_hydra(folder: Path, part: str) -> dict[str, Any]:
    """What Hydra has written down of the last command in a folder."""
    kept = folder / ".hydra" / "hydra.yaml"
    hydra = (read_yaml(kept) or {}).get("hydra") or {} if kept.is_file() else {}
    return hydra.get(part) or {}


def read_yaml(path: Path) -> Any:
    """What a YAML says; sweeps have thousands of them, so quickly."""
    return yaml.load(path.read_text(encoding="utf-8"), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def find_model(key: str, given: str) -> SavedModel:
    """Load the one model of an output folder.

    Args:
        key: of the setting, for the message.
        given: the folder, or a file in it.

    Raises:
        InputError: it leads to no model, or to several.
    """
    folders = model_folders(given, key, (MODEL_FILE,))
    if len(folders) > 1:
        raise InputError(f"{key}={given}: {len(folders)} models in and below it; one is needed, such as {folders[0]}")
    return load_saved(folders[0])


def folder_settings(arguments: list[str]) -> list[str]:
    """Command-line arguments with `model=FOLDER` as `model.folder=FOLDER`: by itself, Hydra takes `model` for a choice from conf/model/."""
    return [f"model.folder={one.removeprefix('model=')}" if one.startswith("model=") else one for one in arguments]


def model_folders(pattern: str, key: str, files: tuple[str, ...]) -> list[Path]:
    """The folders that a setting leads to.

    Args:
        pattern: a folder, a glob, a folder of a multirun (all models below it), or a file in such a folder.
        key: of the setting, for the message.
        files: a folder with one of these holds a model.

    Raises:
        InputError: there is none.
    """
    found = [folder for top in tops(pattern) for folder in _below(top, files)]
    if not found and SCRIPT not in files and any((top / SCRIPT).is_file() for top in tops(pattern)):
        raise InputError(f"{key}={pattern}: is exported already; give the output folder of the train or refine command that it was exported from")
    if not found:
        raise InputError(f"{key}: {pattern}: no {' or '.join(files)} in or below it; give the output folder of a train or refine command")
    return found


def tops(pattern: str) -> list[Path]:
    """The folders that a pattern names, or that hold the files that it names."""
    asked = Path(pattern).expanduser()
    named = [] if asked.exists() else glob.glob(str(asked), recursive=True)  # noqa: PTH207 (Path.glob takes no absolute pattern)
    matches = sorted(map(Path, named), key=_natural) or [asked]
    return list(dict.fromkeys(path.parent if path.is_file() else path for path in matches))


def _below(top: Path, files: tuple[str, ...]) -> list[Path]:
    if any((top / file).is_file() for file in files):
        return [top]
    return sorted({found.parent for file in files for found in top.rglob(file)}, key=_natural)


def _natural(path: Path) -> list[tuple[int, str]]:
    """Sorts job 2 of a multirun before job 10."""
    return [(int(part or 0), text) for part, text in re.findall(r"(\d*)(\D*)", str(path))]


def load_saved(folder: Path) -> SavedModel:
    """The model in a folder, and what the result file beside it says.

    Raises:
        InputError: there is none, or one of its files is damaged.
    """
    facts: dict[str, Any] = {}
    for path in [folder / name for name in RESULTS if (folder / name).is_file()]:
        try:
            facts |= json.loads(path.read_text(encoding="utf-8"))
        except (ValueError, TypeError) as error:
            raise InputError(f"{path}: damaged ({error}); run the command that wrote it again") from error
    module = cast(Model, load_model(folder))
    kind = str(facts.get("model") or type(module).__name__.lower())
    return SavedModel(kind, folder, module, facts)


def physical_values(facts: dict[str, Any]) -> dict[str, Any] | None:
    """Fitted values of physical effects, by effect; None where there are none. Under ``parameters`` `refine` has them, and `train` a count."""
    found = facts.get("physical") or facts.get("parameters")
    return found if isinstance(found, dict) else None
