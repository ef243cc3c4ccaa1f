"""Turns a verb into a Hydra application with the contract's exit codes: 0 done, 1 the work failed, 2 the input is wrong."""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.errors import (
    ConfigCompositionException,
    HydraException,
    InstantiationException,
    MissingConfigException,
    OverrideParseException,
    SearchPathException,
)
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from zoo.artifacts import writable_folder
from zoo.catalog import config_folder
from zoo.errors import InputError, WorkError, nearest

Verb = Callable[[DictConfig, Path], Path]
VERBS = ("simulate", "train", "compare", "diagnose", "refine", "compensate", "export", "reproduce")


def run(verb: str, arguments: list[str]) -> int:
    """Run one verb as a Hydra application.

    Args:
        verb: one of `VERBS`.
        arguments: Hydra flags and overrides.

    Returns:
        The exit code.
    """
    full_error = os.environ.get("HYDRA_FULL_ERROR")
    os.environ["HYDRA_FULL_ERROR"] = "1"  # else Hydra prints its own trace and hides the exception from us
    sys.argv = [f"fogzoo {verb}", *arguments]
    try:
        hydra.main(version_base="1.3", config_path=str(config_folder()), config_name=verb)(_task(verb))()
    except Exception as error:
        if full_error == "1":
            raise
        code, message = explain(error)
        print(message, file=sys.stderr)
        return code
    return 0


def _task(verb: str) -> Callable[[DictConfig], str]:
    def task(config: DictConfig) -> str:
        module = importlib.import_module(f"zoo.cli.{verb}")
        out = Path(HydraConfig.get().runtime.output_dir)
        writable_folder(out)
        result = str(module.run(config, out))
        print(result)
        return result

    task.__name__ = verb
    return task


def explain(error: BaseException) -> tuple[int, str]:
    """The exit code and the one or two lines for an exception; never a traceback."""
    for cause in _chain(error):
        if isinstance(cause, InputError):
            return 2, f"error: {cause}"
        if isinstance(cause, WorkError):
            return 1, f"failed: {cause}"
    if isinstance(error, MissingConfigException) and error.options is not None:
        group, _, name = str(error.missing_cfg_file).rpartition("/")
        return 2, f"error: unknown {group.removesuffix('s')} '{name}': {nearest(name, error.options)}"
    if isinstance(error, (ConfigCompositionException, OverrideParseException, MissingConfigException, SearchPathException, OmegaConfBaseException)):
        return 2, f"error: {_first_lines(error)}"
    if isinstance(error, PermissionError | FileExistsError | NotADirectoryError):
        return 2, f"error: {error.filename}: cannot be written ({error.strerror}); choose another folder with hydra.run.dir=…"
    if isinstance(error, InstantiationException):
        return 2, f"error: {_first_lines(error)}"
    known = "" if isinstance(error, HydraException) else f"{type(error).__name__}: "
    return 1, f"failed: {known}{_first_lines(error)} (HYDRA_FULL_ERROR=1 shows where)"


def _chain(error: BaseException | None) -> list[BaseException]:
    found: list[BaseException] = []
    while error is not None and error not in found:
        found.append(error)
        error = error.__cause__ or error.__context__
    return found


def _first_lines(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    key = re.search(r"Could not override '([^']+)'", str(error))
    if key:
        return f"unknown key '{key.group(1)}'; --cfg job prints all keys (a new key takes a leading +)"
    return " ".join(lines[:2]) or type(error).__name__
