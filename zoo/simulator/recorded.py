"""What a run of a gyro looks like through its instruments."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.simulator.gyros.device import Device
from zoo.simulator.laboratory.program import Program
from zoo.simulator.noise import Noise, counted, flicker, loss_factor, rate_ramp, rate_walk, white
from zoo.simulator.plant import Scenario
from zoo.simulator.streams import stream
from zoo.simulator.thermometers import readings


@dataclass(frozen=True, eq=False)
class Recorded:
    """One run as it is written.

    Attributes:
        name: ``"run_1"``, …, or ``"check"``.
        program: what the chamber was asked for.
        table: columns of the measurement file, each (T,).
        truth: columns of the truth, each (T,): ``time_s``, ``<effect>_dph`` for each effect, ``sum_dph``, ``temperature_coil_c``.
    """

    name: str
    program: Program
    table: dict[str, Tensor]
    truth: dict[str, Tensor]

    @property
    def error(self) -> Tensor:
        """(T,) output − reference [°/h]."""
        return self.table["rate_dph"] - self.table["reference_dph"]

    @property
    def noise(self) -> Tensor:
        """(T,) what the output has besides the reference and the effects [°/h]."""
        return self.error - self.truth["sum_dph"]


def levels(noise: Noise, device: Device) -> Noise:
    """The coefficients asked for, and the device's own where none were."""
    return Noise(**{key: device[key] if value is None else value for key, value in vars(noise).items()})


def record(run: Scenario, row: int, parts: Mapping[str, Tensor], noise: Noise) -> Recorded:
    """Look at a run of one device through its instruments.

    Args:
        run: what went on in several devices.
        row: which of them it is.
        parts: (T,) what each effect adds [°/h].
        noise: coefficients, none of them None.
    """
    time, coil, seed = run.time.cpu(), run.heat.coil[row].cpu(), run.devices[row].seed
    if bool(run.fan.any()):
        parts = {**parts, "fan": run.fan.cpu()}
    total = torch.stack([torch.zeros_like(time), *parts.values()]).sum(0)
    reference = run.reference.cpu().expand_as(time)
    rate = reference + total + output_noise(noise, coil, run.sample_s, seed, run.label)
    rate = counted(rate, noise.angle_step_arcsec, run.sample_s, stream(seed, "angle", run.label))
    inputs = {name: value[row].cpu() for name, value in run.inputs.items()}
    thermometers = readings(run.devices[row], run, row, run.places, noise)
    table = {"time_s": time, **thermometers, "rate_dph": rate, "reference_dph": reference, **inputs}
    truth = {"time_s": time, **{f"{name}_dph": part for name, part in parts.items()}, "sum_dph": total, "temperature_coil_c": coil}
    return Recorded("check" if run.label == "check" else f"run_{run.label}", run.program, table, truth)


def output_noise(noise: Noise, coil_c: Tensor, step_s: float, seed: int, label: int | str) -> Tensor:
    """(T,) sum of the random processes and of the rate ramp [°/h], each from its own stream; white noise by the coil's temperature."""
    count = len(coil_c)
    made = [
        white(noise.random_walk or 0.0, count, step_s, stream(seed, "white", label), loss_factor(coil_c, noise.cold_loss_db or 0.0)),
        flicker(noise.flicker or 0.0, count, step_s, stream(seed, "flicker", label)),
        rate_walk(noise.rate_random_walk or 0.0, count, step_s, stream(seed, "rate_walk", label)),
        rate_ramp(noise.rate_ramp, count, step_s),
    ]
    return torch.stack(made).sum(0)
