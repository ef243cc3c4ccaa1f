"""Columns called as in a training, where nothing is said of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from omegaconf import OmegaConf
from rich.console import Console
from rich.text import Text

from zoo.cli.saved_models import command_config
from zoo.measurements.files import find_files
from zoo.measurements.table import column_names

UNITS = {"output": "output_unit", "time": "time_unit", "temperature": "temperature_unit"}
"""Columns that every file needs, and the settings of their units where their names do not tell them."""


def as_trained(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The settings of the data with columns called as in a training, where nothing is said of any and all files have these; in words if so.

    Args:
        data: settings, of which `files` are looked into.
        folder: of the training.
    """
    path = command_config(folder)
    if path is None or _called(data):
        return data
    known: dict[str, Any] = OmegaConf.to_container(OmegaConf.load(path), resolve=False)  # type: ignore[assignment]
    called, files = _called(known.get("data") or {}), [{*column_names(one)} for one in find_files(data["files"])]
    columns = {role: name for role, name in called.get("columns", {}).items() if role in UNITS or all(name in one for one in files)}
    if not columns or not all(name in one for name in columns.values() for one in files):
        return data
    told = ", ".join(f"{role}={name}" for role, name in columns.items())
    Console(stderr=True).print(Text(f"columns as in the training: {told}"), style="dim", soft_wrap=True, highlight=False)
    return data | {"columns": columns} | {unit: called[unit] for role, unit in UNITS.items() if role in columns and unit in called}


def _called(data: dict[str, Any]) -> dict[str, Any]:
    """What is said of the columns' names and units."""
    columns = {role: name for role, name in (data.get("columns") or {}).items() if name is not None}
    units = {unit: data[unit] for unit in UNITS.values() if data.get(unit) is not None}
    return ({"columns": columns} if columns else {}) | units
