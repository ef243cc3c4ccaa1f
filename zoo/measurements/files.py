"""From what the user wrote under ``data.files`` to paths, and from paths to names."""

from __future__ import annotations

import glob
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from zoo.errors import InputError

SUFFIXES = (".csv", ".csv.gz", ".parquet")


def suffix(path: Path) -> str:
    """Which kind of table a file is, by its name.

    Raises:
        InputError: none that can be read.
    """
    found = next((one for one in SUFFIXES if path.name.lower().endswith(one)), None)
    if found is None:
        raise InputError(f"{path}: not a measurement file by its name; possible: {', '.join(SUFFIXES)}")
    return found


def find_files(files: Sequence[str | Path] | str | Path, key: str = "data.files") -> list[Path]:
    """Existing files in the order given; what a glob finds is sorted by name.

    Args:
        files: paths and globs.
        key: under which they were given, for messages.

    Raises:
        InputError: nothing was asked for, a path does not exist or is a folder, a glob finds nothing, a file is named twice.
    """
    if not isinstance(files, str | Path | Sequence):
        raise InputError(f"{key}={'null' if files is None else files}: paths or globs are needed: {key}=[a.csv,b.csv]")
    asked = [files] if isinstance(files, str | Path) else list(files)
    if not asked:
        raise InputError(f"{key} is empty; give at least one measurement file: {key}=[a.csv,b.csv]")
    paths = [path for one in asked for path in _matches(str(one))]
    count = Counter(path.resolve() for path in paths)
    twice = next((path for path in paths if count[path.resolve()] > 1), None)
    if twice:
        raise InputError(f"{twice}: is named twice in [{', '.join(map(str, asked))}]; a run counts once")
    return paths


def _matches(asked: str) -> list[Path]:
    path = Path(asked).expanduser()
    if path.is_dir():
        raise InputError(f"{asked}: is a folder; name the files in it: {_inside(path)}")
    if path.exists():
        return [path]
    if not glob.has_magic(asked):
        raise InputError(f"{asked}: no such file{_instead(path)}")
    found = sorted({Path(name) for name in glob.glob(str(path), recursive=True) if Path(name).is_file()})  # noqa: PTH207 - Path.glob takes no absolute pattern
    if not found:
        raise InputError(f"{asked}: no file matches{_instead(path)}")
    return found


def _inside(folder: Path) -> str:
    """What may be meant by a folder: its runs, or all its files, and those to check on by themselves."""
    runs = "run_*.csv" if any(folder.glob("run_*.csv")) else "*.csv"
    checks = "; what is called check… belongs into data.check_files" if any(folder.glob("check*.csv")) else ""
    return f"data.files=[{folder / runs}]{checks}"


def _instead(path: Path) -> str:
    """What lies in the folder that was meant, as the end of a message."""
    if not path.parent.is_dir():
        return f"; the folder {path.parent} does not exist"
    there = sorted(one.name for one in path.parent.iterdir() if one.name.lower().endswith(SUFFIXES))
    more = f" and {len(there) - 8} more" if len(there) > 8 else ""
    return f"; {path.parent} has {', '.join(there[:8])}{more}" if there else f"; there is no measurement file in {path.parent}"


def run_names(paths: Sequence[Path]) -> list[str]:
    """A name for each run: the file's stem; where stems clash, the folder's name before it; where that clashes too, the path."""
    stems = [path.name[: -len(suffix(path))] for path in paths]
    names = _where_unique(stems, [f"{path.resolve().parent.name}/{stem}" for path, stem in zip(paths, stems, strict=True)])
    return _where_unique(names, [str(path) for path in paths])


def _where_unique(names: list[str], longer: list[str]) -> list[str]:
    count = Counter(names)
    return [long if count[name] > 1 else name for name, long in zip(names, longer, strict=True)]
