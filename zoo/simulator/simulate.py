"""Gyros in a chamber: runs as tables, with the truth beside them. Nothing is written here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import torch
from torch import Tensor

from zoo.effects.base import Effect
from zoo.effects.earlier import Before, before_each
from zoo.errors import InputError
from zoo.simulator.draws import check_given
from zoo.simulator.gyros.device import Device, draw
from zoo.simulator.gyros.gyro_class import GyroClass
from zoo.simulator.inputs import NAMES
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.laboratory.program import Campaign
from zoo.simulator.noise import Noise
from zoo.simulator.plant import Scenario, scenario
from zoo.simulator.recorded import levels, record
from zoo.simulator.settings import Settings
from zoo.simulator.shares import Drawing, Share, choose_hidden, contribution, draw_shares
from zoo.simulator.simulation import Simulation

AT_ONCE = 50
"""Devices computed in one batch; more gain nothing."""
ROWS_AT_ONCE = 2_000_000
"""Rows of all devices and runs in one batch, which bounds the memory: 0.3 GB a million."""
TURNS_AT_ONCE = 100_000
"""Turns with a temperature each in one batch: their shapes in the slow modes take a gigabyte."""


@dataclass(frozen=True, eq=False)
class Order:
    """What is to be simulated; see `simulate`."""

    gyro: GyroClass
    profile: Campaign
    effects: Mapping[str, Effect]
    noise: Noise
    hidden: int | str | Sequence[str]
    catalogue: Mapping[str, Effect]
    given: Mapping[str, Mapping[str, float]]
    chamber: Chamber
    settings: Settings


def simulate(*arguments: Any, **settings: Any) -> Simulation:
    """One gyro's runs; see `fleet`."""
    return next(fleet(*arguments, **settings))


def fleet(
    gyro: GyroClass,
    profile: Campaign,
    effects: Mapping[str, Effect],
    noise: Noise | None = None,
    hidden: int | str | Sequence[str] = 0,
    catalogue: Mapping[str, Effect] | None = None,
    parameters: Mapping[str, Mapping[str, float]] | None = None,
    chamber: Chamber | None = None,
    devices: int = 1,
    **settings: Any,
) -> Iterator[Simulation]:
    """Simulate the runs of many gyros of a class, some dozens at once; gyro k is the one that ``seed + k`` draws by itself.

    Args:
        gyro: class that the gyros are drawn from.
        profile: chamber program of each run.
        effects: what their error is made of, by name; only their columns are used, none is changed.
        noise: coefficients to change; `SILENT` for none.
        hidden: how many more effects to draw from the catalogue for each gyro, or which.
        catalogue: effects by name that can be hidden.
        parameters: values to set instead of drawing them, by effect and parameter.
        chamber: how the air follows the program.
        devices: how many gyros.
        **settings: `Settings`, such as ``runs=3, seed=1, sample_s=10.0``.

    Raises:
        InputError: whatever is absurd, see `Settings`, `Program`, `choose_hidden` and `check_given`.
    """
    if devices < 1:
        raise InputError(f"devices={devices}: a whole number from 1 up is possible")
    chosen = Settings(**settings)
    chosen.check_programs(profile)
    order = Order(gyro, profile, effects, noise or Noise(), hidden, catalogue or {}, _given(gyro, parameters, effects), chamber or Chamber(), chosen)
    named = [hidden] if isinstance(hidden, str) else list(hidden) if isinstance(hidden, Sequence) else []
    _check_needs({**effects, **{name: order.catalogue[name] for name in named if name in order.catalogue}})
    at_once = _at_once(order)
    for first in range(0, devices, at_once):
        seeds = range(chosen.seed + first, chosen.seed + min(first + at_once, devices))
        yield from _simulated(order, [draw(gyro, seed, len(chosen.places)) for seed in seeds])


