"""The Allan deviation against published numbers, an independent program and two laws."""

from __future__ import annotations

import math

import allantools
import pytest
import torch

from zoo.scoring.allan import allan_deviation

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


@pytest.mark.parametrize("mean", [0.0, 15.0])
def test_allantools_says_the_same(mean: float) -> None:
    series = torch.randn(4, 1000, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    series = torch.stack([*series, nist_series(), series[0].cumsum(0)]) + mean
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
