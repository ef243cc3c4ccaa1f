"""Heat in winding, spool and housing: balance, limits in which the fidelities agree, brute force, gradients."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
import torch
from torch import Tensor

from zoo.physics.conduction import FIDELITIES, Pack, lumped, radial, radial_axial
from zoo.physics.lumps import Lumps
from zoo.physics.modes import Modes, respond
from zoo.physics.system import System, Watched, modes
from zoo.physics.winding import Coil, wind

F64 = torch.float64
HOUSING, SPOOL = 0, 1
ALL_AROUND = (SPOOL, HOUSING, SPOOL, SPOOL)


def tensor(*values: Any) -> Tensor:
    return torch.tensor(values if len(values) > 1 else values[0], dtype=F64)


def pack(layers: int = 8, turns: int = 10, conductivity: float = 0.3, films: tuple[float, ...] = (300.0, 20.0, 250.0, 80.0), **changes: Any) -> Pack:
    sizes = (tensor(0.046), tensor(0.008 / layers), tensor(0.012 / turns))
    return replace(Pack(layers, turns, *sizes, tensor(conductivity), tensor(1.7e6), tensor(*films), ALL_AROUND), **changes)


def around(to_air: float = 0.6, power: float = 0.0, more: float | None = None) -> Lumps:
    """Housing and spool; with `more` a third lump of this capacity that stands for the chamber's air [J/K]."""
    capacity, link = [600.0, 100.0], [[0.0, 2.0], [2.0, 0.0]]
    if more is None:
        return Lumps(tensor(*capacity), tensor(*link), tensor([to_air], [0.0]), tensor(power, 0.0))
    link = [[0.0, 2.0, to_air], [2.0, 0.0, 0.0], [to_air, 0.0, 0.0]]
    return Lumps(tensor(*capacity, more), tensor(*link), torch.zeros(3, 1, dtype=F64), tensor(power, 0.0, 0.0))


def asked(count: int = 2) -> Watched:
    """Mean of the winding, housing, a weighted sum of rates over the winding, rate of the housing; for coils of 8 layers of 10 turns."""
    weights = wind(Coil(8, 10, 0.1, 0.001, 0.0012)).weights()
    turns = torch.stack([torch.full_like(weights, 1 / 80), torch.zeros_like(weights), weights / weights.abs().max(), torch.zeros_like(weights)])
    lumps = torch.zeros(4, count, dtype=F64)
    lumps[1, HOUSING] = lumps[3, HOUSING] = 1.0
    return Watched(lumps, turns, (False, False, True, True))


def program(count: int = 600, step_s: float = 20.0, power: float = 1.0) -> Tensor:
    """Air and the share of the power: a hold, a ramp of 1 K/min, a hold, a step down."""
    time = step_s * torch.arange(count, dtype=F64)
    air = 20 + (time - 1000).clamp(0, 3000) / 60 - 30.0 * (time > 8000)
    return torch.stack([air, torch.full_like(air, power)])


def run(system: System, inputs: Tensor | None = None, step_s: float = 20.0, watched: Watched | None = None) -> Tensor:
    return respond(modes(system, watched or asked()), step_s, program() if inputs is None else inputs)


def capacity(coil: Pack, lumps: Lumps) -> float:
    volume = coil.across.volume.sum() * coil.turn_pitch_m * coil.turns
    return float(coil.heat_capacity * volume + lumps.capacity.sum())


