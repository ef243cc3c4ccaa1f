"""What `compare` sets side by side: saved models, exported files, and predictions made elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, cast

import torch
from rich.console import Console
from rich.progress import track
from torch import Tensor

from zoo.catalog import MODEL_FILE, load_members, load_ranges, names
from zoo.cli.given_predictions import files_of
from zoo.cli.outcomes import FAILED
from zoo.cli.saved_models import RESULTS, command_config, load_saved, model_folders, read_yaml, tops, was_made
from zoo.cli.telling_settings import telling_words
from zoo.comparison.entrant import Entrant
from zoo.comparison.naming import distinct_names
from zoo.errors import InputError, causes, in_brief
from zoo.export.exported import load_exported
from zoo.export.files import SCRIPT
from zoo.export.narrowed import narrowed
from zoo.measurements.predictions import read_prediction
from zoo.measurements.run import OUTPUT, Run
from zoo.models.base import Model
from zoo.models.prediction import predict_blocks
from zoo.models.ranges import Ranges
from zoo.models.reach import Reach
from zoo.training.files import MEMBERS

NO_SETTINGS = ("seed", "seeds", "torch_device", "resume", "hydra", "data.check_files", "objective")
"""What a config says that makes no other method."""


def find_entrants(runs: Sequence[str]) -> tuple[list[Entrant], list[str]]:
    """Load the models of output folders; of an ensemble, each member.

    Args:
        runs: folders, globs, folders of multiruns (all models below them), or files in such folders.

    Returns:
        The models, and the folders of jobs that left none, as they are called below what was given.

    Raises:
        InputError: something given leads to no model.
    """
    files = (MODEL_FILE, SCRIPT)
    given = ((folder, pattern.endswith(SCRIPT)) for pattern in runs for folder in model_folders(pattern, "runs", files))
    folders = list(dict.fromkeys((folder, scripted or not (folder / MODEL_FILE).is_file()) for folder, scripted in given))
    skipped = [str(folder) for pattern in runs for top in tops(pattern) for folder in _without_model(top, files)]
    found: list[Entrant] = []
    watched = Console(stderr=True)
    for folder, scripted in track(folders, "loading", console=watched, transient=True, disable=not watched.is_terminal or len(folders) < 8):
        unfinished = not scripted and (folder / MODEL_FILE).is_file() and _without_result(folder) and was_made(folder)
        try:
            found += [] if unfinished else _loaded(folder, scripted)
        except Exception as error:  # whatever a half-written file makes of torch and yaml: the other jobs of a sweep count all the same
            if len(folders) == 1 or any(isinstance(cause, ImportError) for cause in causes(error)):
                raise InputError(f"runs: {folder}: cannot be loaded: {in_brief(error)}") from error
            unfinished = True
        skipped += [str(folder)] if unfinished else []
    if folders and not found:
        raise InputError(f"runs: {', '.join(skipped)}: no finished model there")
    return list({_training(one): one for one in reversed(found)}.values())[::-1], list(dict.fromkeys(skipped))


def _training(one: Entrant) -> tuple[Any, ...]:
    """What tells trainings of a sweep apart.

    Those of different starts that their fit had no use for are one, and so is a seed that several ensembles have.
    """
    if one.scripted or not one.settings or "seed" not in one.facts:
        return (id(one),)
    rms = f"{one.facts['rms']:.4g}" if one.facts.get("rms") is not None else None  # ensembles of other sizes round otherwise
    return one.folder.parent, one.kind, rms, *(one.facts.get(key) for key in ("init", "optimizer", "seed")), *sorted(one.settings.items())


def _loaded(folder: Path, scripted: bool) -> list[Entrant]:
    if scripted:
        module, metadata = load_exported(folder)
        kind, facts = f"{metadata.get('model') or 'exported'}_exported", _facts(metadata)
        settings, ranges = dict(_flat(metadata.get("settings") or {})), module.ranges
        return [Entrant(kind, kind, folder, facts, settings, _predictor(module, folder, ranges), True, _extrapolation(module, ranges))]
    saved = load_saved(folder)
    idle = NO_SETTINGS if saved.facts.get("init") else (*NO_SETTINGS, "init")  # a fit by itself has no use for a start
    settings, ranges = _settings(folder, saved.facts, but=idle), load_ranges(folder)
    predict, beyond = _predictor(saved.module, folder, ranges), _extrapolation(saved.module, ranges)
    one = Entrant(saved.kind, saved.kind, folder, saved.facts, settings, predict, beyond=beyond)
    if not (folder / MEMBERS).is_file():
        return [one]
    members = ((seed, cast(Model, module)) for seed, module in load_members(folder))
    told = saved.facts.get("members") or {}
    rms = dict(zip(told.get("seeds") or [], told.get("rms") or [], strict=False))
    own = ((saved.facts | {"seed": seed, "rms": rms.get(seed)}, module) for seed, module in members)
    return [replace(one, facts=facts, predict=_predictor(module, folder, ranges)) for facts, module in own]


def _facts(metadata: dict[str, Any]) -> dict[str, Any]:
    """What an exported file's metadata tell, as a training's metrics would."""
    trained = metadata.get("trained_on") or {}
    kept = ("init", "optimizer", "seed", "average_s", "noise", "noise_floor_by_run", "verdict")
    told = {key: trained[key] for key in kept if key in trained}
    unit = {key: metadata[key] for key in ("unit", "refuse_outside") if key in metadata}
    return unit | {"runs": [{"run": name} for name in trained.get("runs") or []]} | told


def _predictor(module: Model, folder: Path, ranges: Ranges) -> Callable[[Run, torch.device], Tensor]:
    def predict(run: Run, device: torch.device) -> Tensor:
        try:
            return predict_blocks((module if _has_all(run, module) else narrowed(module.cpu(), ranges)).to(device), run)
        except InputError as error:
            raise InputError(f"{folder}: {error}") from error

    return predict


def _extrapolation(module: Model, ranges: Ranges) -> Callable[[Run], dict[str, Any]]:
    @cache
    def reach(whole: bool) -> Reach:
        return Reach(module if whole else narrowed(module.cpu(), ranges), ranges)

    return lambda run: reach(_has_all(run, module)).beyond([run])


def _has_all(run: Run, module: Model) -> bool:
    """Whether a run has all of a model's columns; else it is asked only for those that the model uses."""
    return {*module.inputs} <= {*run.columns, OUTPUT}


