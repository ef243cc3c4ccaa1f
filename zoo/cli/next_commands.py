"""What to type after a verb, with the settings as they were typed for it."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig

from zoo.cli.command_line import searchpath, typed
from zoo.given import listed
from zoo.report.unknown_stub import stub_of

RUNS = ("data", "data.files", "data.check_files")
"""Settings that say which runs are read."""
HELD = ("data.holdout", "data.points.checked")
"""Settings that keep pieces of the fitted runs from the fit: `compare` then judges what was kept from it."""
FITTED = "# judges the fitted runs: data.files=[…] of runs no model has seen says more"
"""Said of a command to compare where nothing else is known than what was fitted; a comment, so that it may be pasted with the command."""


def typed_settings() -> list[str]:
    """The settings as they were typed, whichever they are, without what to add; the user's own config folders come last."""
    return [*(one for one in typed() if not one.startswith("add=")), *own_configs()]


def own_configs() -> list[str]:
    """The setting that names the user's own config folders; none where there are none."""
    folders = [f"file://{folder}" for folder in searchpath()]
    return [listed("hydra.searchpath", folders)] if folders else []


def with_own_configs(command: str | None) -> str | None:
    """A command with the user's own config folders, of which it may name an effect."""
    return command and " ".join([command, *map(shlex.quote, own_configs())])


def refine_words() -> list[str]:
    """The command that refines what was diagnosed, but for what to add."""
    return ["fogzoo", "refine", *typed_settings()]


def next_commands(missing: list[str]) -> list[str]:
    """What to type after a diagnosis to add the missing effects; nothing where none is missing."""
    return [shlex.join(["fogzoo", "refine", f"add=[{','.join(missing)}]", *typed_settings()])] if missing else []


def save_command() -> str:
    """What to type to save a model that lacks nothing, for `compensate` and `export`, and to check it on other runs."""
    return shlex.join(["fogzoo", "refine", "add=[]", *typed_settings()])


def diagnose_command(effects: list[str]) -> str:
    """What to type to see what these effects leave together."""
    return shlex.join(["fogzoo", "diagnose", listed("effects", effects), *(one for one in typed_settings() if not one.startswith("effects="))])


def stub_commands(diagnosis: dict[str, Any], out: Path) -> list[str]:
    """What to type to refit with the class that was written for what nothing explains; nothing where it is only an example.

    Args:
        diagnosis: the record.
        out: the folder that the class was written to.
    """
    form = diagnosis.get("unexplained_form")
    stub = stub_of(diagnosis) if form and not form["todo"] else None
    return [] if stub is None else stub.commands(out, refine_words())


def form_is_better(diagnosis: dict[str, Any]) -> bool:
    """Whether the class that was written is worth trying before the effects that help: it does as well, or leaves less."""
    form = diagnosis.get("unexplained_form") or {}
    return bool(diagnosis.get("outdone")) or form.get("rms", math.inf) < (diagnosis.get("rms_final") or 0.0)


def compare_command(folder: Path, settings: Sequence[str]) -> str:
    """What to type to see models by stage: on what was checked on, where there is anything, read as it was.

    Args:
        folder: of the models.
        settings: as they were typed; those of the data count, and where the user's own configs lie.
    """
    typed = {one.partition("=")[0]: one.partition("=")[2] for one in settings if one.lstrip("+").startswith(("data", "hydra.searchpath="))}
    apart = any(typed.get(key, "0") not in {"0", "0.0"} for key in HELD)
    files = typed.get("data.files") if apart else typed.get("data.check_files") or typed.get("data.files")
    kept = {key: value for key, value in typed.items() if key not in ({"data.files"} if apart else {*RUNS[1:], *HELD})}
    judged = [f"data.files={files}"] if files else []
    return shlex.join(["fogzoo", "compare", listed("runs", [str(folder)]), *judged, *(f"{key}={kept[key]}" for key in kept)])


def settled_data(config: DictConfig) -> list[str] | None:
    """The settings of the data in a sweep, as one would type them for a command that is none; None where its jobs have not the same runs.

    Args:
        config: of the sweep, with Hydra's own.
    """
    parsed = OverridesParser.create().parse_overrides([one for one in config.hydra.overrides.task if one.lstrip("+").startswith("data")])
    if any(one.is_sweep_override() and one.key_or_group in RUNS for one in parsed):
        return None
    choice = config.hydra.runtime.choices.get("data", "files")  # an experiment chooses as well
    chosen = [] if choice == "files" else [f"data={choice}"]
    kept = [str(one.input_line) for one in parsed if not one.is_sweep_override() and one.key_or_group != "data"]
    return [*chosen, *kept, *(one for one in config.hydra.overrides.hydra if one.startswith("hydra.searchpath="))]
