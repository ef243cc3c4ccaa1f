"""What became of a job: a record in its folder, by which a sweep in other processes learns of it and a later one sees what is done already."""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf

import zoo
from zoo.artifacts import write_json
from zoo.cli.command_line import plain
from zoo.measurements.files import find_files

RECORD = ".hydra/outcome.json"
"""Beside what Hydra keeps of a job."""
FAILED = "failed.txt"
"""In the folder of a job of a sweep that failed: why. Its folder counts as one without a model."""
SINGLE = ""
"""Name of the sweep that a job alone belongs to."""


def new_sweep() -> str:
    """A name for a sweep that this process starts."""
    return f"sweep-{os.getpid()}-{secrets.token_hex(4)}"


def started_by(sweep: str) -> int:
    """The number of the process that has named a sweep."""
    return int(sweep.split("-")[1])


@dataclass(frozen=True)
class Outcome:
    """What became of a job.

    Attributes:
        sweep: the sweep that it belongs to.
        overrides: the settings that were typed, as this job has them.
        made_from: what decides the result: settings, files and version, as text.
        code: the exit code; None while it runs, and for good where it was killed.
        message: why it failed.
        result: its main result.
        again: whether an earlier job had done it.
        replaced: the settings, as typed, of another job that had come to an end in the folder; None where there was none.
    """

    sweep: str
    overrides: Sequence[str]
    made_from: str
    code: int | None = None
    message: str = ""
    result: str | None = None
    again: bool = False
    replaced: Sequence[str] | None = None

    def write(self, folder: Path) -> Outcome:
        """Put it into the job's folder."""
        write_json(folder / RECORD, asdict(self))
        return self


def read_outcome(folder: Path) -> Outcome | None:
    """The record in a job's folder; None where there is none that can be read."""
    try:
        return Outcome(**json.loads((folder / RECORD).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def read_outcomes(sweep_folder: Path, sweep: str) -> dict[Path, Outcome]:
    """All jobs of a sweep by folder, in the order of their numbers.

    Args:
        sweep_folder: where they lie; those of earlier sweeps may lie there too.
        sweep: its name.
    """
    return {folder: one for folder, one in _records(sweep_folder) if one.sweep == sweep}


def left_by_others(sweep_folder: Path, sweep: str) -> list[Path]:
    """Folders of jobs that have come to an end in other sweeps, below a sweep's folder.

    Args:
        sweep_folder: where they lie.
        sweep: the name of the one.
    """
    return [folder for folder, one in _records(sweep_folder) if one.sweep != sweep and one.code == 0]


def _records(sweep_folder: Path) -> Iterator[tuple[Path, Outcome]]:
    """All that can be read below a folder, in the order of the jobs' numbers."""
    for folder in sorted((found.parent.parent for found in sweep_folder.rglob(RECORD)), key=lambda one: (len(one.name), str(one))):
        if (found := read_outcome(folder)) is not None:
            yield folder, found


def finished_before(folder: Path, new: Outcome) -> Outcome | None:
    """The record of a job that a new one would only repeat, now as the new one's; None where there is something to do.

    Args:
        folder: of the job.
        new: about to begin there.
    """
    old = read_outcome(folder)
    if old is None or old.code != 0 or old.made_from != new.made_from or old.result is None or not Path(old.result).is_file():
        return None
    return replace(new, code=0, result=old.result, again=True)


def replaced_by(folder: Path, new: Outcome) -> Sequence[str] | None:
    """The settings of a job that has come to an end in a folder where one with others is about to begin; None where there is none."""
    old = read_outcome(folder)
    return None if old is None or old.code != 0 or list(old.overrides) == list(new.overrides) else old.overrides


def made_from(config: DictConfig, but: Sequence[str] = ("hydra", "objective")) -> str:
    """What decides a result, as text: the settings, this program's version, and which measurements they are.

    Args:
        config: composed.
        but: keys at its top that decide nothing.

    Raises:
        InputError: the files are not there, or the simulation that is asked for cannot be.
    """
    return f"{_settings_text(config, but)} {json.dumps(_stamps(config))} {zoo.__version__}"


def _stamps(config: DictConfig) -> list[Any]:
    """Name, size and time of the files of measurements; of a simulation its recording's name, which stands for settings and code alike."""
    data = config.get("data") or OmegaConf.create()
    if data.get("simulated") is not None:
        from zoo.cli.simulated_data import recorded  # the simulator, only where it is asked

        return [recorded(plain(data.simulated), Path(data.folder)).name]
    given = {key: OmegaConf.select(data, key) for key in ("files", "check_files")}
    files = [path.resolve() for key, one in given.items() if one for path in find_files(plain(one), f"data.{key}")]
    return [[str(path), path.stat().st_size, path.stat().st_mtime_ns] for path in files]


def _settings_text(config: DictConfig, but: Sequence[str]) -> str:
    """Settings as a text that is equal where they are.

    Args:
        config: composed.
        but: keys at its top that are left out.
    """
    return json.dumps({key: value for key, value in sorted(plain(config).items()) if key not in but}, sort_keys=True)