def _at_once(order: Order) -> int:
    """How many devices fit into one batch."""
    labels = range(1, order.settings.runs + 1)
    seconds = sum(order.profile.of(label).seconds for label in labels) + order.profile.check.seconds
    most = min(AT_ONCE, int(ROWS_AT_ONCE * order.settings.sample_s / seconds))
    if order.settings.heat == "radial_axial":
        most = min(most, TURNS_AT_ONCE // (order.gyro.layers * order.gyro.turns))
    return max(1, most)


def _given(gyro: GyroClass, parameters: Any, effects: Mapping[str, Effect]) -> Any:
    """The user's own values before those that the class fixes."""
    if parameters is not None and not isinstance(parameters, Mapping):
        return parameters  # refused where the parameters are checked
    fixed = {name: values for name, values in gyro.fixed.items() if name in effects}
    own = parameters or {}
    return {name: _over(fixed.get(name, {}), own.get(name, {})) for name in {**fixed, **own}}


def _over(fixed: Mapping[str, float], own: Any) -> Any:
    return {**fixed, **own} if isinstance(own, Mapping) else own


def _check_needs(effects: Mapping[str, Effect]) -> None:
    for name, effect in effects.items():
        missing = [column for column in effect.needs if column not in NAMES]
        if missing:
            raise InputError(f"effect '{name}' needs the column {', '.join(missing)}; the simulator records {', '.join(NAMES)}")


@torch.no_grad()
def _simulated(order: Order, devices: list[Device]) -> Iterator[Simulation]:
    """One batch."""
    labels = range(1, order.settings.runs + 1)
    runs = [scenario(devices, order.profile.of(label), label, order.chamber, order.settings) for label in labels]
    check = scenario(devices, order.profile.check, "check", order.chamber, order.settings)
    before = before_each((run.time.cpu(), run.program.asked(run.time.cpu())) for run in runs)  # of the chamber: the same for all devices
    order = replace(order, effects=_told(order.effects, before), catalogue=_told(order.catalogue, before))
    shares = _shares(order, runs)
    parts = [_parts(run, shares) for run in (*runs, check)]
    for row, device in enumerate(devices):
        noise = levels(order.noise, device)
        recorded = [record(run, row, part[row], noise) for run, part in zip((*runs, check), parts, strict=True)]
        hidden = tuple(name for name in shares[row] if name not in order.effects)
        yield Simulation(device, shares[row], hidden, noise, recorded[:-1], recorded[-1], order.settings, order.chamber)


def _told(effects: Mapping[str, Effect], before: Before) -> dict[str, Effect]:
    return {name: effect.after(before) for name, effect in effects.items()}


def _shares(order: Order, runs: Sequence[Scenario]) -> list[dict[str, Share]]:
    """The effects of each device, the hidden ones last."""
    devices, drawing = runs[0].devices, Drawing(order.given, order.settings.amplitude)
    turned = any(float(run.reference.max() - run.reference.min()) > 0.0 for run in runs)
    secret = [choose_hidden(order.hidden, order.effects, order.catalogue, NAMES, turned, device.seed) for device in devices]
    for names in secret:
        check_given(order.given, {**order.effects, **{name: order.catalogue[name] for name in names}})
    found: list[dict[str, Share]] = [{} for _ in devices]
    for name, effect in order.effects.items():
        for own, share in zip(found, draw_shares(name, effect, runs, drawing), strict=True):
            own[name] = share
    beside = _columns(order, runs, found) if any(secret) else None
    for name in dict.fromkeys(name for names in secret for name in names):
        rows = [row for row, names in enumerate(secret) if name in names]
        assert beside is not None
        for row, share in zip(rows, draw_shares(name, order.catalogue[name], [run.of(rows) for run in runs], drawing, beside[rows]), strict=True):
            found[row][name] = share
    return [{name: own[name] for name in (*order.effects, *names)} for own, names in zip(found, secret, strict=True)]


def _columns(order: Order, runs: Sequence[Scenario], found: Sequence[Mapping[str, Share]]) -> Tensor:
    """(B, T, M) columns of all effects that are present, over all runs."""
    shapes = {name: torch.stack([own[name].shape for own in found]) for name in order.effects}
    each = [torch.cat([run.columns(effect, shapes[name]) for run in runs], dim=-2).cpu() for name, effect in order.effects.items()]
    return torch.cat([torch.zeros(len(found), sum(len(run.time) for run in runs), 0, dtype=torch.float64), *each], dim=-1)


def _parts(run: Scenario, shares: Sequence[Mapping[str, Share]]) -> list[dict[str, Tensor]]:
    """What each effect adds in each device, each (T,) [°/h]."""
    parts: list[dict[str, Tensor]] = [dict.fromkeys(own, run.time) for own in shares]
    for name in dict.fromkeys(name for own in shares for name in own):
        rows = [row for row, own in enumerate(shares) if name in own]
        for row, part in zip(rows, contribution(run.of(rows), [shares[row][name] for row in rows]).cpu(), strict=True):
            parts[row][name] = part
    return parts
