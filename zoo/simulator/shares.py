"""How much each effect adds to the error: parameters drawn, scaled and applied to every run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.effects.base import Effect
from zoo.errors import InputError, nearest
from zoo.scoring.stages import rms
from zoo.simulator.draws import Scene, draw_amplitude, draw_direction, draw_shape, given_values, shape_parameters
from zoo.simulator.gyros.device import Device
from zoo.simulator.plant import Scenario
from zoo.simulator.streams import stream, uniform

BLOCK_S = 100.0
LEAST_NOISES, MOST_NOISES = 1.0, 4.0
LEAST_VISIBLE = 0.02
"""Smallest share of a hidden effect, by RMS, that counts as visible: one that the others could take up is made no more than fifty times larger."""


@dataclass(frozen=True, eq=False)
class Share:
    """One effect with the numbers it has in one gyro.

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

    def parameters(self) -> dict[str, tuple[float, str]]:
        """Every parameter's value and unit."""
        shapes = zip(shape_parameters(self.effect), self.shape.tolist(), strict=True)
        sizes = zip(self.effect.amplitudes, self.amplitude.tolist(), strict=True)
        return {one.name: (value, one.unit.replace("unit", "°/h")) for one, value in (*shapes, *sizes)}


@dataclass(frozen=True, eq=False)
class Drawing:
    """How the parameters of an effect are drawn.

    Attributes:
        given: the user's own values by effect and parameter.
        rms: what each hidden effect should add beyond the others [output's unit]; None: 1 to 4 times the white noise of 100 s means.
    """

    given: Mapping[str, Mapping[str, float]]
    rms: float | None


def contribution(run: Scenario, shares: Sequence[Share]) -> Tensor:
    """(B, T) an effect's part of the error in one run [output's unit], for its share in each of the run's devices."""
    shape, amplitude = (torch.stack([getattr(one, key) for one in shares]).to(run.time) for key in ("shape", "amplitude"))
    return (run.columns(shares[0].effect, shape) @ amplitude.unsqueeze(-1)).squeeze(-1)


def white_block_noise(device: Device) -> float:
    """White noise of 100 s means [°/h], 60·N/√100; the device's own N, also where the noise is off."""
    return float(60.0 * device["random_walk"] / BLOCK_S**0.5)


def draw_shares(name: str, effect: Effect, runs: Sequence[Scenario], drawing: Drawing, beside: Tensor | None = None) -> list[Share]:
    """An effect's share in each of B devices.

    An effect that is present gets amplitudes from the spread of the gyro's class. A hidden one, or one that the class has no numbers for, is
    scaled by what of it stays visible over the fitted runs: what the columns of the others cannot take up.

    Args:
        name: the effect's.
        effect: its columns.
        runs: the runs that will be fitted, all with the same B devices.
        drawing: what the user asked for.
        beside: (B, T, M) columns of the effects that are present, over all runs; None for one that is present itself.

    Raises:
        InputError: see `given_values`; an effect that is to be scaled and leaves no trace in these runs.
    """
    devices, given = runs[0].devices, drawing.given.get(name, {})
    seconds, slow = min(float(run.time[-1]) for run in runs), _slow(runs)
    scenes = [Scene(len(runs), seconds, *_range(runs, row), slow) for row in range(len(devices))]
    shapes = [_shape(name, effect, device, scene, given) for device, scene in zip(devices, scenes, strict=True)]
    columns = torch.cat([run.columns(effect, torch.stack(shapes)) for run in runs], dim=-2).cpu()
    columns = columns - columns.mean(-2, keepdim=True)
    shares = []
    for row, (device, shape) in enumerate(zip(devices, shapes, strict=True)):
        amplitude, size, free = _amplitude(name, effect, device, columns[row], given)
        if (beside is not None or free) and not any(one.name in given for one in effect.amplitudes):
            wanted = white_block_noise(device) * _noises(name, device.seed) if drawing.rms is None else drawing.rms
            if size <= 1e-9 * float(amplitude.norm()):
                raise InputError(f"effect '{name}' leaves no trace in these runs; choose a profile that moves or turns, or give parameters.{name}")
            larger = wanted / max(_visible(columns[row] @ amplitude, None if beside is None else beside[row]), LEAST_VISIBLE * size)
            amplitude, size = amplitude * larger, size * larger
        shares.append(Share(effect, shape, amplitude, size))
    return shares


def _shape(name: str, effect: Effect, device: Device, scene: Scene, given: Mapping[str, float]) -> Tensor:
    return given_values(draw_shape(name, effect, scene, device.seed), shape_parameters(effect), given, name)


def _amplitude(name: str, effect: Effect, device: Device, columns: Tensor, given: Mapping[str, float]) -> tuple[Tensor, float, bool]:
    """Amplitudes (K,), the RMS of what they make of the columns (T, K), and whether nobody has numbers for them."""
    known = draw_amplitude(name, effect, device)
    raw = draw_direction(name, columns.square().mean(0).sqrt(), device.seed) if known is None else known
    amplitude = given_values(raw, effect.amplitudes, given, name)
    return amplitude, rms(columns @ amplitude), known is None


def _visible(part: Tensor, beside: Tensor | None) -> float:
    """RMS of (T,) that the columns (T, M) and a constant leave."""
    if beside is not None and beside.shape[-1]:
        centred = beside - beside.mean(0)
        scaled = centred / centred.square().mean(0).sqrt().clamp_min(1e-300)
        part = part - scaled @ torch.linalg.lstsq(scaled, part.unsqueeze(-1), driver="gelsd").solution.squeeze(-1)
    return rms(part)


def _range(runs: Sequence[Scenario], row: int) -> tuple[float, float]:
    coil = torch.cat([run.heat.coil[row] for run in runs])
    return float(coil.min()), float(coil.max())


def _slow(runs: Sequence[Scenario]) -> float:
    """True rate [°/h] that all but a tenth of the turning is faster than; 0 where nothing turns."""
    rates = torch.cat([run.reference.abs() for run in runs])
    turning = rates[rates > 0].sort().values
    return float(turning[len(turning) // 10]) if len(turning) else 0.0


def _noises(name: str, seed: int) -> float:
    return LEAST_NOISES + (MOST_NOISES - LEAST_NOISES) * uniform(stream(seed, "size", name))


def choose_hidden(
    hidden: int | str | Sequence[str], present: Mapping[str, Effect], catalogue: Mapping[str, Effect], inputs: Sequence[str], turned: bool, seed: int
) -> list[str]:
    """Names of the effects that the gyro has and the user is not told.

    Args:
        hidden: how many, or which.
        present: effects it has anyway.
        catalogue: what can be drawn from.
        inputs: recorded columns there are; an effect that needs another one cannot be drawn.
        turned: whether the true rate changes; an effect that needs that cannot be drawn otherwise.
        seed: the user's.

    Raises:
        InputError: an unknown or present name, a name twice, a number that is negative or more than there are.
    """
    if isinstance(hidden, (str, Sequence)):
        return _named([hidden] if isinstance(hidden, str) else list(hidden), present, catalogue)
    left = {name: effect for name, effect in sorted(catalogue.items()) if name not in present and set(effect.needs) <= set(inputs)}
    possible = [name for name, effect in left.items() if turned or not effect.needs_varied_reference]
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
            raise InputError(f"hidden={name}: no such effect, and no number (hidden=0 hides nothing); {nearest(name, possible)}")
    if len(set(names)) < len(names):
        raise InputError(f"hidden={names}: a name occurs twice")
    return names
