"""The Allan deviation against published numbers, an independent program and two laws."""

from __future__ import annotations

import math

import pytest
import torch

from zoo.scoring.allan import allan_deviation, expected_allan_deviation, pooled_allan_deviation
from zoo.scoring.noise import Blocks, NoiseModel

FACTORS = [1, 2, 3, 8, 30, 100, 499]


def nist_series() -> torch.Tensor:
    """The 1000 frequencies of NIST SP 1065 (Riley 2008), section 12.4: n ← 16807·n mod (2³¹ − 1) from 1234567890, over 2³¹ − 1."""
    numbers = [1234567890]
    while len(numbers) < 1000:
        numbers.append(16807 * numbers[-1] % 2147483647)
    return torch.tensor(numbers, dtype=torch.float64) / 2147483647


def test_published_deviations_of_a_published_series() -> None:
    """NIST SP 1065, table 31, "Overlapping Allan dev", all digits that it prints."""
    tau, deviation = allan_deviation(nist_series(), 1.0, [1, 10, 100])
    assert tau.tolist() == [1.0, 10.0, 100.0]
    assert deviation.tolist() == pytest.approx([2.922319e-01, 9.159953e-02, 3.241343e-02], abs=5e-8)


# allantools 2024.6, oadev(series, rate=0.1, data_type="freq", taus=10 * FACTORS), of the series above and of its running sum.
OADEV = (
    [
        0.29223187810675916,
        0.20101604217093852,
        0.16444561335420452,
        0.10570385007869997,
        0.04887241390833691,
        0.03241343026056983,
        0.0028325053644187113,
    ],
    [0.40187134589165585, 0.7350826420287694, 1.0794030698010575, 2.808265366179429, 10.484204653762932, 35.08628941338731, 173.72459017059768],
)


def test_allantools_said_the_same() -> None:
    series = torch.stack([nist_series(), nist_series().cumsum(0), nist_series() + 15.0])
    tau, deviation = allan_deviation(series, 10.0, FACTORS)
    assert tau.tolist() == [10.0 * factor for factor in FACTORS]
    for ours, theirs in zip(deviation, (*OADEV, OADEV[0]), strict=True):
        assert ours.tolist() == pytest.approx(theirs, rel=1e-9)


def test_allantools_says_the_same() -> None:
    """Where it is installed, as `make bench` does."""
    allantools = pytest.importorskip("allantools")
    series = torch.randn(4, 1000, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    tau, deviation = allan_deviation(series, 10.0, FACTORS)
    for one, ours in zip(series, deviation, strict=True):
        taus, theirs, _, _ = allantools.oadev(one.numpy(), rate=0.1, data_type="freq", taus=tau.numpy())
        assert taus.tolist() == tau.tolist()
        assert ours.tolist() == pytest.approx(theirs.tolist(), rel=1e-9)


def test_a_constant_is_steady_and_a_ramp_drifts_by_its_slope() -> None:
    hours = torch.arange(600, dtype=torch.float64) / 360
    tau, deviation = allan_deviation(torch.stack([torch.full_like(hours, 0.1), 0.3 * hours]), 10.0, [1, 7, 200])
    assert deviation[0].tolist() == pytest.approx([0.0, 0.0, 0.0], abs=1e-14)
    assert deviation[1].tolist() == pytest.approx((0.3 * tau / 3600 / math.sqrt(2)).tolist(), rel=1e-9)


def test_too_short_a_series_has_no_deviation() -> None:
    _, deviation = allan_deviation(nist_series()[:20].expand(2, 3, 20), 1.0, [10, 11, 40])
    assert deviation.shape == (2, 3, 3)
    assert torch.equal(deviation.isnan(), torch.tensor([False, True, True]).expand(2, 3, 3))


def test_pieces_are_pooled_by_their_second_differences() -> None:
    """Twice the same says the same; of pieces too short for a factor nothing is asked."""
    series = nist_series()
    _, alone = allan_deviation(series, 1.0, FACTORS)
    tau, twice = pooled_allan_deviation([series, series, series[:3]], 1.0, FACTORS[3:])
    assert tau.tolist() == FACTORS[3:]
    assert twice.tolist() == pytest.approx(alone[3:].tolist(), rel=1e-12)
    _, one = pooled_allan_deviation([series[:300], series[600:]], 1.0, [1])
    angles = [torch.nn.functional.pad(piece.cumsum(0), (1, 0)).diff(n=2) for piece in (series[:300], series[600:])]
    assert float(one) == pytest.approx(float(torch.cat(angles).square().mean() / 2) ** 0.5, rel=1e-12)
    assert torch.isnan(pooled_allan_deviation([series[:9]], 1.0, [5])[1]).all()


@pytest.mark.parametrize(("noise", "within"), [(NoiseModel(0.01, 0.0), 1e-9), (NoiseModel(0.0, 0.01), 0.12), (NoiseModel(0.0, 0.0, 0.02), 0.02)])
def test_expected_deviations_are_those_of_the_covariance(noise: NoiseModel, within: float) -> None:
    """E σ² of means over m blocks is half the variance of the difference of two neighbours, from the covariance of all blocks."""
    blocks = Blocks(100.0 * torch.arange(256, dtype=torch.float64), torch.ones(256, dtype=torch.float64))
    covariance = noise.covariance(blocks)
    for m in (8, 32, 64):
        difference = torch.zeros(256, dtype=torch.float64)
        difference[:m], difference[m : 2 * m] = -1 / m, 1 / m
        found = float((difference @ covariance @ difference / 2).sqrt())
        tau = torch.tensor([100.0 * m], dtype=torch.float64)
        assert float(expected_allan_deviation(tau, 100.0, noise.white, noise.flicker, noise.walk)) == pytest.approx(found, rel=within)
