"""What several verbs do with their config: read the runs named in it."""

from __future__ import annotations

import glob
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import torch
from omegaconf import DictConfig, OmegaConf, open_dict
from rich.console import Console
from rich.text import Text

from zoo.catalog import create, load
from zoo.cli.command_line import plain, searchpath
from zoo.cli.effects import catalogue, chosen, named
from zoo.diagnosis.preparation import without_spikes
from zoo.errors import InputError
from zoo.measurements.files import find_files
from zoo.measurements.points import Points
from zoo.measurements.run import SHARES, Run
from zoo.measurements.schema import one_sided
from zoo.models.features import Features


def read_data(config: DictConfig) -> tuple[list[Run], list[Run]]:
    """The runs to fit and the runs only to check on, from `config.data`.

    The block length found for the fitted runs is used for the others as well. Samples and blocks far off their neighbours are left out of all.
    `data.holdout` keeps pieces of every run for checking, `data.points` single blocks. A column that the runs to check on lack is left out of the
    others, where nothing that is asked for needs it.

    Raises:
        InputError: the settings or files are wrong.
    """
    data = config.data.copy()
    with open_dict(data):
        simulated = data.pop("simulated", None)
        if simulated is not None:
            from zoo.cli.simulated_data import recorded  # the simulator, only where it is asked

            _put_into(recorded(plain(simulated), Path(data.pop("folder"))), data)
        check_files, holdout, points = data.pop("check_files", []), data.pop("holdout", 0.0), _points(data.pop("points"))
    low, high = SHARES
    if not isinstance(holdout, int | float) or not (holdout == 0 or low <= holdout <= high):
        raise InputError(f"data.holdout={holdout}: 0 is possible, or a share of each run from {low} to {high}, taken to whole tenths")
    if holdout > 0 and not points.all:
        raise InputError("data.holdout and data.points: both say what is fitted; one of them is possible")
    whole = _distinct(create(data))
    runs, checks = points.drawn(points.meeting(whole))
    if holdout > 0:
        runs, checks = _held_out(runs, float(holdout))
    if check_files:
        _check_unseen(check_files, data.files)
        average_s = data.average_s if data.average_s is None else runs[0].average_s
        listed = [check_files] if isinstance(check_files, str) else list(check_files)
        found = _distinct(create(data, files=listed, average_s=average_s), whole)
        if data.get("reference") is None:
            _check_references(runs[0], found[0])
        spare = _spare(config, runs[0], found)
        runs, checks = ([_without(run, spare) for run in part] for part in (runs, checks))
        checks += points.meeting(found)
    if simulated is not None or not points.all:  # no recorder has failed; single points have no neighbours
        return runs, checks
    return runs if "candidates" in config else _clean(runs), _clean(checks)  # the search does so itself


def _clean(runs: list[Run]) -> list[Run]:
    """The runs without samples far off their neighbours, each noted: a few would be all that an RMS is made of."""
    return without_spikes(runs) if runs else []


def _held_out(runs: Sequence[Run], share: float) -> tuple[list[Run], list[Run]]:
    """Each run less the pieces that are kept from the fit, and those pieces; what a short run has none of is left out.

    Raises:
        InputError: nothing is left to fit, or to check on.
    """
    parts = zip(*(run.split(share) for run in runs), strict=True)
    fitted, held = ([one for one in part if one.blocks] for part in parts)
    if not fitted or not held:
        most = max(run.blocks for run in runs)
        raise InputError(f"data.holdout={share:g}: {most} means a run are too few to keep pieces of them apart; give a shorter data.average_s")
    return fitted, held


def _points(given: Any) -> Points:
    """Which single blocks are asked for; null is for all."""
    if given is not None and not OmegaConf.is_dict(given):
        raise InputError(f"data.points={given}: null is possible, or data.points.where=…, data.points.fitted=…, data.points.checked=…")
    return Points() if given is None else cast(Points, create(given))


def _put_into(place: Path, data: DictConfig) -> None:
    """Let the names of files be those of a recording.

    Raises:
        InputError: it has no such file.
    """
    for key in ("files", "check_files"):
        given = plain(data[key]) or []
        inside = {name: str(Path(glob.escape(str(place))) / name) for name in ([given] if isinstance(given, str) else given)}
        absent = next((name for name, path in inside.items() if not glob.glob(path)), None)  # noqa: PTH207 (Path.glob takes no absolute pattern)
        if absent is not None:
            raise InputError(f"data.{key}: {absent}: is none of the simulated runs that were chosen; data=files is for your own")
        data[key] = list(inside.values())


