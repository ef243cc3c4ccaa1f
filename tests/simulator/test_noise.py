"""Noise against the Allan variances of IEEE Std 952, by an overlapping Allan deviation written here (NIST SP 1065, eq. 11)."""

from __future__ import annotations

import math

import pytest
import torch

from zoo.errors import InputError
from zoo.simulator.noise import Noise, counted, flicker, rate_walk, white
from zoo.simulator.streams import stream

STEP, COUNT = 10.0, 60000


def allan(rate: torch.Tensor, m: int) -> float:
    angle = torch.cat([torch.zeros(1, dtype=rate.dtype), torch.cumsum(rate, 0)])
    second = angle[2 * m :] - 2 * angle[m:-m] + angle[: -2 * m]
    return float((second**2).mean().sqrt() / (math.sqrt(2) * m))


@pytest.mark.parametrize("m", [1, 10, 100])
def test_white_noise_is_60_n_over_root_tau(m: int) -> None:
    got = allan(white(0.005, COUNT, STEP, stream(1, "white")), m)
    assert got == pytest.approx(60 * 0.005 / math.sqrt(m * STEP), rel=0.02 * math.sqrt(m))


@pytest.mark.parametrize("m", [4, 30, 300])
def test_flicker_is_flat_at_its_floor(m: int) -> None:
    got = [allan(flicker(0.01, COUNT, STEP, stream(seed, "flicker")), m) for seed in range(6)]
    assert sum(got) / len(got) == pytest.approx(0.01 * math.sqrt(2 * math.log(2) / math.pi), rel=0.05)


@pytest.mark.parametrize("m", [1, 10, 100])
def test_rate_random_walk_grows_with_root_tau(m: int) -> None:
    got = [allan(rate_walk(0.02, COUNT, STEP, stream(seed, "walk")), m) for seed in range(6)]
    tau_h = m * STEP / 3600
    assert sum(got) / len(got) == pytest.approx(0.02 * math.sqrt(tau_h / 3), rel=0.05)


def test_counting_keeps_the_angle() -> None:
    rate = torch.full((5000,), 0.0137, dtype=torch.float64)
    shown = counted(rate, 0.5, STEP, stream(1, "count"))
    assert abs((shown - rate).sum() * STEP) <= 0.5
    steps = shown * STEP / 0.5
    assert torch.equal(steps, steps.round())
    assert counted(rate, 0.0, STEP, stream(1)) is rate


def test_streams_depend_on_seed_and_purpose() -> None:
    first = white(1.0, 5, 1.0, stream(1, "a"))
    assert torch.equal(first, white(1.0, 5, 1.0, stream(1, "a")))
    assert not torch.equal(first, white(1.0, 5, 1.0, stream(2, "a")))
    assert not torch.equal(first, white(1.0, 5, 1.0, stream(1, "b")))


@pytest.mark.parametrize("value", [-1.0, math.inf, math.nan, "much"])
def test_impossible_noise_is_refused(value: object) -> None:
    with pytest.raises(InputError, match="random_walk"):
        Noise(random_walk=value)  # type: ignore[arg-type]