@pytest.mark.parametrize("name", FIDELITIES)
def test_heat_that_comes_in_is_heat_that_is_stored(name) -> None:
    """A closed box of gyro and air: what the hot air loses and the electronics give, the gyro has. Content is vᵀx, v the state of 1 K everywhere."""
    coil, lumps, step, count = pack(), around(power=5.0, more=800.0), 20.0, 800
    system = FIDELITIES[name](coil, lumps)
    decay, vectors = torch.linalg.eigh(system.stiffness)
    everywhere = vectors[:, 0] / float(system.lumps[0] @ vectors[:, 0])
    assert abs(float(decay[0])) < 1e-12
    assert system.winding @ everywhere == pytest.approx(torch.ones(len(system.winding), dtype=F64), abs=1e-9)
    assert float(everywhere @ everywhere) == pytest.approx(capacity(coil, lumps), rel=1e-10)
    content = Modes(decay.clamp_min(0.0), vectors.mT @ system.drive[:, 1:], (everywhere @ vectors).unsqueeze(0), torch.zeros(1, 1, dtype=F64))
    start = vectors.mT @ system.lumps.mT @ (lumps.capacity * tensor(20.0, 20.0, 90.0))
    found = respond(content, step, torch.ones(1, count, dtype=F64), start)[0]
    given = 5.0 * step * torch.arange(count, dtype=F64)
    assert found - found[0] == pytest.approx(given, abs=1e-10 * capacity(coil, lumps) * 100)


@pytest.mark.parametrize("name", FIDELITIES)
def test_what_leaves_the_air_arrives_in_the_gyro(name) -> None:
    """The same box without power: temperatures of all end at the mean by capacity, and the exchanged heat is the same for all."""
    coil, lumps = pack(), around(more=800.0)
    system = FIDELITIES[name](coil, lumps)
    decay, vectors = torch.linalg.eigh(system.stiffness)
    start = vectors.mT @ system.lumps.mT @ (lumps.capacity * tensor(0.0, 0.0, 100.0))
    seen = Modes(decay.clamp_min(0.0), torch.zeros(len(decay), 1, dtype=F64), system.lumps @ vectors, torch.zeros(3, 1, dtype=F64))
    last = respond(seen, 1e5, torch.zeros(1, 20, dtype=F64), start)[:, -1]
    assert last == pytest.approx(torch.full((3,), 80000.0 / capacity(coil, lumps), dtype=F64), rel=1e-10)


def test_each_fidelity_is_the_finer_one_where_that_has_nothing_to_resolve() -> None:
    """A winding that conducts a million times better: one temperature; insulated flanges: nothing happens along the axis."""
    inputs = program()
    well = [run(FIDELITIES[name](pack(conductivity=3e5), around()), inputs) for name in ("lumped", "radial", "radial_axial")]
    for found in well[1:]:
        assert (found - well[0])[[0, 1]].abs().max() < 1e-4
        assert (found - well[0])[3].abs().max() < 1e-7
    flat = pack(films=(300.0, 20.0, 0.0, 0.0))
    across, both = run(radial(flat, around()), inputs), run(radial_axial(flat, around(), 10**6), inputs)
    for one, two in zip(across, both, strict=True):
        assert (one - two).abs().max() < 1e-8 * float(one.abs().max())


def test_the_winding_lies_on_its_side_as_well() -> None:
    """Films on the flanges only and a coil so large that it is a slab: the profile along the axis is the one across, seen from the side."""
    wide = pack(8, 8, films=(0.0, 0.0, 300.0, 20.0), inner_m=tensor(1e3), layer_pitch_m=tensor(1e-3), turn_pitch_m=tensor(1e-3))
    wide = replace(wide, touches=(SPOOL, HOUSING, SPOOL, HOUSING))
    upright = replace(wide, films=tensor(300.0, 20.0, 0.0, 0.0))
    lumps, big = around(), 2 * math.pi * 1e3 * 0.008
    lumps = Lumps(lumps.capacity * big * 1e3, lumps.link * big * 1e3, lumps.ambient * big * 1e3, lumps.power)
    profile = torch.linspace(-1, 1, 8, dtype=F64)
    along = Watched(torch.zeros(1, 2, dtype=F64), profile.expand(1, 8, 8) / 8, (False,))
    across = Watched(torch.zeros(1, 2, dtype=F64), profile.unsqueeze(1).expand(1, 8, 8) / 8, (False,))
    first, second = run(radial_axial(wide, lumps), watched=along), run(radial_axial(upright, lumps), watched=across)
    assert (first - second).abs().max() < 1e-4 * float(first.abs().max())


