"""What every simulated device gives, a gyro or an accelerometer: this is all that is known of it where it is written and printed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from torch import Tensor

from zoo.simulator.laboratory.program import Program


class Recording(Protocol):
    """One run."""

    @property
    def name(self) -> str:
        """``"run_1"``, …, or ``"check"``."""

    @property
    def program(self) -> Program:
        """What the chamber was asked for."""

    @property
    def table(self) -> Mapping[str, Tensor]:
        """Columns of the measurement file, each (T,)."""

    @property
    def truth(self) -> Mapping[str, Tensor]:
        """Columns of the truth, each (T,)."""

    @property
    def error(self) -> Tensor:
        """(T,) output − reference [the output's unit]."""


class Simulated(Protocol):
    """One device's campaign."""

    @property
    def kind(self) -> str:
        """``"gyro"`` or ``"accelerometer"``."""

    @property
    def name(self) -> str:
        """Class or make of the device."""

    @property
    def seed(self) -> int:
        """Which one of them."""

    @property
    def unit(self) -> str:
        """Suffix of the output's unit."""

    @property
    def present(self) -> Sequence[str]:
        """Names of the effects that the user is told."""

    @property
    def hidden(self) -> Sequence[str]:
        """Names of those that stand in the truth only."""

    @property
    def runs(self) -> Sequence[Recording]:
        """Runs to be fitted."""

    @property
    def check(self) -> Recording:
        """The run that is never fitted."""

    def truth(self) -> dict[str, Any]:
        """Everything that a fit could be asked to find, each number with its unit."""


def heading(one: Simulated) -> dict[str, Any]:
    """The first entries of ``truth.json``."""
    told = {"gyro": one.name, "seed": one.seed, "unit": one.unit}
    return {"schema_version": 1, **told, "effects": list(one.present), "hidden": list(one.hidden)}


def recorded_runs(one: Simulated) -> dict[str, Any]:
    """The last entries of ``truth.json``: the files and the chamber's legs of each run."""
    return {"runs": [_listed(run) for run in one.runs], "check": _listed(one.check)}


def valued(value: float, unit: str) -> dict[str, Any]:
    """A number as ``truth.json`` holds it."""
    return {"value": value, "unit": unit}


def truth_file(one: Recording) -> str:
    """Name of the file with the truth of a run."""
    return f"truth_{one.name.removeprefix('run_')}.csv"


def _listed(one: Recording) -> dict[str, Any]:
    return {"file": f"{one.name}.csv", "truth": truth_file(one), "legs": [list(leg) for leg in one.program.legs]}
