"""Spread over seeds and the contest of two methods, on planted values."""

import pytest
import torch

from zoo.scoring.seeds import ENOUGH, contest, spread


def chance(seed: int) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def drawn(median: float, sigma: float, count: int, seed: int) -> torch.Tensor:
    """Lognormal RMS of one method's seeds."""
    return median * torch.exp(sigma * torch.randn(count, generator=chance(seed), dtype=torch.float64))


def by_seed(values: torch.Tensor) -> dict[int, float]:
    return dict(enumerate(values.tolist()))


def test_the_interval_covers_the_planted_median() -> None:
    covered = 0
    for trial in range(200):
        interval = spread(drawn(0.03, 0.3, 40, trial), chance(trial)).interval
        assert interval is not None
        covered += interval[0] <= 0.03 <= interval[1]
    assert 182 <= covered <= 198  # 95 % of 200, within four standard deviations


def test_the_range_holds_nine_in_ten_seeds() -> None:
    found = spread(torch.arange(101, dtype=torch.float64), chance(1))
    assert (found.low, found.median, found.high) == (5.0, 50.0, 95.0)


def test_the_interval_covers_the_planted_ratio() -> None:
    covered = 0
    for trial in range(100):
        shared = drawn(1.0, 0.3, 60, 1000 + trial)
        found = contest(by_seed(0.8 * shared * drawn(1.0, 0.1, 60, 2000 + trial)), by_seed(shared * drawn(1.0, 0.1, 60, 3000 + trial)), chance(trial))
        assert found.interval is not None
        covered += found.interval[0] <= 0.8 <= found.interval[1]
    assert covered >= 88


def test_pairing_tells_what_single_seeds_do_not() -> None:
    """Where a seed makes the same of both, the pair's interval is a fraction of that of the two by themselves."""
    shared = drawn(1.0, 0.5, 50, 1)
    first, second = 0.9 * shared * drawn(1.0, 0.02, 50, 2), shared
    paired = contest(by_seed(first), by_seed(second), chance(1))
    apart = contest(by_seed(first), {seed + 100: value for seed, value in by_seed(second).items()}, chance(1))
    assert paired.interval is not None
    assert apart.interval is not None
    assert paired.paired
    assert not apart.paired
    assert paired.interval[1] < 1 < apart.interval[1]
    assert paired.interval[1] - paired.interval[0] < 0.5 * (apart.interval[1] - apart.interval[0])
    assert paired.wins == int((first < second).sum())


def test_equal_methods_tie_and_alike_ones_are_open() -> None:
    values = by_seed(drawn(1.0, 0.2, 30, 1))
    same = contest(values, values, chance(1))
    assert (same.ratio, same.interval, same.wins, same.ties) == (1.0, (1.0, 1.0), 0, 30)
    decided = 0
    for trial in range(100):
        found = contest(by_seed(drawn(1.0, 0.2, 30, 5000 + trial)), by_seed(drawn(1.0, 0.2, 30, 7000 + trial)), chance(trial))
        assert found.interval is not None
        decided += not found.interval[0] <= 1 <= found.interval[1]
    assert decided <= 11


@pytest.mark.parametrize("count", [2, ENOUGH - 1, ENOUGH])
def test_a_few_seeds_give_no_interval(count: int) -> None:
    values = drawn(1.0, 0.2, count, 1)
    enough = count >= ENOUGH
    assert (spread(values, chance(1)).interval is not None) == enough
    assert (contest(by_seed(values), by_seed(2 * values), chance(1)).interval is not None) == enough
    assert (contest(by_seed(values), {0: 3.0}, chance(1)).interval is not None) == enough  # against one without a seed


def test_against_a_constant_every_seed_counts_once() -> None:
    found = contest(by_seed(torch.tensor([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])), {0: 4.5}, chance(1))
    assert (found.wins, found.seeds, found.ratio) == (4, 6, pytest.approx(3.5 / 4.5))


def test_turned_round_the_contest_is_the_inverse() -> None:
    first, second = by_seed(drawn(1.0, 0.2, 30, 1)), by_seed(drawn(1.1, 0.2, 30, 2))
    here, there = contest(first, second, chance(1)), contest(second, first, chance(1))
    assert here.ratio == pytest.approx(1 / there.ratio)
    assert here.interval is not None
    assert there.interval is not None
    assert here.interval == pytest.approx((1 / there.interval[1], 1 / there.interval[0]), rel=1e-2)
    assert here.wins == there.seeds - there.wins - there.ties
