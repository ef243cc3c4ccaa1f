"""A simulation on disk: measurement files, and apart from them the truth."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from zoo.artifacts import write_json
from zoo.errors import InputError
from zoo.measurements.write import write_measurements
from zoo.simulator.simulated import Recording, Simulated, truth_file


def write(simulation: Simulated, folder: Path, track: Any = iter) -> Path:
    """Write ``run_1.csv …``, ``check.csv``, their ``truth_….csv`` and ``truth.json``.

    Args:
        simulation: what to write.
        folder: where to.
        track: wraps the runs to show progress.

    Returns:
        The folder.

    Raises:
        InputError: the folder holds runs that this simulation would not replace, so that a glob would mix two devices; a number is not finite.
    """
    _check_empty(simulation, folder)
    _check_finite(simulation)
    recorded: Iterable[Recording] = track([*simulation.runs, simulation.check])
    for one in recorded:
        write_measurements(folder / truth_file(one), one.truth)  # first: by it a simulated run is told from a user's own
        write_measurements(folder / f"{one.name}.csv", one.table)
    write_json(folder / "truth.json", simulation.truth())
    return folder


def _check_finite(simulation: Simulated) -> None:
    for one in (*simulation.runs, simulation.check):
        for name, column in (*one.table.items(), *one.truth.items()):
            if not bool(column.isfinite().all()):
                raise InputError(f"{one.name}.csv: {name} would not be finite; some setting is out of all proportion")


def _check_empty(simulation: Simulated, folder: Path) -> None:
    known = {f"{one.name}.csv": folder / truth_file(one) for one in (*simulation.runs, simulation.check)}
    there = [*folder.glob("run_*.csv*"), *folder.glob("check.csv")]
    other = sorted(path.name for path in there if path.name not in known or not known[path.name].is_file())
    if other:
        raise InputError(f"{folder}: holds {other[0]} of something else; choose another folder with hydra.run.dir=…")
