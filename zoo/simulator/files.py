"""A simulation on disk: measurement files, and apart from them the truth."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from zoo.artifacts import write_json
from zoo.errors import InputError
from zoo.measurements.write import write_measurements
from zoo.simulator.simulate import Recorded, Simulation

UNITS = {
    "random_walk": "°/√h",
    "flicker": "°/h",
    "rate_random_walk": "°/h/√h",
    "angle_step_arcsec": "arcsec",
    "thermometer_c": "K",
    "resolution_c": "K",
}
SETTING_UNITS = {"sample_s": "s", "chamber_s": "s", "reference_dph": "°/h"}


def write(simulation: Simulation, folder: Path, track: Any = iter) -> Path:
    """Write ``run_1.csv …``, ``check.csv``, their ``truth_….csv`` and ``truth.json``.

    Args:
        simulation: what to write.
        folder: where to.
        track: wraps the runs to show progress.

    Returns:
        The folder.

    Raises:
        InputError: the folder holds runs that this simulation would not replace, so that a glob would mix two gyros.
    """
    _check_empty(simulation, folder)
    recorded: Iterable[Recorded] = track([*simulation.runs, simulation.check])
    for one in recorded:
        write_measurements(folder / f"{one.name}.csv", one.table)
        write_measurements(folder / truth_file(one), one.truth)
    write_json(folder / "truth.json", truth(simulation))
    return folder


def truth_file(one: Recorded) -> str:
    """Name of the file with the truth of a run."""
    return f"truth_{one.name.removeprefix('run_')}.csv"


def _check_empty(simulation: Simulation, folder: Path) -> None:
    known = {f"{one.name}.csv" for one in simulation.runs}
    other = sorted(path.name for path in folder.glob("run_*.csv*") if path.name not in known)
    if other:
        raise InputError(f"{folder}: holds {other[0]} of something else; choose another folder with hydra.run.dir=…")


def truth(simulation: Simulation) -> dict[str, Any]:
    """Everything that a fit could be asked to find, each number with its unit."""
    device, settings = simulation.device, simulation.settings
    sensors = [{"time_constant": _value(tau, "s"), "offset": _value(offset, "K")} for tau, offset in device.sensors]
    return {
        "schema_version": 1,
        "gyro": device.name,
        "seed": settings.seed,
        "unit": "dph",
        "effects": list(simulation.present),
        "hidden": list(simulation.hidden),
        "parameters": {name: {one: _value(*value) for one, value in share.parameters().items()} for name, share in simulation.shares.items()},
        "rms": {name: _value(share.rms, "°/h") for name, share in simulation.shares.items()},
        "noise": {key: _value(value or 0.0, UNITS[key]) for key, value in vars(simulation.noise).items()},
        "device": {key: _value(value, device.units[key]) for key, value in device.values.items()},
        "thermometers": sensors,
        "settings": {**{key: _value(getattr(settings, key), unit) for key, unit in SETTING_UNITS.items()}, "cold_start": settings.cold_start},
        "runs": [_program(one) for one in simulation.runs],
        "check": _program(simulation.check),
    }


def _program(one: Recorded) -> dict[str, Any]:
    return {"file": f"{one.name}.csv", "truth": truth_file(one), "legs": [list(leg) for leg in one.scenario.program.legs]}


def _value(value: float, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit}
