"""A gyro in a chamber: runs as tables, with the truth beside them. Nothing is written here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from zoo.effects.base import Effect
from zoo.errors import InputError
from zoo.simulator.device import Device, draw
from zoo.simulator.draws import check_given
from zoo.simulator.gyro_class import GyroClass
from zoo.simulator.inputs import NAMES
from zoo.simulator.noise import Noise, counted, flicker, rate_walk, white
from zoo.simulator.plant import Scenario, scenario
from zoo.simulator.program import Campaign
from zoo.simulator.settings import Settings
from zoo.simulator.shares import Share, choose_hidden, share
from zoo.simulator.streams import stream
from zoo.simulator.thermometers import readings


@dataclass(frozen=True, eq=False)
class Recorded:
    """One run as it is written.

    Attributes:
        name: ``"run_1"``, …, or ``"check"``.
        table: columns of the measurement file, each (T,).
        truth: columns of the truth, each (T,): ``time_s``, ``<effect>_dph`` for each effect, ``sum_dph``, ``temperature_coil_c``.
        scenario: what went on.
    """

    name: str
    table: dict[str, Tensor]
    truth: dict[str, Tensor]
    scenario: Scenario

    @property
    def noise(self) -> Tensor:
        """(T,) what the output has besides the reference and the effects [°/h]."""
        return self.table["rate_dph"] - self.table["reference_dph"] - self.truth["sum_dph"]


@dataclass(frozen=True, eq=False)
class Simulation:
    """A gyro's campaign.

    Attributes:
        device: the gyro.
        shares: its effects, the hidden ones last.
        hidden: names of the hidden ones.
        noise: coefficients N, B, K that it had.
        runs: runs to be fitted.
        check: the run on another program.
        settings: how it was run.
    """

    device: Device
    shares: dict[str, Share]
    hidden: tuple[str, ...]
    noise: Noise
    runs: list[Recorded]
    check: Recorded
    settings: Settings

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the effects that were asked for."""
        return tuple(name for name in self.shares if name not in self.hidden)


def simulate(
    gyro: GyroClass,
    profile: Campaign,
    effects: Mapping[str, Effect],
    noise: Noise | None = None,
    hidden: int | str | Sequence[str] = 0,
    catalogue: Mapping[str, Effect] | None = None,
    parameters: Mapping[str, Mapping[str, float]] | None = None,
    **settings: Any,
) -> Simulation:
    """Simulate a gyro's runs.

    Args:
        gyro: class that the gyro is drawn from.
        profile: chamber program of each run.
        effects: what its error is made of, by name; only their columns are used, none is changed.
        noise: coefficients to change; `SILENT` for none.
        hidden: how many more effects to draw from the catalogue, or which.
        catalogue: effects by name that can be hidden.
        parameters: values to set instead of drawing them, by effect and parameter.
        **settings: `Settings`, such as ``runs=3, seed=1, sample_s=10.0``.

    Raises:
        InputError: whatever is absurd, see `Settings`, `Program`, `choose_hidden` and `check_given`.
    """
    chosen = Settings(**settings)
    chosen.check_programs(profile)
    device = draw(gyro, chosen.seed, chosen.thermometers)
    level = levels(noise or Noise(), device)
    names = tuple(choose_hidden(hidden, effects, catalogue or {}, NAMES, chosen.seed))
    all_effects = {**effects, **{name: (catalogue or {})[name] for name in names}}
    given = parameters or {}
    check_given(given, all_effects)
    _check_needs(all_effects)
    with torch.no_grad():
        runs = [_scenario(device, profile, number, chosen) for number in range(1, chosen.runs + 1)]
        check = _scenario(device, profile, "check", chosen)
        shares = {
            name: share(name, effect, device, runs, chosen.seed, given.get(name, {}), chosen.amplitude, name in names)
            for name, effect in all_effects.items()
        }
        recorded = [record(run, device, shares, level, chosen) for run in (*runs, check)]
    return Simulation(device, shares, names, level, recorded[:-1], recorded[-1], chosen)


def _check_needs(effects: Mapping[str, Effect]) -> None:
    for name, effect in effects.items():
        missing = [column for column in effect.needs if column not in NAMES]
        if missing:
            raise InputError(f"effect '{name}' needs the column {', '.join(missing)}; the simulator records {', '.join(NAMES)}")


def _scenario(device: Device, profile: Campaign, label: int | str, chosen: Settings) -> Scenario:
    program = profile.of(label) if isinstance(label, int) else profile.check
    return scenario(device, program, label, chosen.seed, chosen.sample_s, chosen.chamber_s, chosen.cold_start, chosen.reference_dph)


def levels(noise: Noise, device: Device) -> Noise:
    """The coefficients asked for, and the device's own where none were."""
    own = {key: device[key] for key in ("random_walk", "flicker", "rate_random_walk")}
    return Noise(**{**vars(noise), **{key: value for key, value in own.items() if getattr(noise, key) is None}})


def record(run: Scenario, device: Device, shares: Mapping[str, Share], noise: Noise, chosen: Settings) -> Recorded:
    """Look at a run through the gyro's instruments.

    Args:
        run: what went on.
        device: the gyro.
        shares: its effects.
        noise: coefficients, none of them None.
        chosen: how it is recorded.
    """
    parts = {name: one(run) for name, one in shares.items()}
    total = torch.stack([torch.zeros_like(run.time), *parts.values()]).sum(0)
    reference = run.places["coil"].reference
    rate = reference + total + output_noise(noise, len(run.time), chosen, run.label)
    rate = counted(rate, noise.angle_step_arcsec, chosen.sample_s, stream(chosen.seed, "angle", run.label))
    thermometers = readings(device, run.time, run.heat, noise, chosen.seed, run.label)
    table = {"time_s": run.time, **thermometers, "rate_dph": rate, "reference_dph": reference, **run.inputs}
    truth = {"time_s": run.time, **{f"{name}_dph": part for name, part in parts.items()}, "sum_dph": total, "temperature_coil_c": run.heat.coil}
    return Recorded("check" if run.label == "check" else f"run_{run.label}", table, truth, run)


def output_noise(noise: Noise, count: int, chosen: Settings, label: int | str) -> Tensor:
    """(count,) sum of the three random processes [°/h], each from its own stream."""
    kinds = {white: noise.random_walk, flicker: noise.flicker, rate_walk: noise.rate_random_walk}
    return torch.stack([kind(size or 0.0, count, chosen.sample_s, stream(chosen.seed, kind.__name__, label)) for kind, size in kinds.items()]).sum(0)
