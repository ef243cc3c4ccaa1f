"""The gyro as a heat network, and Shupe's effect from its layers."""

from __future__ import annotations

import pytest
import torch

from zoo.catalog import build
from zoo.simulator.device import draw
from zoo.simulator.gyro_class import MEDIUM, TACTICAL, GyroClass
from zoo.simulator.heat import LAYERS, Heat, heat, network, weights
from zoo.simulator.plant import scenario
from zoo.simulator.program import Program


def ramp(gyro: GyroClass, seed: int, cold_start: bool = False) -> tuple[torch.Tensor, Heat]:
    time = torch.arange(0, 40001, 10.0, dtype=torch.float64)
    air = 20 + (time - 7200).clamp(0, 7200) / 60
    return time, heat(draw(gyro, seed), time, air, cold_start)


def test_weights_are_odd_and_normalised() -> None:
    for bend in (-0.5, 0.0, 1.0):
        weight = weights(bend)
        assert torch.allclose(weight, -weight.flip(0), atol=1e-14)
        assert abs(float(weight.sum())) < 1e-13
        linear = 0.5 - (torch.arange(LAYERS, dtype=torch.float64) + 0.5) / LAYERS
        assert float(weight @ linear) == pytest.approx(1.0)


@pytest.mark.parametrize("gyro", [MEDIUM, TACTICAL])
@pytest.mark.parametrize("seed", range(8))
def test_temperatures_are_those_of_real_gyros(gyro: GyroClass, seed: int) -> None:
    """Physics.md §3 at 1 K/min: the housing leads the coil by 2–3.3 K, 0.36–0.75 K across the winding (medium); twice as wide here."""
    _, body = ramp(gyro, seed)
    end = int(14400 / 10) - 1
    assert 1.0 < float(body.housing[end] - body.coil[end]) < 6.6
    layers = body.nodes[end, 1:-1]
    assert 0.03 < float(layers.max() - layers.min()) < 1.5
    assert float(body.coil_rate[end]) == pytest.approx(1.0, abs=0.1)


def test_soaked_means_self_heated_and_at_rest() -> None:
    _, body = ramp(MEDIUM, 1)
    assert float(body.rates[:700].abs().max()) < 1e-10
    assert float(body.housing[0]) == pytest.approx(20 + draw(MEDIUM, 1)["self_heating_k"])


def test_a_cold_start_begins_at_the_air_and_ends_self_heated() -> None:
    _, cold = ramp(MEDIUM, 1, cold_start=True)
    _, warm = ramp(MEDIUM, 1)
    assert cold.nodes[0].tolist() == pytest.approx([20.0] * (LAYERS + 2))
    assert torch.allclose(cold.nodes[-1], warm.nodes[-1], atol=1e-3)


def test_the_package_has_its_time_constant() -> None:
    device = draw(MEDIUM, 3)
    body = network(device)
    slowest = torch.linalg.eigvalsh(body.conductance() / (body.capacity.sqrt()[:, None] * body.capacity.sqrt())).min()
    assert float(1 / slowest) == pytest.approx(device["package_s"], rel=0.35)


def shupe(program: Program, seed: int) -> tuple[torch.Tensor, torch.Tensor]:
    run = scenario(draw(MEDIUM, seed), program, 1, seed, 1.0, 120.0, False, 0.0)
    column = run.columns(build("effects", "shupe"), torch.zeros(0, dtype=torch.float64))[:, 0]
    return run.time, column


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_pure_shupe_integrates_to_nothing_between_isothermal_states(seed: int) -> None:
    time, rate = shupe(Program(((20, 20, 1800), (20, 60, 1200), (60, 60, 40000))), seed)
    assert abs(float(torch.trapezoid(rate, time))) < 1e-3 * float(torch.trapezoid(rate.abs(), time))


def test_pure_shupe_is_nothing_at_a_uniform_rate() -> None:
    time, rate = shupe(Program(((20, 20, 1800), (20, 320, 60000), (320, 320, 3600))), 1)
    late = (time > 40000) & (time < 60000)
    assert float(rate[late].abs().max()) < 1e-3 * float(rate.abs().max())
    assert float(rate[time < 1800].abs().max()) < 1e-10


def test_heating_and_cooling_have_opposite_signs() -> None:
    _, up = shupe(Program(((20, 20, 1800), (20, 60, 2400), (60, 60, 3600))), 1)
    _, down = shupe(Program(((60, 60, 1800), (60, 20, 2400), (20, 20, 3600))), 1)
    assert torch.allclose(up, -down, atol=1e-10)


def test_reversing_the_weights_flips_it() -> None:
    _, body = ramp(MEDIUM, 1)
    layers = body.rates[:, 1:-1]
    assert torch.allclose(layers @ weights(0.3).flip(0), -(layers @ weights(0.3)), atol=1e-12)
