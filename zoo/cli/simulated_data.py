"""Runs that a data config asks the simulator for: recorded once, and read like anybody's files from then on."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from omegaconf import OmegaConf
from rich.console import Console
from rich.text import Text
from torch import Tensor

import zoo
from zoo.artifacts import folder_replacing, write_text
from zoo.catalog import config_folder
from zoo.cli.command_line import composed, searchpath
from zoo.cli.simulate import simulations
from zoo.measurements.write import write_measurements
from zoo.simulator.simulated import Recording

SETTINGS = "simulated.yaml"
NOISELESS = "noiseless_"
"""Before the name of what would have been recorded of a run without noise of the output."""
CODE = ("simulator", "effects", "physics", "units.py", "cli/simulated_data.py", "cli/simulate.py", "measurements/write.py")
CONFIGS = ("gyro", "profile", "noise", "chamber", "effects", "simulate.yaml")
"""What a recording depends on."""


def recorded(settings: Mapping[str, Any], folder: Path) -> Path:
    """The folder with ``run_1.parquet …`` and ``check.parquet`` of a simulation; simulated where it is not there yet.

    Beside each lies a ``noiseless_….parquet``, by which one knows how good a model could be.

    A recording is known by its settings and by the code that made it, so that neither an old simulator's runs nor another seed's are taken for it.

    Args:
        settings: of `fogzoo simulate`, by key.
        folder: where recordings are kept.

    Raises:
        InputError: the settings are wrong.
    """
    overrides = list(_overrides(settings))
    place = folder / f"{settings.get('gyro', 'gyro')}-{_fingerprint(overrides)}"
    if (place / SETTINGS).is_file():
        return place
    Console(stderr=True).print(Text(f"simulating {' '.join(overrides)}, once, into {place}"), soft_wrap=True)
    simulation = next(simulations(composed("simulate", overrides)))
    with folder_replacing(place) as temporary:
        for one in (*simulation.runs, simulation.check):
            write_measurements(temporary / f"{one.name}.parquet", one.table)
            write_measurements(temporary / f"{NOISELESS}{one.name}.parquet", _noiseless(one, simulation.unit))
        write_text(temporary / SETTINGS, OmegaConf.to_yaml(OmegaConf.create(dict(settings))))
    return place


def _noiseless(one: Recording, unit: str) -> dict[str, Tensor]:
    """The columns of a measurement file whose error is the true one."""
    reference = one.table[f"reference_{unit}"]
    output = next(name for name in one.table if name in {unit, f"rate_{unit}", f"accel_{unit}"})
    return {**one.table, output: reference + one.truth[f"sum_{unit}"]}


def _overrides(settings: Mapping[str, Any], above: str = "") -> Iterator[str]:
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from _overrides(value, f"{above}{key}.")
        else:
            yield f"{above}{key}={'null' if value is None else value}"


def _fingerprint(overrides: list[str]) -> str:
    package = Path(zoo.__file__).resolve().parent
    parts = [*(package / part for part in CODE), *(folder / part for folder in (config_folder(), *searchpath()) for part in CONFIGS)]
    files = [path for part in parts for path in (sorted(part.rglob("*.[py]*")) if part.is_dir() else [part])]
    written = hashlib.sha256("\n".join(overrides).encode())
    for path in files:
        if path.suffix in {".py", ".yaml"} and path.is_file():  # the user's own folders need not have all parts
            written.update(path.read_bytes())
    return written.hexdigest()[:10]
