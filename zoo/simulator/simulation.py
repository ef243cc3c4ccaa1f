"""A gyro's campaign: its runs, and all that is true of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from zoo.simulator.gyros.device import Device
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.noise import Noise
from zoo.simulator.recorded import Recorded
from zoo.simulator.settings import Settings
from zoo.simulator.shares import Share
from zoo.simulator.simulated import heading, recorded_runs, valued
from zoo.simulator.thermal.winding_weights import coil_weight, strain_per_k

UNITS = {
    "random_walk": "°/√h",
    "flicker": "°/h",
    "rate_random_walk": "°/h/√h",
    "angle_step_arcsec": "arcsec",
    "thermometer_c": "K",
    "resolution_c": "K",
    "cold_loss_db": "dB",
    "rate_ramp": "°/h/h",
}
SETTING_UNITS = {"sample_s": "s", "reference_dph": "°/h"}


@dataclass(frozen=True, eq=False)
class Simulation:
    """A gyro's campaign, a `Simulated`.

    Attributes:
        device: the gyro.
        shares: its effects, the hidden ones last.
        hidden: names of the hidden ones.
        noise: coefficients that it had.
        runs: runs to be fitted.
        check: the run on another program.
        settings: how it was run.
        chamber: where.
    """

    kind: ClassVar[str] = "gyro"
    unit: ClassVar[str] = "dph"

    device: Device
    shares: dict[str, Share]
    hidden: tuple[str, ...]
    noise: Noise
    runs: list[Recorded]
    check: Recorded
    settings: Settings
    chamber: Chamber

    @property
    def name(self) -> str:
        """Its class."""
        return self.device.name

    @property
    def seed(self) -> int:
        """Which one of the class."""
        return self.device.seed

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the effects that were asked for."""
        return tuple(name for name in self.shares if name not in self.hidden)

    def truth(self) -> dict[str, Any]:
        """Everything that a fit could be asked to find, each number with its unit."""
        device = self.device
        sensors = [
            {"place": place, "time_constant": valued(tau, "s"), "offset": valued(offset, "K")}
            for place, (tau, offset) in zip(self.settings.places, device.sensors, strict=True)
        ]
        return {
            **heading(self),
            "parameters": {name: {one: valued(*value) for one, value in share.parameters().items()} for name, share in self.shares.items()},
            "rms": {name: valued(share.rms, "°/h") for name, share in self.shares.items()},
            "noise": {key: valued(value or 0.0, UNITS[key]) for key, value in vars(self.noise).items()},
            "device": {key: valued(*value) for key, value in device.described().items()},
            "winding": self._winding(),
            "thermometers": sensors,
            "settings": self._settings(),
            **recorded_runs(self),
        }

    def _settings(self) -> dict[str, Any]:
        settings = self.settings
        units = {key: valued(getattr(settings, key), unit) for key, unit in SETTING_UNITS.items()}
        earth = {"latitude_deg": settings.latitude_deg, "axis": settings.axis, "constant_rate": valued(settings.constant_rate, "°/h")}
        return {**units, **earth, "cold_start": settings.cold_start, "heat": settings.heat, "chamber": vars(self.chamber)}

    def _winding(self) -> dict[str, Any]:
        """How the coil is wound, and how sensitive that makes it."""
        gyro, mohr = self.device.gyro, self.shares.get("mohr")
        needed = strain_per_k(self.device, float(mohr.amplitude[0])) if mohr else None
        strain = {} if needed is None else {"strain_for_mohr": valued(needed, "1/K")}
        design = {"layers": gyro.layers, "turns": gyro.turns, "pattern": gyro.pattern}
        return {**design, "shupe_weight": valued(coil_weight(self.device), "°/h/(K/min)"), **strain}
