"""The temperature of every cell of a winding against what its modes say of sums over them."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from zoo.physics.conduction import FIDELITIES, Pack
from zoo.physics.lumps import Lumps
from zoo.physics.modes import respond
from zoo.physics.system import System, Watched, field, modes

F64 = torch.float64
LAYERS, TURNS, STEP = 8, 10, 20.0
FACES = (1, 0, 1, 1)
SAMPLES = torch.tensor([0, 60, 130, 250, 399])


def tensor(*values: float) -> Tensor:
    return torch.tensor(values if len(values) > 1 else values[0], dtype=F64)


def body(name: str, devices: int = 0) -> System:
    """Housing, spool and a winding; several of them, each conducting better than the one before, where a number is given."""
    conductivity = 0.3 * torch.arange(1, devices + 1, dtype=F64) if devices else tensor(0.3)
    sizes = (tensor(0.046), tensor(0.001), tensor(0.0012))
    pack = Pack(LAYERS, TURNS, *sizes, tensor(0.3), tensor(1.7e6), tensor(300.0, 20.0, 250.0, 80.0), FACES)
    lumps = Lumps(tensor(600.0, 100.0), tensor(0.0, 2.0, 2.0, 0.0).reshape(2, 2), tensor(0.6, 0.0).unsqueeze(-1), tensor(6.0, 0.0))
    if not devices:
        return FIDELITIES[name](pack, lumps)
    alike = {
        key: getattr(pack, key).expand(devices, *getattr(pack, key).shape) for key in ("inner_m", "layer_pitch_m", "turn_pitch_m", "heat_capacity")
    }
    pack = replace(pack, **alike, conductivity=conductivity, films=pack.films.expand(devices, 4))
    return FIDELITIES[name](pack, Lumps(*(one.expand(devices, *one.shape) for one in vars(lumps).values())))


def inputs() -> Tensor:
    """A hold, a ramp of 1 K/min, a hold, a step down; the power stays on."""
    time = STEP * torch.arange(400, dtype=F64)
    return torch.stack([20 + (time - 1000).clamp(0, 3000) / 60 - 30.0 * (time > 6000), torch.ones_like(time)])


@pytest.mark.parametrize("name", FIDELITIES)
def test_sums_over_the_field_are_what_the_modes_say(name: str) -> None:
    system = body(name)
    weights = torch.rand(3, LAYERS, TURNS, generator=torch.Generator().manual_seed(1), dtype=F64)
    watched = Watched(torch.zeros(3, 2, dtype=F64), weights, (False, False, False))
    said = respond(modes(system, watched), STEP, inputs())[:, SAMPLES]
    found = field(system, STEP, inputs(), SAMPLES)
    assert found.shape == (len(SAMPLES), *system.cut)
    assert torch.allclose(system.gathered(weights) @ found.flatten(1).T, said, rtol=1e-10)


@pytest.mark.parametrize("name", FIDELITIES)
def test_soaked_every_cell_has_the_temperature_of_the_air_and_the_rise_by_the_power(name: str) -> None:
    assert field(body(name), STEP, inputs(), SAMPLES)[0] == pytest.approx(torch.full(body(name).cut, 20.0 + 6.0 / 0.6, dtype=F64), rel=1e-9)


def test_rows_are_layers_from_the_inside_and_columns_turns_from_the_bottom() -> None:
    """In a ramp the inner face, on the metal, is ahead of the outer one in the air, and the bottom ahead of the top with its poorer contact."""
    found = field(body("radial_axial"), STEP, inputs(), SAMPLES)[2]
    assert found.shape == (LAYERS, TURNS)
    assert float(found[0, 5] - found[-1, 5]) > 0.1
    assert float(found[4, 0] - found[4, -1]) > 0.01
    assert float(found.min(0).values.min()) < float(found[0, 0]) - 0.1


def test_devices_in_a_batch_are_each_by_themselves() -> None:
    together = field(body("radial_axial", 3), STEP, inputs(), SAMPLES)
    assert together.shape == (3, len(SAMPLES), LAYERS, TURNS)
    assert torch.allclose(together[0], field(body("radial_axial"), STEP, inputs(), SAMPLES), rtol=1e-9)
    assert float((together[0] - together[2]).abs().max()) > 0.1
