"""The lumped heat network against analytic solutions, its own heat balance and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from zoo.physics.lag import lagged
from zoo.physics.network import Network, rates, solve, steady

F64 = torch.float64


def single(tau: float, power: float = 0.0) -> Network:
    values = (torch.tensor(value, dtype=F64) for value in ([600.0], [[0.0]], [600.0 / tau], [power]))
    return Network(*values)


def chain(seed: int, nodes: int = 6, batch: tuple[int, ...] = ()) -> Network:
    generator = torch.Generator().manual_seed(seed)

    def draw(*size: int) -> torch.Tensor:
        return 0.3 + torch.rand(*batch, *size, generator=generator, dtype=F64)

    link = torch.diag_embed(draw(nodes - 1), offset=1)
    air = torch.zeros(*batch, nodes, dtype=F64)
    air[..., 0] = 0.4
    return Network(100.0 * draw(nodes), link + link.mT, air, 0.2 * draw(nodes))


def uneven_times(seed: int, count: int, mean_step: float) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    return torch.cumsum(mean_step * (0.2 + torch.rand(count, generator=generator, dtype=F64)), 0)


def test_single_node_is_a_first_order_lag() -> None:
    time = uneven_times(1, 300, 20.0)
    air = 20 + 30 * torch.sin(time / 500)
    assert torch.allclose(solve(single(700.0), time, air)[:, 0], lagged(time, air, torch.tensor(700.0, dtype=F64)), atol=1e-11)


def test_single_node_after_a_step() -> None:
    time = torch.arange(0, 4000, 7.0, dtype=F64)
    got = solve(single(900.0, power=2.0), time, torch.full_like(time, 60.0), start=torch.tensor([20.0], dtype=F64))[:, 0]
    end = 60.0 + 2.0 / (600.0 / 900.0)
    assert torch.allclose(got, end + (20.0 - end) * torch.exp(-time / 900.0), atol=1e-11)


def test_every_node_lags_a_long_ramp_by_its_own_steady_delay() -> None:
    network, slope = chain(2), 1 / 60
    network = Network(network.capacity, network.link, network.air, torch.zeros_like(network.power))
    time = torch.arange(0, 4e5, 100.0, dtype=F64)
    air = slope * time
    delay = torch.linalg.solve(network.conductance(), network.capacity)
    assert torch.allclose(air[-1] - solve(network, time, air)[-1], slope * delay, rtol=1e-9)


def gauss_times(corners: torch.Tensor, order: int = 12) -> tuple[torch.Tensor, torch.Tensor]:
    """Quadrature nodes inside each segment, between the corners, and their weights (0 at the corners)."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    inner = (torch.from_numpy(nodes) + 1) / 2
    width = torch.diff(corners).unsqueeze(1)
    times = torch.cat([corners[:-1, None], corners[:-1, None] + width * inner], dim=1)
    weight = torch.cat([torch.zeros(len(width), 1, dtype=F64), width / 2 * torch.from_numpy(weights)], dim=1)
    return torch.cat([times.flatten(), corners[-1:]]), torch.cat([weight.flatten(), torch.zeros(1, dtype=F64)])


def test_heat_in_is_heat_stored() -> None:
    network = chain(3)
    corners = torch.arange(0, 6001, 60.0, dtype=F64)
    time, weight = gauss_times(corners)
    air = torch.from_numpy(np.interp(time.numpy(), [0, 1200, 3000, 6000], [20.0, 20.0, 70.0, -10.0]))
    temperature = solve(network, time, air, start=torch.full((6,), 20.0, dtype=F64))
    flow = ((air.unsqueeze(1) - temperature) * network.air + network.power).sum(1)
    stored = ((temperature[-1] - temperature[0]) * network.capacity).sum()
    assert abs((weight * flow).sum() - stored) < 1e-10 * (weight * flow.abs()).sum()


def test_nothing_leaves_an_isolated_network() -> None:
    network = chain(4)
    network = Network(network.capacity, network.link, torch.zeros_like(network.air), torch.zeros_like(network.power))
    time = torch.arange(0, 20000, 50.0, dtype=F64)
    start = torch.tensor([10.0, 20.0, 30.0, 40.0, 50.0, 60.0], dtype=F64)
    temperature = solve(network, time, torch.zeros_like(time), start=start)
    heat = temperature @ network.capacity
    assert torch.allclose(heat, heat[0].expand_as(heat), rtol=1e-12)
    assert torch.allclose(temperature[-1], heat[0] / network.capacity.sum() * torch.ones(6, dtype=F64), rtol=1e-6)


@pytest.mark.parametrize("parts", [2, 5])
def test_a_finer_step_changes_nothing(parts: int) -> None:
    network = chain(5)
    coarse = uneven_times(6, 80, 90.0)
    air = 20 + 10 * torch.cumsum(torch.randn(80, generator=torch.Generator().manual_seed(7), dtype=F64), 0)
    between = coarse[:-1, None] + torch.diff(coarse)[:, None] * torch.arange(parts, dtype=F64) / parts
    fine = torch.cat([between.flatten(), coarse[-1:]])
    fine_air = torch.from_numpy(np.interp(fine.numpy(), coarse.numpy(), air.numpy()))
    assert torch.allclose(solve(network, coarse, air), solve(network, fine, fine_air)[::parts], atol=1e-10)


@settings(max_examples=30, deadline=None)
@given(st.floats(1e-6, 1e6), st.integers(0, 50))
def test_any_step_from_soaked_stays_soaked(step: float, seed: int) -> None:
    network = chain(seed)
    time = torch.arange(5, dtype=F64) * step
    air = torch.full_like(time, -30.0)
    temperature = solve(network, time, air)
    assert torch.allclose(temperature, steady(network, air[:1]).expand(5, 6), atol=1e-9)
    assert rates(network, temperature, air).abs().max() < 1e-10


def test_rates_are_the_derivative() -> None:
    network = chain(8)
    time = torch.arange(0, 2000, 0.5, dtype=F64)
    air = 20 + 15 * torch.sin(time / 300)
    temperature = solve(network, time, air)
    centred = (temperature[2:] - temperature[:-2]) / 1.0
    assert torch.allclose(rates(network, temperature, air)[1:-1], centred, atol=1e-6)


def test_a_batch_is_its_devices() -> None:
    batch = chain(9, batch=(3,))
    time = uneven_times(10, 50, 30.0)
    air = 20 + time / 60
    together = solve(batch, time, air)
    for i in range(3):
        one = Network(batch.capacity[i], batch.link[i], batch.air[i], batch.power[i])
        assert torch.allclose(together[i], solve(one, time, air), atol=1e-11)


def test_gradient_agrees_with_finite_differences() -> None:
    base = chain(11, nodes=4)
    time = torch.arange(0, 3000, 100.0, dtype=F64)
    air = 20 + 20 * torch.sin(time / 400)

    def last(capacity: torch.Tensor, link: torch.Tensor, drawn: torch.Tensor) -> torch.Tensor:
        between = torch.diag_embed(link, offset=1)
        return solve(Network(capacity, between + between.mT, drawn, base.power), time, air)[::7]

    inputs = (base.capacity.clone(), torch.diagonal(base.link, offset=1).clone(), base.air + 0.05)
    assert torch.autograd.gradcheck(last, tuple(value.requires_grad_() for value in inputs), eps=1e-6, atol=1e-6)
