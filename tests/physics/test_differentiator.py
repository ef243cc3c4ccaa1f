"""The stated law of the smoothing differentiator."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from zoo.physics.differentiator import temperature_rate

TAU = 60.0


def uneven(end: float, seed: int = 0, longest: float = 3.0) -> Tensor:
    """Increasing times from 0 to about `end` [s] with steps between 0.1 and `longest`."""
    steps = 0.1 + (longest - 0.1) * torch.rand(int(2 * end / longest), generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return torch.cumsum(steps, 0) - steps[0]


@pytest.mark.parametrize("tau", [20.0, 60.0, 200.0])
def test_a_ramp_gives_its_slope_exactly_after_a_few_tau(tau: float) -> None:
    time = uneven(40 * tau)
    rate = temperature_rate(time, 20 + time / 60 * 1.5, tau)
    late = time > 36 * tau
    assert late.any()
    assert torch.allclose(rate[late], torch.full_like(rate[late], 1.5), rtol=1e-12)


@pytest.mark.parametrize("step", [0.01, 0.5, 10.0, 50.0])
def test_a_step_gives_no_more_than_its_share_whatever_the_sampling(step: float) -> None:
    time = torch.arange(0, 1000, step, dtype=torch.float64)
    rate = temperature_rate(time, torch.where(time >= 100, 0.0625, 0.0).to(torch.float64), TAU)
    bound = 0.0625 / (math.e * TAU) * 60
    assert rate.max() <= bound * (1 + 1e-9)
    if step < 1:  # a fast sampler sees the whole response: the bound is reached, and D·t/τ²·exp(−t/τ) followed
        since = time[time >= 100] - 100 + step / 2
        assert rate.max() == pytest.approx(bound, rel=1e-4)
        assert torch.allclose(rate[time >= 100], 60 * 0.0625 * since / TAU**2 * torch.exp(-since / TAU), atol=bound * step / TAU)


def test_a_quantised_ramp_stays_within_the_stated_bound() -> None:
    """A thermometer's resolution D adds a sawtooth of height D: no more than D/(e·τ) up and down around the slope."""
    time, resolution, slope = torch.arange(0, 7200, 0.5, dtype=torch.float64), 0.0625, 0.5
    truth = slope / 60 * time
    seen = resolution * torch.round(truth / resolution)
    error = (temperature_rate(time, seen, TAU) - temperature_rate(time, truth, TAU)).abs().max()
    assert error <= resolution / (math.e * TAU) * 60
    assert (torch.diff(seen) / 0.5 * 60).max() > 7  # what a plain difference would say of half a kelvin a minute


def test_the_rate_is_late_by_two_tau() -> None:
    time = torch.arange(0, 6000, 1.0, dtype=torch.float64)
    parabola = time**2 / 120
    late = time > 40 * TAU
    assert torch.allclose(temperature_rate(time, parabola, TAU)[late], (time - 2 * TAU)[late], rtol=1e-6)


def test_it_is_causal() -> None:
    time = uneven(2000)
    temperature = torch.sin(time / 200)
    changed = torch.where(time > 1000, temperature + 5, temperature)
    before = time <= 1000
    assert torch.equal(temperature_rate(time, temperature)[before], temperature_rate(time, changed)[before])


def test_refining_straight_lines_changes_nothing() -> None:
    time = uneven(2000, longest=80.0)
    temperature = torch.randn(len(time), generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    finer = torch.cat([time, (time[1:] + time[:-1]) / 2, time[:-1] + 0.1 * torch.diff(time)]).sort().values
    weight = torch.searchsorted(time, finer).clamp(1, len(time) - 1)
    share = (finer - time[weight - 1]) / (time[weight] - time[weight - 1])
    drive = temperature[weight - 1] + share * (temperature[weight] - temperature[weight - 1])
    again = temperature_rate(finer, drive)[torch.searchsorted(finer, time)]
    assert torch.allclose(again, temperature_rate(time, temperature), atol=1e-12)


def test_batches_of_temperatures() -> None:
    time = uneven(500)
    temperatures = torch.stack([torch.sin(time / 50), time / 60])
    both = temperature_rate(time, temperatures, 30.0)
    for found, one in zip(both, temperatures, strict=True):
        torch.testing.assert_close(found, temperature_rate(time, one, 30.0), rtol=1e-12, atol=1e-12)


def test_what_stands_still_has_a_rate_of_exactly_nothing() -> None:
    """Whatever its last digits."""
    time = uneven(500)
    assert not temperature_rate(time, torch.full_like(time, 20.1)).any()


def test_one_sample_has_no_rate() -> None:
    assert temperature_rate(torch.zeros(1), torch.full((1,), 20.0)).tolist() == [0.0]
