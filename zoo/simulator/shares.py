"""How much each effect adds to the error: parameters drawn, scaled and applied to every run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.effects.base import Effect
from zoo.errors import InputError
from zoo.simulator.device import Device
from zoo.simulator.draws import Scene, draw_amplitude, draw_direction, draw_shape, given_values, shape_parameters
from zoo.simulator.plant import Scenario
from zoo.simulator.streams import stream, uniform

BLOCK_S = 100.0
LEAST_NOISES, MOST_NOISES = 1.0, 4.0


@dataclass(frozen=True, eq=False)
class Share:
    """One effect with the numbers it has in this gyro.

    Attributes:
        effect: its columns.
        shape: (S,) shape parameters.
        amplitude: (K,) amplitudes.
        rms: root mean square of what it adds over the fitted runs, about its mean [output's unit].
    """

    effect: Effect
    shape: Tensor
    amplitude: Tensor
    rms: float

    def __call__(self, run: Scenario) -> Tensor:
        """(T,) its part of the error in one run [output's unit]."""
        return run.columns(self.effect, self.shape) @ self.amplitude

    def parameters(self) -> dict[str, tuple[float, str]]:
        """Every parameter's value and unit."""
        shapes = zip(shape_parameters(self.effect), self.shape.tolist(), strict=True)
        sizes = zip(self.effect.amplitudes, self.amplitude.tolist(), strict=True)
        return {one.name: (value, one.unit.replace("unit", "°/h")) for one, value in (*shapes, *sizes)}


def white_block_noise(device: Device) -> float:
    """White noise of 100 s means [°/h], 60·N/√100; the device's own N, also where the noise is off."""
    return float(60.0 * device["random_walk"] / BLOCK_S**0.5)


def share(
    name: str, effect: Effect, device: Device, runs: Sequence[Scenario], seed: int, given: Mapping[str, float], rms: float | None, hidden: bool
) -> Share:
    """Draw an effect's parameters.

    An effect that is present gets amplitudes from the spread of the gyro's class. A hidden one, or one that the class has no numbers for, is
    scaled so that what it adds over the fitted runs has a given RMS about its mean; a constant would only look like another bias.

    Args:
        name: the effect's.
        effect: its columns.
        device: the gyro.
        runs: the runs that will be fitted.
        seed: the user's.
        given: the user's own values by parameter; with one of the amplitudes given nothing is scaled.
        rms: RMS wanted [output's unit]; None draws between one and four times the white noise of 100 s means.
        hidden: whether it is to be scaled in any case.

    Raises:
        InputError: see `given_values`; an effect that is to be scaled and leaves no trace in these runs.
    """
    scene = Scene(len(runs), min(float(run.time[-1]) for run in runs), *_range(runs))
    shape = given_values(draw_shape(name, effect, scene, seed), shape_parameters(effect), given, name)
    columns = torch.cat([run.columns(effect, shape) for run in runs])
    columns = columns - columns.mean(0)
    known = draw_amplitude(name, effect, device, seed)
    raw = draw_direction(name, columns.square().mean(0).sqrt(), seed) if known is None else known
    amplitude = given_values(raw, effect.amplitudes, given, name)
    size = float((columns @ amplitude).square().mean().sqrt())
    if (known is None or hidden) and not any(one.name in given for one in effect.amplitudes):
        wanted = white_block_noise(device) * _noises(name, seed) if rms is None else rms
        if size <= 1e-9 * float(amplitude.norm()):
            raise InputError(f"effect '{name}' leaves no trace in these runs; choose a profile that moves, or give parameters.{name}")
        amplitude, size = amplitude * (wanted / size), wanted
    return Share(effect, shape, amplitude, size)


def _range(runs: Sequence[Scenario]) -> tuple[float, float]:
    coil = torch.cat([run.heat.coil for run in runs])
    return float(coil.min()), float(coil.max())


def _noises(name: str, seed: int) -> float:
    return LEAST_NOISES + (MOST_NOISES - LEAST_NOISES) * uniform(stream(seed, "size", name))


def choose_hidden(
    hidden: int | str | Sequence[str], present: Mapping[str, Effect], catalogue: Mapping[str, Effect], inputs: Sequence[str], seed: int
) -> list[str]:
    """Names of the effects that the gyro has and the user is not told.

    Args:
        hidden: how many, or which.
        present: effects it has anyway.
        catalogue: what can be drawn from.
        inputs: recorded columns there are; an effect that needs another one cannot be drawn.
        seed: the user's.

    Raises:
        InputError: an unknown or present name, a name twice, a number that is negative or more than there are.
    """
    if isinstance(hidden, (str, Sequence)):
        return _named([hidden] if isinstance(hidden, str) else list(hidden), present, catalogue)
    possible = [name for name in sorted(catalogue) if name not in present and set(catalogue[name].needs) <= set(inputs)]
    if isinstance(hidden, bool) or not isinstance(hidden, int) or not 0 <= hidden <= len(possible):
        raise InputError(f"hidden={hidden}: 0 to {len(possible)} are possible, or a name, or a list of names: {', '.join(possible)}")
    order = torch.randperm(len(possible), generator=stream(seed, "hidden"))[:hidden]
    return [possible[place] for place in order.tolist()]


def _named(names: list[str], present: Mapping[str, Effect], catalogue: Mapping[str, Effect]) -> list[str]:
    possible = [name for name in sorted(catalogue) if name not in present]
    for name in names:
        if name in present:
            raise InputError(f"hidden={name}: is one of effects=[{','.join(present)}] already; possible: {', '.join(possible)}")
        if name not in catalogue:
            raise InputError(f"hidden={name}: no such effect; possible: a number, or of {', '.join(possible)}")
    if len(set(names)) < len(names):
        raise InputError(f"hidden={names}: a name occurs twice")
    return names
