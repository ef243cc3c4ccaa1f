"""What happens in the gyro during one run, before any instrument looks at it."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.effects.base import Effect, History
from zoo.effects.shupe import Shupe
from zoo.simulator.device import Device
from zoo.simulator.heat import Heat, heat, weights
from zoo.simulator.inputs import recorded_inputs
from zoo.simulator.program import Program


@dataclass(frozen=True, eq=False)
class Scenario:
    """One run's true state.

    Attributes:
        label: number of the run, counted from 1, or ``"check"``.
        program: what the chamber was asked for.
        time: (T,) [s].
        heat: temperatures.
        places: the history at ``"coil"`` and ``"housing"``.
        layer_bend: shape of the winding's weights.
    """

    label: int | str
    program: Program
    time: Tensor
    heat: Heat
    places: dict[str, History]
    layer_bend: float

    @property
    def inputs(self) -> dict[str, Tensor]:
        """Recorded inputs by column, each (T,)."""
        return self.places["coil"].inputs

    def columns(self, effect: Effect, shape: Tensor) -> Tensor:
        """(T, K) columns of an effect at the true temperatures of its place.

        Shupe's effect has its own: the rates of the layers [K/min] through the winding's weights, where the effect in a model knows only the
        coil's mean temperature.
        """
        if isinstance(effect, Shupe):
            return (self.heat.rates[:, 1:-1] @ weights(self.layer_bend)).unsqueeze(-1)
        return effect.columns(self.places[effect.place], shape)


def scenario(
    device: Device, program: Program, label: int | str, seed: int, sample_s: float, chamber_s: float, cold_start: bool, reference: float
) -> Scenario:
    """Run a chamber program.

    Args:
        device: the gyro.
        program: what the chamber is asked for.
        label: number of the run, or ``"check"``.
        seed: the user's.
        sample_s: sampling step [s].
        chamber_s: time constant of the chamber's air [s].
        cold_start: switched on at the first sample; otherwise long before.
        reference: true input [output's unit].
    """
    time = torch.arange(int(program.seconds / sample_s + 1e-9) + 1, dtype=torch.float64) * sample_s
    air = program.air(time, chamber_s)
    body = heat(device, time, air, cold_start)
    inputs = recorded_inputs(time, sample_s, seed, label)
    # The check run is none of the numbered ones: what happened once, in one of those, does not happen in it.
    number = label if isinstance(label, int) else -1
    rest = (body.spool, torch.full_like(time, reference), inputs, number)
    coil = History(time, body.coil, body.coil_rate, body.housing - body.coil, *rest)
    housing = History(time, body.housing, body.rates[:, 0], air - body.housing, *rest)
    return Scenario(label, program, time, body, {"coil": coil, "housing": housing}, device["bend"])