def brute_force(coil: Pack, lumps: Lumps) -> tuple[Tensor, Tensor, Tensor]:
    """Every cell a node: capacities, conductance matrix, way to the air."""
    rows, columns = coil.across, coil.along
    no_film = torch.zeros(2, dtype=F64)
    stiffness = torch.kron(rows.stiffness(coil.conductivity, no_film), torch.diag(columns.volume))
    stiffness = stiffness + torch.kron(torch.diag(rows.volume), columns.stiffness(coil.conductivity, no_film))
    shape = (len(rows.volume), len(columns.volume))
    flow = torch.zeros(*shape, 2, dtype=F64)
    flow[0, :, SPOOL] += coil.films[0] * rows.area[0] * columns.volume
    flow[-1, :, HOUSING] += coil.films[1] * rows.area[1] * columns.volume
    flow[:, 0, SPOOL] += coil.films[2] * rows.volume
    flow[:, -1, SPOOL] += coil.films[3] * rows.volume
    flow = flow.flatten(0, 1)
    top = torch.cat([lumps.conductance() + torch.diag(flow.sum(0)), -flow.mT], 1)
    whole = torch.cat([top, torch.cat([-flow, stiffness + torch.diag(flow.sum(1))], 1)], 0)
    cells = coil.heat_capacity * torch.outer(rows.volume, columns.volume).flatten()
    air = torch.cat([lumps.ambient[:, 0], torch.zeros(len(cells), dtype=F64)])
    return torch.cat([lumps.capacity, cells]), whole, air


def test_the_modes_give_what_brute_force_gives() -> None:
    """All cells of a small winding, stepped with the exponential of the whole matrix, against the product modes."""
    coil, lumps, step = pack(), around(), 20.0
    mass, whole, air = brute_force(coil, lumps)
    inputs, size = program(150), len(mass)
    joint = torch.zeros(size + 2, size + 2, dtype=F64)  # (T, u, u')
    joint[:size, :size], joint[:size, size], joint[size, size + 1] = -whole / mass.unsqueeze(1), air / mass, 1.0
    leap = torch.linalg.matrix_exp(joint * step)
    state, seen = torch.full((size,), 20.0, dtype=F64), []
    watched, slope = asked(), torch.diff(inputs[0]) / step
    inside = torch.zeros(4, len(coil.across.volume), len(coil.along.volume), dtype=F64)
    inside[:, 1:-1, 1:-1] = watched.turns
    weights = torch.cat([watched.lumps, inside.flatten(1)], 1)
    for k in range(150):
        rates = (air * inputs[0, k] - whole @ state) / mass
        seen.append(torch.where(torch.tensor(watched.is_rate), weights @ rates, weights @ state))
        if k < 149:
            state = (leap @ torch.cat([state, inputs[0, k : k + 1], slope[k : k + 1]]))[:size]
    exact = torch.stack(seen, 1)
    for found, tolerance in ((run(radial_axial(coil, lumps, 10**6), inputs), 1e-8), (run(radial_axial(coil, lumps, 40), inputs), 1e-2)):
        assert ((found - exact).abs().amax(1) / exact.abs().amax(1)).max() < tolerance


def test_condensed_modes_lose_nothing_in_a_steady_state_and_in_a_ramp() -> None:
    coil, lumps = pack(), around()
    ramp = torch.stack([torch.arange(4000, dtype=F64), torch.ones(4000, dtype=F64)])
    few, all_of_them = (run(radial_axial(coil, lumps, limit), ramp, 20.0) for limit in (6, 10**6))
    assert len(radial_axial(coil, lumps, 6).stiffness) == 8
    assert few[:, -1] == pytest.approx(all_of_them[:, -1], rel=1e-9)


@pytest.mark.parametrize("name", FIDELITIES)
def test_in_a_long_ramp_everything_warms_at_the_same_rate(name) -> None:
    ramp = torch.stack([torch.arange(3000, dtype=F64) / 3, torch.ones(3000, dtype=F64)])
    found = run(FIDELITIES[name](pack(), around()), ramp)
    assert float(found[3, -1]) == pytest.approx(1 / 60, rel=1e-9)
    assert abs(float(found[2, -1])) < 1e-9 * float(found[2].abs().max()) + 1e-12


