"""Intervals of an RMS from correlated blocks cover what was planted; independent blocks give what the textbook says."""

import math

import pytest
import torch

from zoo.scoring.batches import autocorrelation_time, ratio_interval, rms_interval, student


def walk(count: int, memory: float, seed: int) -> torch.Tensor:
    """First-order Markov noise of variance 1 whose neighbours correlate by `memory`."""
    steps = torch.randn(count, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    steps[1:] *= math.sqrt(1 - memory**2)
    for i in range(1, count):
        steps[i] += memory * steps[i - 1]
    return steps


@pytest.mark.parametrize(("memory", "least"), [(0.0, 0.90), (0.8, 0.88)])
def test_the_interval_covers_the_true_rms(memory: float, least: float) -> None:
    covered = 0
    for trial in range(150):
        interval = rms_interval([walk(400, memory, trial), walk(200, memory, 10_000 + trial)])
        assert interval is not None
        covered += interval[0] <= 1.0 <= interval[1]
    assert least * 150 <= covered


def test_what_remembers_for_a_tenth_of_the_run_has_few_batches() -> None:
    """Sixteen would be as short as the memory, and their scatter leave the truth outside of one interval in five."""
    found = [rms_interval([walk(300, 0.95, trial)]) for trial in range(150)]
    assert sum(one is not None and one[0] <= 1.0 <= one[1] for one in found) >= 0.84 * 150


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_autocorrelation_time_as_in_the_closed_form(memory: float) -> None:
    """(1 + ρ)/(1 − ρ) of a Markov process."""
    found = [autocorrelation_time([walk(4000, memory, trial), walk(2000, memory, 1000 + trial)]) for trial in range(20)]
    assert sum(found) / 20 == pytest.approx((1 + memory) / (1 - memory), rel=0.1)


def test_correlation_widens_it_as_the_theory_says() -> None:
    """Bartlett's factor of squares of a Markov process, (1 + ρ²)/(1 − ρ²), on the variance: 4.56 at ρ = 0.8."""

    def width(memory: float) -> float:
        found = [rms_interval([walk(1600, memory, trial)]) for trial in range(60)]
        return sum(math.log(one[1] / one[0]) for one in found if one is not None) / len(found)

    assert width(0.8) / width(0.0) == pytest.approx(math.sqrt(1.64 / 0.36), rel=0.12)


def test_noise_alone_is_the_narrowest_it_can_be() -> None:
    interval = rms_interval([walk(1600, 0.0, 1)], samples=50)
    assert interval is not None
    assert math.log(interval[1] / interval[0]) >= 2 * 1.95 * math.sqrt(0.5 / 50)


def test_what_both_fail_at_counts_for_neither() -> None:
    """Two residuals with a common part far larger than their own: only the comparison block by block finds the difference."""
    common, own = 3 * walk(800, 0.9, 1), walk(800, 0.0, 2)
    better, worse = common, common + own
    ratio = ratio_interval([better], [worse])
    single = rms_interval([better])
    assert ratio is not None
    assert single is not None
    assert ratio[1] < 1
    assert math.log(ratio[1] / ratio[0]) < 0.5 * math.log(single[1] / single[0])


def test_identical_residuals_have_a_ratio_of_one_exactly() -> None:
    left = [walk(100, 0.5, 1), walk(60, 0.5, 2)]
    assert ratio_interval(left, left) == (1.0, 1.0)


def test_order_of_the_runs_does_not_matter() -> None:
    a, b = [walk(300, 0.5, 1), walk(200, 0.5, 2)], [walk(300, 0.5, 3), walk(200, 0.5, 4)]
    assert ratio_interval(a, b) == pytest.approx(ratio_interval(a[::-1], b[::-1]))


def test_too_short_for_an_interval() -> None:
    assert rms_interval([walk(5, 0.0, 1)]) is None
    assert ratio_interval([torch.zeros(50)], [torch.ones(50)]) is None


@pytest.mark.parametrize(("freedom", "value"), [(3, 3.18245), (5, 2.57058), (9, 2.26216), (15, 2.13145), (100, 1.98397)])
def test_student_as_in_the_tables(freedom: int, value: float) -> None:
    assert student(freedom) == pytest.approx(value, rel=5e-3)