def given_predictions(files: Mapping[str, list[Path]], runs: Sequence[str], data: Mapping[str, Any]) -> list[Entrant]:
    """Predictions made elsewhere as entrants.

    Args:
        files: of each set, by its name.
        runs: names of those that are compared.
        data: settings by which the measurement files are read.
    """
    time, skip, unit = (data.get("columns") or {}).get("time"), data["bad_rows"] == "skip", data.get("time_unit")

    def predictor(name: str, paths: list[Path]) -> Callable[[Run, torch.device], Tensor]:
        own = files_of(runs, name, paths)
        return lambda run, _: read_prediction(own[run.name], run, time, skip, unit)

    return [Entrant(name, name, paths[0].parent, {}, {}, predictor(name, paths)) for name, paths in files.items()]


def named(entrants: list[Entrant]) -> list[Entrant]:
    """The same, each with a name of its own."""
    told = [replace(one, facts=one.facts | {"settings": words}) for one, words in zip(entrants, _what_differs(entrants), strict=True)]
    return [replace(one, name=name) for one, name in zip(told, distinct_names(told, names("init")), strict=True)]


def _what_differs(entrants: list[Entrant]) -> list[str]:
    """The settings by which those of one type, start and optimizer can be told apart."""
    groups: dict[tuple[Any, ...], list[int]] = {}
    for place, one in enumerate(entrants):
        groups.setdefault(_label(one), []).append(place)
    words: dict[int, str] = {}
    for places in groups.values():
        words |= zip(places, telling_words([entrants[place].settings for place in places]), strict=True)
    return [words[place] for place in range(len(entrants))]


def _label(one: Entrant) -> tuple[Any, ...]:
    ladder = one.facts.get("ladder")
    return one.kind, one.facts.get("init"), one.facts.get("optimizer"), None if ladder is None else tuple(step.get("added") for step in ladder)


def _settings(folder: Path, facts: Mapping[str, Any], but: Sequence[str]) -> dict[str, str]:
    """The config that the model was made with, but for some keys; the model's own where that is not kept, or says only where it came from."""
    config = read_yaml(command_config(folder) or folder / MODEL_FILE)
    model = config.get("model") if isinstance(config, dict) else None
    if isinstance(model, dict) and "folder" in model:
        config["model"] = read_yaml(folder / MODEL_FILE)
    elif isinstance(model, dict) and isinstance(model.get("network"), str):  # its name alone
        model["network"] = read_yaml(folder / MODEL_FILE)["network"]
    flat = dict(_flat(config))
    if "data.average_s" in flat and facts.get("average_s"):
        flat |= _flat(facts["average_s"], "data.average_s")  # what auto came to
    return {key: value for key, value in flat.items() if not any(key == one or key.startswith(f"{one}.") for one in but)}


def _flat(config: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(config, dict):
        for key, value in config.items():
            yield from _flat(value, f"{prefix}.{key}" if prefix else str(key))
    else:
        number = isinstance(config, int | float) and not isinstance(config, bool)
        yield prefix, f"{config:.12g}" if number else str(config)  # 60 is 60.0


def _without_model(top: Path, files: Sequence[str]) -> list[Path]:
    """Folders of jobs that were to leave a model and did not."""
    jobs = [found.parent for found in sorted(top.rglob(".hydra"))]
    return [job for job in jobs if not any((job / file).is_file() for file in files) and was_made(job)]


def _without_result(folder: Path) -> bool:
    """Whether the command that was last in the folder has come to nothing, whatever an earlier one has left there."""
    return (folder / FAILED).is_file() or not any((folder / one).is_file() for one in RESULTS)
