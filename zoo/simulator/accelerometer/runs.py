"""An accelerometer at rest, powered on in the cold: pulses and temperature of every count, with the truth beside them. Nothing is written here."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.simulator.accelerometer.beams import beam_temperatures, drift_pulses, expected_pulses, over_gate
from zoo.simulator.accelerometer.power_on import PowerOn
from zoo.simulator.accelerometer.preset import HUI2016, PARAMETERS, Accelerometer
from zoo.simulator.laboratory.program import Campaign, Program
from zoo.simulator.noise import counted
from zoo.simulator.simulated import heading, recorded_runs, valued
from zoo.simulator.streams import normal, stream

MICRO = 1e-6
SETTING_UNITS = {"sample_s": "s", "force_g": "g"}


@dataclass(frozen=True, eq=False)
class PowerOnRun:
    """One power-on as it is written.

    Attributes:
        name: ``"run_1"``, …, or ``"check"``.
        program: the soak that it begins from, and its length.
        table: ``time_s`` (end of each count), ``temperature_c`` (mean of the beams), ``pulses``, ``reference_pulses``, each (T,).
        truth: ``time_s``, ``<cause>_pulses`` for each cause, ``sum_pulses``, ``temperature_pulled_c``, ``temperature_pressed_c``, each (T,).
    """

    name: str
    program: Program
    table: dict[str, Tensor]
    truth: dict[str, Tensor]

    @property
    def error(self) -> Tensor:
        """(T,) output − reference [pulses]."""
        return self.table["pulses"] - self.table["reference_pulses"]

    @property
    def noise(self) -> Tensor:
        """(T,) what the output has besides the reference and the causes [pulses]."""
        return self.error - self.truth["sum_pulses"]


@dataclass(frozen=True, eq=False)
class PowerOnRuns:
    """Power-ons of one accelerometer, a `Simulated`.

    Attributes:
        device: the accelerometer.
        runs: to be fitted.
        check: one more, for checking.
        settings: how they were recorded, but for the soak and the length of each.
    """

    kind: ClassVar[str] = "accelerometer"
    unit: ClassVar[str] = "pulses"
    hidden: ClassVar[tuple[str, ...]] = ()

    device: Accelerometer
    runs: list[PowerOnRun]
    check: PowerOnRun
    settings: PowerOn

    @property
    def name(self) -> str:
        """Its make."""
        return self.device.name

    @property
    def seed(self) -> int:
        """Which chances it had."""
        return self.settings.seed

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the causes of its error."""
        return tuple(key.removesuffix("_pulses") for key in self.check.truth if key.endswith("_pulses") and key != "sum_pulses")

    def truth(self) -> dict[str, Any]:
        """Everything that a fit could be asked to find, each number with its unit."""
        device = {key: getattr(self.device, key) for key in PARAMETERS}
        return {
            **heading(self),
            "device": {key: {**valued(one.value, one.unit), "source": one.source} for key, one in device.items()},
            "settings": {key: valued(getattr(self.settings, key), unit) for key, unit in SETTING_UNITS.items()},
            **recorded_runs(self),
        }


def simulate_accelerometer(
    device: Accelerometer = HUI2016, place: str = "", tilt: Mapping[str, float] | None = None, profile: Campaign | None = None, **settings: Any
) -> PowerOnRuns:
    """Simulate an accelerometer that is powered on in the cold, again and again.

    Args:
        device: the accelerometer.
        place: where it sits in its unit; each place has chances of its own.
        tilt: by how much more than `force_g` it feels in a run, because its fixture is not where it should be [g], by the run's name.
        profile: soak and length of each run, as constant temperatures of the chamber; None: those of the settings.
        **settings: `PowerOn`, such as ``runs=1, seed=1, soak_c=-40.0``.

    Raises:
        InputError: whatever is absurd, see `PowerOn` and `PowerOn.on`, or a force that the difference of frequency cannot show.
    """
    chosen = PowerOn(**settings)
    least = -device["offset"] / device["scale"]
    if chosen.force_g <= least:
        raise InputError(f"force_g={chosen.force_g:g}: the two beams would change places; above {least:g} g (-offset/scale) is possible")
    programs = profile or chosen.campaign
    asked = {f"run_{number}": programs.of(number) for number in range(1, chosen.runs + 1)} | {"check": programs.check}
    recorded = [_record(device, name, place, (tilt or {}).get(name), program, chosen.on(program)) for name, program in asked.items()]
    return PowerOnRuns(device, recorded[:-1], recorded[-1], chosen)


def _record(device: Accelerometer, name: str, place: str, tilt_g: float | None, program: Program, chosen: PowerOn) -> PowerOnRun:
    gate, labels = chosen.sample_s, (place, name)
    ends = gate * torch.arange(1, chosen.counts + 1, dtype=torch.float64)
    beams = beam_temperatures(device, chosen.soak_c, ends, gate)
    pulled, pressed = over_gate(beams)
    causes = drift_pulses(device, beams, chosen.force_g, gate) | _constant_pulses(device, tilt_g, chosen, labels)
    total = torch.stack([*causes.values()]).sum(0)
    reference = torch.full_like(ends, expected_pulses(device, chosen.force_g, gate))
    named = {f"{cause}_pulses": part for cause, part in causes.items()}
    truth = {"time_s": ends, **named, "sum_pulses": total, "temperature_pulled_c": pulled, "temperature_pressed_c": pressed}
    temperature = (pulled + pressed) / 2 + device["thermometer"] * normal(len(ends), stream(chosen.seed, "thermometer", *labels))
    pulses = _counted(device, reference + total, chosen, labels)
    return PowerOnRun(name, program, {"time_s": ends, "temperature_c": temperature, "pulses": pulses, "reference_pulses": reference}, truth)


def _constant_pulses(device: Accelerometer, tilt_g: float | None, chosen: PowerOn, labels: tuple[str, str]) -> dict[str, Tensor]:
    """(T,) what is another at every power-on and the same in all its counts, by cause."""
    bias_g = MICRO * device["repeatability"] * float(normal(1, stream(chosen.seed, "repeatability", *labels)))
    forces = {"bias_repeatability": bias_g} | ({} if tilt_g is None else {"fixture_rotation": tilt_g})
    return {cause: torch.full((chosen.counts,), chosen.sample_s * device["scale"] * force, dtype=torch.float64) for cause, force in forces.items()}


def _counted(device: Accelerometer, pulses: Tensor, chosen: PowerOn, labels: tuple[str, str]) -> Tensor:
    """(T,) with the random walk of the phase, in the counter's steps."""
    size = math.sqrt(chosen.sample_s) * device["scale"] * MICRO * device["random_walk"]
    walk = size * normal(len(pulses), stream(chosen.seed, "pulses", *labels))
    return counted(pulses + walk, device["count_step"], 1.0, stream(chosen.seed, "count", *labels))