def _check_unseen(check_files: Any, files: Any) -> None:
    fitted = {path.resolve() for path in find_files(plain(files))}
    twin = next((path for path in find_files(plain(check_files), "data.check_files") if path.resolve() in fitted), None)
    if twin:
        raise InputError(f"data.check_files: {twin} is in data.files too; a run that was fitted checks nothing")


def _distinct(runs: list[Run], before: Sequence[Run] = ()) -> list[Run]:
    """The runs, none of which is another one of them, or one of those read before, under another name: what it says would count twice.

    Raises:
        InputError: one is.
    """
    seen: dict[tuple[float, ...], list[Run]] = {}
    for run in (*before, *runs):
        alike = seen.setdefault((run.rows, *(float(column[place]) for column in (run.time, run.error) for place in (0, -1))), [])
        same = (one for one in alike if one.columns == run.columns and torch.equal(one.table, run.table) and torch.equal(one.error, run.error))
        copied = next(same, None)
        if copied is not None:
            raise InputError(f"{run.name}: the same recording as {copied.name}; leave one of them out")
        alike.append(run)
    return runs


def _check_references(fitted: Run, check: Run) -> None:
    """Refuse runs to check on that record the true input where the fitted ones do not, or the other way round.

    Args:
        fitted: any of the runs, which are alike among themselves.
        check: any of the runs to check on, likewise.

    Raises:
        InputError: names both.
    """
    both = [(f"{one.name} ({key})", one) for key, one in (("data.files", fitted), ("data.check_files", check))]
    known = [(name, one.truth) for name, one in both if one.truth]
    lacking = [name for name, one in both if one.recorded and not one.truth]
    if known and lacking:
        raise one_sided(lacking, *known[0], fitted.unit)


def _spare(config: DictConfig, fitted: Run, checks: list[Run]) -> list[str]:
    """Columns of the fitted runs that the runs to check on lack and nothing needs that is asked for.

    Raises:
        InputError: one is needed, or the units differ.
    """
    other = next((run for run in checks if run.unit != fitted.unit), None)
    if other is not None:
        raise InputError(f"data.check_files: {other.name} is in {other.unit}, the fitted runs are in {fitted.unit}; one unit is needed")
    lacking = {name: run.name for run in checks for name in fitted.columns if name not in run.columns}
    if not lacking or "model" not in config:  # models that are compared were trained before: each asks for its own columns
        return []
    needed = sorted(_needed(config, fitted) & {*lacking})
    if needed:
        way = "; candidates=[…] may leave out the effects that need it" if _chooses(config) else ""
        raise InputError(f"data.check_files: {lacking[needed[0]]} lacks the column {', '.join(needed)} that the fitted runs have{way}")
    return list(lacking)


def _needed(config: DictConfig, fitted: Run) -> set[str]:
    """Columns that may be needed to predict a run: by the features and effects that are named; all where a model is asked for that may take any."""
    model, features = config.model, _features(config.model)
    if "candidates" in config and model.folder is None:
        effects = catalogue(config, None if _chooses(config) else named("add", config.add, "auto"))
    elif model.get("effects") is not None and model.get("inputs") is None:
        effects = chosen(config)
    else:
        return set(fitted.columns) if features is None or "inputs" in model else features
    return {*fitted.thermometers, *(features or ()), *(column for effect in effects.values() for column in effect.needs)}


def _features(model: DictConfig) -> set[str] | None:
    """Raw columns behind the features of a network, or of the one in a hybrid; None where it names none."""
    network = model.get("network", model)
    names = (load("model", network, searchpath()) if isinstance(network, str) else network).get("features")
    return set(Features([str(name) for name in names]).inputs) if OmegaConf.is_list(names) else None


def _chooses(config: DictConfig) -> bool:
    """Whether the effects that may be added to a sum of effects are the candidates."""
    return "candidates" in config and config.model.folder is None and config.get("add", "auto") == "auto"


def _without(run: Run, names: list[str]) -> Run:
    """A run less some columns, with a note."""
    kept = tuple(name for name in run.columns if name not in names)
    notes = (f"{name} is not used, as not all the runs have it" for name in names)
    return run if not names else replace(run, columns=kept, table=run.select(kept), notes=(*run.notes, *notes))


def print_notes(runs: Sequence[Run]) -> None:
    """What reading noticed, each thing once."""
    from zoo.report.notes import merged  # the report's modules, only where there is something to tell

    notes = [note for run in runs for note in run.notes]
    for note in merged(notes, [run.name for run in runs]) if notes else []:
        Console(stderr=True).print(Text(note), style="dim", soft_wrap=True, highlight=False)
