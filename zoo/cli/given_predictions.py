"""Files of predictions made elsewhere, as given by `predictions=`: which one belongs to which run."""

from __future__ import annotations

import glob
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from zoo.errors import InputError
from zoo.measurements.files import SUFFIXES, run_names
from zoo.measurements.run import HELD_OUT


def named_files(given: Any) -> dict[str, list[Path]]:
    """The files of each set of predictions, by the set's name.

    Args:
        given: None; ``{NAME: FILES}``; or folders and files, each of which names itself. FILES are a path, a folder, a glob or a list of these.

    Raises:
        InputError: something given leads to no file.
    """
    if given is None:
        return {}
    if not isinstance(given, (str, list, dict)):
        raise InputError(f"predictions={given}: give files with time_s and predicted_error_<unit>: predictions={{mymodel: pred_*.csv}}")
    if isinstance(given, dict):
        return {str(name): _files(f"predictions.{name}", files) for name, files in given.items()}
    asked = [given] if isinstance(given, str) else list(given)
    found: dict[str, list[Path]] = {}
    for one in asked:
        path = Path(str(one)).expanduser()
        name = path.resolve().name if path.is_dir() else run_names([path])[0] if path.is_file() else path.resolve().parent.name
        found.setdefault(name, []).extend(_files("predictions", one))
    return found


def _files(key: str, given: Any) -> list[Path]:
    found = []
    for one in given if isinstance(given, list) else [] if given is None else [given]:
        path = Path(str(one)).expanduser()
        named = [str(path)] if path.exists() else glob.glob(str(path), recursive=True)  # noqa: PTH207 (Path.glob takes no absolute pattern)
        matches = sorted(path.iterdir()) if path.is_dir() else sorted(map(Path, named))
        files = [match for match in matches if match.is_file() and match.name.lower().endswith(SUFFIXES)]
        if not files:
            raise InputError(f"{key}: {one}: no {', '.join(SUFFIXES)} there; give files with time_s and predicted_error_<unit>, one a run")
        found += files
    if not found:
        raise InputError(f"{key} is empty; give files with time_s and predicted_error_<unit>: predictions={{mymodel: pred_*.csv}}")
    return found


def files_of(runs: Sequence[str], name: str, files: list[Path]) -> dict[str, Path]:
    """The file that holds the predictions for each run, by the run's name.

    Args:
        runs: names of the runs; pieces that were held out of one have its file.
        name: of the set of predictions, for messages.
        files: of the set.

    Raises:
        InputError: there is none for a run, or more than one, or one for two of them.
    """
    found = {run: _file_of(run, name, files, len(runs)) for run in runs}
    owner: dict[Path, str] = {}
    for run, path in found.items():
        whole = run.removesuffix(HELD_OUT)
        if owner.setdefault(path, whole) != whole:
            told = f"{path.name} would be taken for the run {owner[path]} and for {whole}"
            raise InputError(f"predictions: {name}: {told}; call the files of the runs, and those of the predictions, differently")
    return found


def _file_of(run: str, name: str, files: list[Path], runs: int) -> Path:
    """The file for one run: called like it, or with the run's name as a part of its own; or the only file for the only run.

    Where two are called alike, that in a folder called like the run's.

    Raises:
        InputError: there is none, or more than one.
    """
    folder, _, stem = run.removesuffix(HELD_OUT).rpartition("/")
    by_stem = {path: _stem(path) for path in files}
    exact = [path for path, own in by_stem.items() if own == stem]
    part = re.compile(rf"(?<![A-Za-z0-9]){re.escape(stem)}(?![A-Za-z0-9])")
    found = exact or [path for path, own in by_stem.items() if part.search(own)] or (files if len(files) == runs == 1 else [])
    near = [path for path in found if folder and path.resolve().parent.name == folder.rpartition("/")[2]]
    if len(near or found) == 1:
        return (near or found)[0]
    said = f"several files ({_listed(found)})" if found else f"none of the files ({_listed(files)})"
    raise InputError(f"predictions: {name}: {said} for the run {stem}; one is needed, called {stem}.csv or such as pred_{stem}.csv")


def _stem(path: Path) -> str:
    return next(path.name[: -len(end)] for end in sorted(SUFFIXES, key=len, reverse=True) if path.name.lower().endswith(end))


def _listed(paths: Iterable[Path]) -> str:
    names = [path.name for path in paths]
    return ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
