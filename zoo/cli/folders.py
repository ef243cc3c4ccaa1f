"""Where the results of a command go: a folder of its own, and none at all where there is no result."""

from __future__ import annotations

import itertools
import logging
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Literal

from hydra.experimental.callback import Callback
from omegaconf import DictConfig, open_dict, read_write

from zoo.cli.jobs import OUTPUT
from zoo.cli.outcomes import FAILED

HYDRAS = {".hydra", "multirun.yaml"}
"""What Hydra writes before a job has done anything."""
NOTES = {FAILED, OUTPUT}
"""What a job leaves that has come to nothing."""

# Hydra builds its callbacks itself, so the folders they make new, the deepest first, are told through the module.
_new: list[Path] = []


class OutputFolder(Callback):
    """Hydra's hook before the first job: two commands of the same second get two folders."""

    def on_run_start(self, config: DictConfig, **kwargs: Any) -> None:
        """Of a single job."""
        _claim(config, "run")

    def on_multirun_start(self, config: DictConfig, **kwargs: Any) -> None:
        """Of a sweep, whose jobs have numbers below it."""
        _claim(config, "sweep")


@contextmanager
def hollow_removed() -> Iterator[None]:
    """Takes away again, at its end, the folders that a command has made and left without a result."""
    _new.clear()
    try:
        yield
    finally:
        _close_log()
        for folder in _new[:1]:
            _remove_hollow(folder)
        for parent in _new[1:]:
            with suppress(OSError):  # somebody else's results lie there
                parent.rmdir()
        _new.clear()


def _close_log() -> None:
    """Takes Hydra's log file away from the process, which would write into a folder that may not be there any more."""
    root = logging.getLogger()
    for handler in [one for one in root.handlers if isinstance(one, logging.FileHandler) and one.name == "file"]:
        root.removeHandler(handler)
        handler.close()


def _claim(config: DictConfig, kind: Literal["run", "sweep"]) -> None:
    wanted = Path(config.hydra[kind].dir)
    _new[:] = [one for one in (wanted.absolute(), *wanted.absolute().parents) if not one.exists()]
    if any(override.startswith(f"hydra.{kind}.dir=") for override in config.hydra.overrides.hydra):
        return  # the user may want to write there again
    folder = _made(wanted)
    if folder == wanted:
        return
    _new[:] = [folder.absolute()]
    with read_write(config), open_dict(config):
        config.hydra[kind].dir = str(folder)
        # The jobs of a sweep compose their configs anew, from the overrides.
        config.hydra.overrides.hydra.append(f"hydra.{kind}.dir='{folder}'")


def _made(wanted: Path) -> Path:
    """A folder that was not there, of this name or with the next free number behind it; mkdir decides who of two was first."""
    for number in itertools.count(1):
        folder = wanted if number == 1 else wanted.with_name(f"{wanted.name}-{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError:
            break  # Hydra meets the same obstacle, where it is told
        return folder
    return wanted


def _remove_hollow(folder: Path) -> None:
    """Of a sweep in which some jobs came to something, the notes of the others stay: why they did not."""
    if not folder.is_dir():
        return
    if _hollow(folder):
        shutil.rmtree(folder, ignore_errors=True)
        return
    for job in [child for child in folder.iterdir() if (child / ".hydra").is_dir()]:
        if not (job / FAILED).is_file():
            _remove_hollow(job)


def _hollow(folder: Path) -> bool:
    return all(_says_nothing(child) or ((child / ".hydra").is_dir() and _hollow(child)) for child in folder.iterdir())


def _says_nothing(child: Path) -> bool:
    return child.name in HYDRAS | NOTES or (child.suffix == ".log" and child.is_file() and child.stat().st_size == 0)
