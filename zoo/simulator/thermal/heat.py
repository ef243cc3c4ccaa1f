"""Heat in simulated gyros: housing, spool and winding, many devices of one design at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.errors import InputError, nearest
from zoo.physics.conduction import FIDELITIES, Pack
from zoo.physics.lumps import Lumps
from zoo.physics.modes import Modes, respond
from zoo.physics.system import System, Watched, field, modes
from zoo.simulator.gyros.device import Device, stacked
from zoo.simulator.thermal.winding_weights import lead_weight, of_turns
from zoo.units import SECONDS_PER_MINUTE

HOUSING, SPOOL = 0, 1
TOUCHES = (SPOOL, HOUSING, SPOOL, SPOOL)


@dataclass(frozen=True, eq=False)
class Heat:
    """Temperatures of one run in B devices.

    Attributes:
        air: (T,) or (B, T) [°C].
        housing: (B, T) [°C].
        spool: (B, T) [°C].
        coil: (B, T) mean over the fibre [°C].
        inner: (B, T) the innermost layer [°C].
        outer: (B, T) the outermost layer [°C].
        housing_rate: (B, T) [K/min].
        coil_rate: (B, T) [K/min].
        shupe: (B, T) rates through the winding's weights, for C_w = 1 [K/min].
        mohr: (B, T) the same where the fibre's thermo-optic coefficient differs in the outermost layers, for C_M = 1 [K/min].
    """

    air: Tensor
    housing: Tensor
    spool: Tensor
    coil: Tensor
    inner: Tensor
    outer: Tensor
    housing_rate: Tensor
    coil_rate: Tensor
    shupe: Tensor
    mohr: Tensor

    def at(self, place: str) -> Tensor:
        """(T,) or (B, T) where a thermometer sits [°C]: ``spool``, ``housing``, ``inner_layer``, ``outer_layer`` or ``air``."""
        found: Tensor = getattr(self, place.removesuffix("_layer"))
        return found


WATCHED = ("housing", "spool", "coil", "inner", "outer", "housing_rate", "coil_rate", "shupe", "mohr")
RATES = ("housing_rate", "coil_rate", "shupe", "mohr")


def body(devices: Sequence[Device], like: Tensor) -> tuple[Pack, Lumps]:
    """The winding and what is around it.

    Args:
        devices: B of one design.
        like: says where and in which precision to compute.
    """
    first = devices[0].gyro
    own = {key: stacked(devices, key, like) for key in devices[0].values}
    films = torch.stack([own["contact"], own["gap"], own["contact"], torch.where(own["top_contact"] > 0, own["top_contact"], own["contact"])], -1)
    inner = (own["diameter_m"] - first.layers * own["layer_pitch_m"]) / 2
    conductivity = torch.tensor([device.conductivity for device in devices], dtype=like.dtype, device=like.device)
    pitches = (own["layer_pitch_m"], own["turn_pitch_m"])
    pack = Pack(first.layers, first.turns, inner, *pitches, conductivity, own["heat_capacity"], films, TOUCHES)
    winding = own["heat_capacity"] * pack.across.volume.sum(-1) * own["turn_pitch_m"] * first.turns
    inside = winding + own["spool_j_per_k"]
    to_air = (inside + own["housing_j_per_k"]) / own["package_s"]
    mount = inside / own["mount_s"]
    nothing = torch.zeros_like(mount)
    link = torch.stack([torch.stack([nothing, mount], -1), torch.stack([mount, nothing], -1)], -1)
    capacity = torch.stack([own["housing_j_per_k"], own["spool_j_per_k"]], -1)
    ambient = torch.stack([to_air, nothing], -1).unsqueeze(-1)
    power = (to_air * own["self_heating_k"]).unsqueeze(-1) * torch.stack([1 - own["power_at_spool"], own["power_at_spool"]], -1)
    return pack, Lumps(capacity, link, ambient, power)


def system(devices: Sequence[Device], fidelity: str, like: Tensor) -> System:
    """The devices as one batched linear system.

    Args:
        devices: B of one design.
        fidelity: one of `FIDELITIES`.
        like: says where and in which precision to compute.

    Raises:
        InputError: no such fidelity.
    """
    if fidelity not in FIDELITIES:
        raise InputError(f"heat={fidelity}: {nearest(str(fidelity), FIDELITIES)}")
    return FIDELITIES[fidelity](*body(devices, like))


def heat(
    devices: Sequence[Device], time: Tensor, air: Tensor, cold_start: bool = False, fidelity: str = "radial", soaked_c: float | None = None
) -> Heat:
    """Temperatures of one run, exact for air that is linear between samples.

    Args:
        devices: B of one design.
        time: (T,) evenly spaced [s].
        air: (T,) or (B, T) [°C].
        cold_start: whether the body begins as cold as the air, and not warmed through by its electronics.
        fidelity: one of `FIDELITIES`.
        soaked_c: air in which the gyro was before [°C]; None for the first of `air`.
    """
    found = modes(system(devices, fidelity, time), watched(devices, time))
    warmed = found.drive[..., -1] / found.rate
    rise = found.observe @ warmed.unsqueeze(-1) + found.direct[..., -1:]
    # The heat of the electronics is there throughout; what a cold start lacks of it at first dies away.
    air_only = Modes(found.rate, found.drive[..., :-1], found.observe, found.direct[..., :-1])
    seen = respond(air_only, _step(time), air.unsqueeze(-2), _start(found, air, cold_start, soaked_c) - warmed) + rise
    parts = {name: seen[..., place, :] * (SECONDS_PER_MINUTE if name in RATES else 1.0) for place, name in enumerate(WATCHED)}
    return Heat(air, **parts)


def fields(devices: Sequence[Device], time: Tensor, air: Tensor, samples: Tensor, cold_start: bool = False, soaked_c: float | None = None) -> Tensor:
    """(B, K, layers, turns) temperatures of all turns at chosen samples [°C].

    Args:
        devices: B of one design.
        time: (T,) evenly spaced [s].
        air: (T,) or (B, T) [°C].
        samples: (K,) which of the T samples.
        cold_start: see `heat`.
        soaked_c: see `heat`.
    """
    made = system(devices, "radial_axial", time)
    start = _start(modes(made, watched(devices, time)), air, cold_start, soaked_c)
    return field(made, _step(time), torch.stack([air, torch.ones_like(air)], -2), samples, start)


def _start(found: Modes, air: Tensor, cold_start: bool, soaked_c: float | None) -> Tensor:
    """(B, X) amplitudes of the modes at the first sample: soaked in the air before, and with the power on if that was long before."""
    before = air[..., :1] if soaked_c is None else torch.full_like(air[..., :1], soaked_c)
    powered = torch.zeros_like(before) if cold_start else torch.ones_like(before)
    return (found.drive @ torch.stack([before, powered], -2)).squeeze(-1) / found.rate


def _step(time: Tensor) -> float:
    return float(time[1] - time[0]) if len(time) > 1 else 1.0


def watched(devices: Sequence[Device], like: Tensor) -> Watched:
    """What is asked of the heat, in the order of `WATCHED`."""
    gyro = devices[0].gyro
    lumps = torch.zeros(len(devices), len(WATCHED), 2, dtype=like.dtype, device=like.device)
    for name, lump in (("housing", HOUSING), ("spool", SPOOL), ("housing_rate", HOUSING)):
        lumps[:, WATCHED.index(name), lump] = 1.0
    lumps[:, WATCHED.index("shupe"), HOUSING] = torch.tensor([lead_weight(device) for device in devices], dtype=like.dtype)
    each = torch.stack([of_turns(device) for device in devices]).to(like)
    turns = torch.zeros(len(devices), len(WATCHED), gyro.layers, gyro.turns, dtype=like.dtype, device=like.device)
    turns[:, [WATCHED.index(name) for name in ("coil", "coil_rate", "shupe", "mohr")]] = each[:, [0, 0, 1, 2]]
    turns[:, WATCHED.index("inner"), 0] = 1 / gyro.turns
    turns[:, WATCHED.index("outer"), -1] = 1 / gyro.turns
    return Watched(lumps, turns, tuple(name in RATES for name in WATCHED))