@pytest.mark.parametrize("name", FIDELITIES)
def test_power_raises_the_temperature_by_the_resistance_to_the_air(name) -> None:
    found = run(FIDELITIES[name](pack(), around(power=6.0)), torch.stack([torch.full((9,), 20.0, dtype=F64), torch.ones(9, dtype=F64)]))
    assert found[:2] == pytest.approx(torch.full((2, 9), 20.0 + 6.0 / 0.6, dtype=F64), rel=1e-10)


@pytest.mark.parametrize("step_s", [1e-3, 1.0, 1e4, 1e7])
def test_no_step_is_too_long(step_s) -> None:
    found = run(radial(pack(), around()), program(step_s=step_s), step_s)
    assert bool(found.isfinite().all())
    assert float(found[0].min()) > -10.0 - 1e-6
    assert float(found[0].max()) < 70.0 + 1e-6


def test_devices_in_a_batch_are_each_by_themselves() -> None:
    conductivity, films = tensor(0.2, 0.3, 0.9), tensor(300.0, 20.0, 250.0, 80.0) * tensor(1.0, 2.0, 0.5).unsqueeze(1)
    single = pack()
    sizes = {key: getattr(single, key).expand(3) for key in ("inner_m", "layer_pitch_m", "turn_pitch_m", "heat_capacity")}
    three = replace(single, **sizes, conductivity=conductivity, films=films)
    lumps = around()
    batch = Lumps(*(one.expand(3, *one.shape) for one in (lumps.capacity, lumps.link, lumps.ambient, lumps.power)))
    for fidelity in (lumped, radial, radial_axial):
        together = run(fidelity(three, batch))
        for i in range(3):
            alone = run(fidelity(replace(single, conductivity=conductivity[i], films=films[i]), lumps))
            assert ((together[i] - alone).abs().amax(1) <= 1e-6 * alone.abs().amax(1)).all()


@pytest.mark.parametrize("name", FIDELITIES)
@pytest.mark.parametrize("key", ["conductivity", "heat_capacity", "films", "inner_m", "layer_pitch_m", "turn_pitch_m"])
def test_gradients_are_those_of_finite_differences(name, key) -> None:
    coil, lumps, inputs = pack(4, 6), around(power=5.0), program(60, 200.0)
    small = Watched(torch.zeros(2, 2, dtype=F64), wind(Coil(4, 6, 0.1, 0.002, 0.002)).weights().expand(2, -1, -1) * 1e4, (False, True))
    scale = getattr(coil, key)

    def found(share: Tensor) -> Tensor:
        return run(FIDELITIES[name](replace(coil, **{key: scale * share}), lumps), inputs, 200.0, small)[:, ::5]

    share = torch.ones_like(scale).requires_grad_()
    assert torch.autograd.gradcheck(found, (share,), rtol=1e-6, atol=1e-7, eps=1e-5)


def test_parameters_can_be_fitted_through_it() -> None:
    """Conductivity, contact and gap from the temperatures of the innermost and the outermost layer, by L-BFGS from half or twice their values."""
    coil, lumps, inputs = pack(), around(), program(300)
    faces = torch.zeros(2, 8, 10, dtype=F64)
    faces[0, 0], faces[1, -1] = 0.1, 0.1
    seen = Watched(torch.zeros(2, 2, dtype=F64), faces, (False, False))

    def temperatures(log: Tensor) -> Tensor:
        conductivity, contact, gap = (tensor(0.3, 300.0, 20.0) * log.exp()).unbind()
        films = torch.stack([contact, gap, contact, contact])
        return run(radial(replace(coil, conductivity=conductivity, films=films), lumps), inputs, watched=seen)

    measured = temperatures(torch.zeros(3, dtype=F64)).detach()
    log = tensor(0.7, -0.7, 0.7).requires_grad_()
    optimizer = torch.optim.LBFGS([log], max_iter=200, tolerance_grad=1e-12, tolerance_change=1e-14, line_search_fn="strong_wolfe")

    def loss() -> Tensor:
        optimizer.zero_grad()
        value = (temperatures(log) - measured).square().mean()
        value.backward()
        return value

    optimizer.step(loss)
    assert log.detach().abs().max() < 1e-4
