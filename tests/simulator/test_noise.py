"""Noise against the Allan variances of IEEE Std 952, and how it grows in the cold."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
import torch
from torch import Generator, Tensor

from zoo.catalog import build
from zoo.errors import InputError
from zoo.scoring.allan import allan_deviation
from zoo.simulator.noise import SILENT, Noise, counted, flicker, loss_factor, rate_ramp, rate_walk, white
from zoo.simulator.streams import stream

STEP, COUNT, SERIES, SIGMAS = 10.0, 60000, 6, 4.0
OCTAVES = [2**i for i in range(11)]
N, B, K, R, COUNTED = 0.005, 0.01, 0.02, 0.3, 0.02
Q = COUNTED / math.sqrt(12) / 3600
"""[°]: an angle that may lie anywhere within a count has that standard deviation."""


def count_error(generator: Generator) -> Tensor:
    rate = white(N, COUNT, STEP, generator)  # 50 counts a step: each error is new
    return counted(rate, COUNTED, STEP, generator) - rate


PROCESSES: dict[str, Callable[[Generator], Tensor]] = {
    "white": lambda generator: white(N, COUNT, STEP, generator),
    "flicker": lambda generator: flicker(B, COUNT, STEP, generator),
    "walk": lambda generator: rate_walk(K, COUNT, STEP, generator),
    "counting": count_error,
}
LAWS: dict[str, Callable[[Tensor], Tensor]] = {  # Allan variance [(°/h)²] at τ [h]
    "white": lambda tau: N**2 / tau,
    "flicker": lambda tau: 2 * math.log(2) / math.pi * B**2 * torch.ones_like(tau),
    "walk": lambda tau: K**2 * tau / 3,
    "counting": lambda tau: 3 * Q**2 / tau**2,
}


def innovations(process: str, m: int) -> Tensor:
    """What the difference of two neighbouring means over m steps is made of: weights of the independent numbers behind the series."""
    window = torch.cat([-torch.ones(m), torch.ones(m)]).double()
    if process == "walk":
        return window.cumsum(0)
    if process == "counting":
        return torch.diff(window, prepend=torch.zeros(1), append=torch.zeros(1))
    if process == "flicker":  # a half-fold integration (Kasdin 1995, Proc. IEEE 83:802), of which a difference remembers little
        steps = torch.arange(1, 32 * m, dtype=torch.float64)
        half = torch.cat([torch.ones(1), ((steps - 0.5) / steps).cumprod(0)])
        return torch.nn.functional.conv1d(half.view(1, 1, -1), window.flip(0).view(1, 1, -1), padding=2 * m - 1).flatten()[: 32 * m]
    return window


def spread(process: str, m: int) -> float:
    """Relative standard deviation of the overlapping Allan variance, all series together.

    For n Gaussian numbers of autocorrelation r the mean square has the relative variance 2/n²·Σ (n − |j|)·r_j² (Isserlis); for errors of counting,
    which are uniform and have less in their tails, it is less.
    """
    weights, terms = innovations(process, m), COUNT - 2 * m + 1
    power = torch.fft.rfft(weights, n=2 * len(weights)).abs().square()
    squares = (torch.fft.irfft(power, n=2 * len(weights)) / weights.square().sum())[: len(weights)].square()
    lags = torch.arange(len(weights), dtype=torch.float64)
    both_sides = 2.0 - (lags == 0).double()
    return math.sqrt(2 * float((both_sides * (terms - lags).clamp_min(0.0) * squares).sum()) / terms**2 / SERIES)


@pytest.mark.parametrize("process", PROCESSES)
def test_allan_variance_follows_its_law(process: str) -> None:
    series = torch.stack([PROCESSES[process](stream(seed, process)) for seed in range(SERIES)])
    tau, deviation = allan_deviation(series, STEP, OCTAVES)
    ratio = deviation.square().mean(0) / LAWS[process](tau / 3600)
    for m, got in zip(OCTAVES, ratio.tolist(), strict=True):
        assert abs(got - 1) < SIGMAS * spread(process, m), f"{m} steps"


@pytest.mark.parametrize("process", PROCESSES)
def test_allantools_finds_the_same_deviation(process: str) -> None:
    """Where it is installed, as `make bench` does; tests/scoring/test_allan.py holds `allan_deviation` against its numbers."""
    allantools = pytest.importorskip("allantools")
    series = PROCESSES[process](stream(1, process))
    tau, deviation = allan_deviation(series, STEP, OCTAVES)
    assert deviation.tolist() == pytest.approx(allantools.oadev(series.numpy(), 1 / STEP, "freq", tau.numpy())[1].tolist(), rel=1e-9)


@pytest.mark.parametrize("slope", [R, -R])
def test_a_ramp_starts_at_0_and_deviates_by_r_tau_over_root_2(slope: float) -> None:
    ramp = rate_ramp(slope, 4096, STEP)
    tau, deviation = allan_deviation(ramp, STEP, OCTAVES)
    assert deviation.tolist() == pytest.approx((R * tau / 3600 / math.sqrt(2)).tolist(), rel=1e-9)
    assert float(ramp[:360].mean()) == pytest.approx(slope / 2), "the first hour's mean"


def test_white_noise_of_means_is_60_n_over_root_tau() -> None:
    got = float(white(N, COUNT, 100.0, stream(1, "white")).std())
    assert got == pytest.approx(60 * 0.005 / math.sqrt(100), rel=SIGMAS / math.sqrt(2 * COUNT))


@pytest.mark.parametrize("count", [1, 2, 3, 5039, 5040])
def test_flicker_of_any_length(count: int) -> None:
    one = flicker(B, count, STEP, stream(1, "flicker"))
    assert one.shape == (count,)
    assert one.isfinite().all()
    assert torch.equal(one, flicker(B, count, 1.0, stream(1, "flicker"))), "it has no scale of time"


def test_counting_keeps_the_angle() -> None:
    rate = torch.full((5000,), 0.0137, dtype=torch.float64)
    shown = counted(rate, 0.5, STEP, stream(1, "count"))
    assert abs((shown - rate).sum() * STEP) <= 0.5
    steps = shown * STEP / 0.5
    assert torch.equal(steps, steps.round())
    assert counted(rate, 0.0, STEP, stream(1)) is rate


# In the cold


def test_light_is_lost_below_20_degrees() -> None:
    warm, cold = torch.tensor([20.0, 20.1, 85.0]).double(), torch.tensor([-10.0, -40.0, -55.0]).double()
    assert loss_factor(warm, 3.0).tolist() == [1.0, 1.0, 1.0]
    assert loss_factor(cold, 3.0).tolist() == pytest.approx([10 ** (0.75 * 3.0 * share / 20) for share in (0.25, 1.0, 1.5625)], rel=1e-12)
    assert (loss_factor(torch.linspace(-60.0, 20.0, 500).double(), 0.5).diff() < 0).all()
    assert torch.equal(loss_factor(cold, 0.0), torch.ones(3).double())


def test_white_noise_grows_in_the_cold_half_of_a_run() -> None:
    temperature = torch.tensor([25.0, -40.0]).double().repeat_interleave(COUNT // 2)
    factor = loss_factor(temperature, 3.0)
    warm, cold = white(N, COUNT, STEP, stream(1, "white"), factor).chunk(2)
    assert float(cold.std() / warm.std()) == pytest.approx(10 ** (0.75 * 3.0 / 20), rel=SIGMAS / math.sqrt(COUNT / 2))
    torch.testing.assert_close(torch.cat([warm, cold]), factor * white(N, COUNT, STEP, stream(1, "white")), rtol=1e-14, atol=0)


# Settings


def test_streams_depend_on_seed_and_purpose() -> None:
    first = white(1.0, 5, 1.0, stream(1, "a"))
    assert torch.equal(first, white(1.0, 5, 1.0, stream(1, "a")))
    assert not torch.equal(first, white(1.0, 5, 1.0, stream(2, "a")))
    assert not torch.equal(first, white(1.0, 5, 1.0, stream(1, "b")))


@pytest.mark.parametrize("value", [-1.0, math.inf, math.nan, "much", True])
def test_impossible_noise_is_refused(value: object) -> None:
    with pytest.raises(InputError, match="random_walk"):
        Noise(random_walk=value)  # type: ignore[arg-type]


def test_what_no_class_gives_is_a_number() -> None:
    assert Noise(rate_ramp=-0.1).rate_ramp == -0.1
    with pytest.raises(InputError, match=r"rate_ramp=inf: a finite number is expected"):
        Noise(rate_ramp=math.inf)
    with pytest.raises(InputError, match=r"thermometer_c=None: a number from 0 up is possible"):
        Noise(thermometer_c=None)  # type: ignore[arg-type]


def test_the_configs_are_the_defaults_and_silence() -> None:
    assert build("noise", "gyro") == Noise()
    assert build("noise", "none") == SILENT
    assert set(vars(SILENT).values()) == {0.0}
