"""What happens in gyros during one run, before any instrument looks at it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import torch
from torch import Tensor

from zoo.effects.base import Effect, History
from zoo.effects.mohr import Mohr
from zoo.effects.shupe import Shupe
from zoo.simulator.gyros.device import Device
from zoo.simulator.inputs import recorded_inputs
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.laboratory.program import Program
from zoo.simulator.settings import Settings
from zoo.simulator.streams import stream
from zoo.simulator.thermal.heat import Heat, heat


@dataclass(frozen=True, eq=False)
class Scenario:
    """One run's true state in B devices of one design.

    Attributes:
        label: number of the run, counted from 1, or ``"check"``.
        program: what the chamber was asked for.
        time: (T,) [s].
        devices: B gyros.
        heat: temperatures.
        reference: (T,) true rate [°/h].
        inputs: recorded inputs by column, each (B, T).
        fan: (T,) share of the chamber's fan in the output [°/h].
        places: where the thermometers sit.
        sample_s: from row to row [s].
    """

    label: int | str
    program: Program
    time: Tensor
    devices: tuple[Device, ...]
    heat: Heat
    reference: Tensor
    inputs: dict[str, Tensor]
    fan: Tensor
    places: tuple[str, ...]
    sample_s: float

    def history(self, place: str) -> History:
        """What an effect sees that lives at ``"coil"`` or ``"housing"``."""
        body = self.heat
        # The check run is none of the numbered ones: what happened once, in one of those, does not happen in it.
        rest = (body.at(self.places[0]), self.reference, self.inputs, self.label if isinstance(self.label, int) else -1)
        if place == "coil":
            return History(self.time, body.coil, body.coil_rate, body.housing - body.coil, *rest)
        return History(self.time, body.housing, body.housing_rate, body.air - body.housing, *rest)

    def columns(self, effect: Effect, shape: Tensor) -> Tensor:
        """(B, T, K) columns of an effect at the true temperatures of its place, for shapes (B, S).

        Shupe's and Mohr's effect are integrals over the winding here, where a model knows only the coil's mean temperature.
        """
        if isinstance(effect, Shupe | Mohr):
            return (self.heat.shupe if isinstance(effect, Shupe) else self.heat.mohr).unsqueeze(-1)
        columns = effect.columns(self.history(effect.place), shape.to(self.time))
        return columns.expand(len(self.devices), *columns.shape[-2:])

    def of(self, which: Sequence[int]) -> Scenario:
        """The same run in some of the devices."""
        if list(which) == list(range(len(self.devices))):
            return self
        places = list(which)
        body = {one.name: getattr(self.heat, one.name) for one in fields(Heat)}
        chosen = Heat(**{name: value[places] if value.dim() > 1 else value for name, value in body.items()})
        inputs = {name: value[places] for name, value in self.inputs.items()}
        return replace(self, devices=tuple(self.devices[place] for place in places), heat=chosen, inputs=inputs)


def air_of(device: Device, program: Program, label: int | str, chamber: Chamber, clock: Tensor) -> Tensor:
    """(T,) air of a device's chamber in one run [°C], at times (T,) [s] on the CPU."""
    return chamber.air(program, clock, stream(device.seed, "chamber", label))


def scenario(devices: Sequence[Device], program: Program, label: int | str, chamber: Chamber, settings: Settings) -> Scenario:
    """Run a chamber program.

    Args:
        devices: B gyros of one design; each has the chamber to itself.
        program: what the chamber is asked for.
        label: number of the run, or ``"check"``.
        chamber: how its air follows.
        settings: how the run is recorded.
    """
    count = int(program.seconds / settings.sample_s + 1e-9) + 1
    clock = torch.arange(count, dtype=torch.float64) * settings.sample_s
    time = clock.to(settings.torch_device)
    air = torch.stack([air_of(device, program, label, chamber, clock) for device in devices]).to(time)
    alike = air[:1].expand_as(air).equal(air)
    inputs = [recorded_inputs(clock, settings.sample_s, device.seed, label) for device in devices]
    return Scenario(
        label=label,
        program=program,
        time=time,
        devices=tuple(devices),
        heat=heat(devices, time, air[0] if alike else air, settings.cold_start, settings.heat, float(program.asked(clock[:1]))),
        reference=(settings.constant_rate + program.rate(clock, settings.sample_s)).to(time),
        inputs={name: torch.stack([one[name] for one in inputs]).to(time) for name in inputs[0]},
        fan=(chamber.fan_dph * chamber.fan_on(program, clock)).to(time),
        places=settings.places,
        sample_s=settings.sample_s,
    )
