"""Initial alignment: three accelerometers of an inertial unit at rest on a three-axis table, and the attitude that they give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.given import check_number
from zoo.physics.levelling import attitude, specific_force
from zoo.simulator.accelerometer.power_on import PowerOn
from zoo.simulator.accelerometer.preset import HUI2016, Accelerometer, specimen
from zoo.simulator.accelerometer.runs import PowerOnRun, PowerOnRuns, simulate_accelerometer
from zoo.simulator.streams import normal, stream

AXES = ("east", "north", "up")
"""Where the axes right, forward and up point at pitch, roll and heading 0."""
TABLE_ARCSEC = 4.7
"""How well a table is set in each angle, standard deviation: fitted to hui2016, whose check keeps 40 % of the line's attitude error."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """An inertial unit at rest.

    Attributes:
        pitch_deg: what the table is set to [°].
        roll_deg: likewise.
        axes: recordings of each accelerometer by `AXES`; their references are those of the angles that the table is set to.
        set_deg: pitch and roll that the table really had [°], by the run's name.
    """

    pitch_deg: float
    roll_deg: float
    axes: Mapping[str, PowerOnRuns]
    set_deg: Mapping[str, tuple[float, float]]

    def recorded(self, run: str = "check") -> dict[str, PowerOnRun]:
        """One power-on of the three accelerometers, by `AXES`."""
        return {axis: next(item for item in (*one.runs, one.check) if item.name == run) for axis, one in self.axes.items()}

    def attitude(self, errors: Mapping[str, Tensor], run: str = "check") -> tuple[Tensor, Tensor]:
        """Pitch and roll from compensated pulses.

        Args:
            errors: (T,) predicted error of each accelerometer [pulses] by `AXES`; zeros for no compensation.
            run: which power-on.

        Returns:
            Pitch and roll, each (T,) [°].
        """
        forces = [self._force(axis, one.table["pulses"] - errors[axis]) for axis, one in self.recorded(run).items()]
        return attitude(torch.stack(forces, dim=-1))

    def _force(self, axis: str, pulses: Tensor) -> Tensor:
        """(T,) [g] by the calibration at 25 °C."""
        device, gate_s = self.axes[axis].device, self.axes[axis].settings.sample_s
        return (pulses / gate_s - device["offset"]) / device["scale"]


def simulate_alignment(
    device: Accelerometer = HUI2016, pitch_deg: float = 0.0, roll_deg: float = 0.0, table_arcsec: float = TABLE_ARCSEC, **settings: Any
) -> Alignment:
    """Simulate an inertial unit that is powered on in the cold on a three-axis table. Its axes are taken to be square to each other.

    Args:
        device: make of its accelerometers; each is a specimen of its own.
        pitch_deg: what the table is set to [°].
        roll_deg: likewise.
        table_arcsec: standard deviation of the table's setting ["], anew at every power-on.
        **settings: `PowerOn` without the force.

    Raises:
        InputError: an angle that cannot be, or whatever `PowerOn` refuses.
    """
    check_number("pitch_deg", pitch_deg, -90.0, 90.0, "°")
    check_number("roll_deg", roll_deg, -180.0, 180.0, "°")
    check_number("table_arcsec", table_arcsec, 0.0, 3600.0, '"')
    if "force_g" in settings:
        raise InputError(f"force_g={settings['force_g']}: pitch_deg and roll_deg say what each axis feels")
    chosen = PowerOn(**settings)
    names = (*(f"run_{number}" for number in range(1, chosen.runs + 1)), "check")
    asked = torch.tensor([pitch_deg, roll_deg], dtype=torch.float64)
    off = {name: table_arcsec / 3600 * normal(2, stream(chosen.seed, "table", name)) for name in names}
    tilts = {name: specific_force(*(asked + one)) - specific_force(*asked) for name, one in off.items()}
    axes = {}
    for place, axis in enumerate(AXES):
        tilt = {name: float(one[place]) for name, one in tilts.items()}
        force = float(specific_force(*asked)[place])
        axes[axis] = simulate_accelerometer(specimen(device, chosen.seed, axis), axis, tilt, force_g=force, **settings)
    angles = {name: (float((asked + one)[0]), float((asked + one)[1])) for name, one in off.items()}
    return Alignment(pitch_deg, roll_deg, axes, angles)
