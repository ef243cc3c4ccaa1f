"""Prefix doubling gives what a plain loop gives."""

from __future__ import annotations

import math

import pytest
import torch

from zoo.physics.recurrence import affine, clamped, decaying

LENGTHS = [1, 2, 3, 7, 64, 1000]
LARGE = 6007
"""Three times that is gone through in groups, the last of them not full."""


@pytest.mark.parametrize("least", [-1.0, 0.999])
@pytest.mark.parametrize("length", [*LENGTHS, LARGE])
def test_affine_is_the_loop(length: int, least: float) -> None:
    """Where every step forgets much, and where hundreds do not."""
    random = torch.Generator().manual_seed(length)
    gain = least + (1 - least) * torch.rand(3, length, generator=random, dtype=torch.float64)
    offset = torch.randn(3, length, generator=random, dtype=torch.float64)
    start = torch.randn(3, generator=random, dtype=torch.float64)
    state, states = start, []
    for k in range(length):
        state = gain[:, k] * state + offset[:, k]
        states.append(state)
    assert torch.allclose(affine(gain, offset, start), torch.stack(states, -1), atol=1e-12)


@pytest.mark.parametrize("length", [0, *LENGTHS, 40_000])
@pytest.mark.parametrize("even", [True, False])
def test_decays_are_the_same_without_the_doubling(length: int, even: bool) -> None:
    """Slow, fast, and so fast that nothing is left after a step, together and alone."""
    random = torch.Generator().manual_seed(length)
    steps = torch.ones(length, dtype=torch.float64) if even else 0.1 - torch.log(torch.rand(length, generator=random, dtype=torch.float64))
    rate = torch.tensor([1e-4, 0.03, 0.3, 30.0, 800.0], dtype=torch.float64).unsqueeze(-1) * steps
    offset = torch.randn(5, length, generator=random, dtype=torch.float64)
    start = torch.randn(5, generator=random, dtype=torch.float64)
    expected = affine(torch.exp(-rate), offset, start)
    rounding = 1e-12 * float(expected.abs().max().clamp_min(1.0)) if length else 0.0
    torch.testing.assert_close(decaying(rate, offset, start), expected, rtol=1e-12, atol=rounding)
    for k in range(5):
        torch.testing.assert_close(decaying(rate[k], offset[k], start[k]), expected[k], rtol=1e-12, atol=rounding)
    torch.testing.assert_close(decaying(rate, offset[0], start), affine(torch.exp(-rate), offset[0], start), rtol=1e-12, atol=rounding)
    torch.testing.assert_close(decaying(rate.float(), offset.float(), start.float()), expected.float(), rtol=1e-4, atol=3e-5)


def test_a_decay_that_is_no_number_leaves_the_others_alone() -> None:
    rate, offset = torch.tensor([[math.nan], [0.5], [math.inf]], dtype=torch.float64).expand(3, 3000), torch.ones(3000, dtype=torch.float64)
    lost, kept, gone = decaying(rate, offset, torch.zeros(3, dtype=torch.float64))
    assert bool(lost.isnan().all())
    assert float(kept[-1]) == pytest.approx(1 / (1 - math.exp(-0.5)), rel=1e-12)
    assert gone.tolist() == [1.0] * 3000


def test_what_was_large_long_ago_leaves_no_rounding() -> None:
    """Two hundred time constants after offsets of 1e12 the states are those of the small ones alone, in whichever group."""
    rate = torch.full((60_000,), 0.1, dtype=torch.float64)
    offset = torch.where(torch.arange(60_000) < 50_000, 1e12, 1.0).double()
    later = decaying(rate, offset, torch.zeros((), dtype=torch.float64))[52_000:]
    torch.testing.assert_close(later, torch.full_like(later, -1 / math.expm1(-0.1)), rtol=1e-11, atol=0.0)


def test_the_rounding_of_a_long_sum_does_not_grow_with_its_length() -> None:
    rate, offset = (torch.full((1_000_000,), value, dtype=torch.float64) for value in (8.3e-5, 1.0))
    last = decaying(rate, offset, torch.zeros((), dtype=torch.float64))[-1]
    assert float(last) == pytest.approx(-1 / math.expm1(-8.3e-5), rel=2e-12)


def test_the_narrower_of_two_precisions_has_room() -> None:
    rate, offset = torch.full((2000,), 0.1), torch.ones(2000, dtype=torch.float64)
    last = decaying(rate, offset, torch.zeros((), dtype=torch.float64))[-1]
    assert float(last) == pytest.approx(-1 / math.expm1(-0.1), rel=1e-5)


@pytest.mark.parametrize("size", [1e-3, 0.4, 60.0])
def test_decays_have_their_slopes(size: float) -> None:
    """In one sum, in groups, and where nothing is left; against differences."""
    random = torch.Generator().manual_seed(1)
    rate, offset = (size * torch.rand(2, 1500, generator=random, dtype=torch.float64), torch.randn(2, 1500, generator=random, dtype=torch.float64))
    start, weights = torch.ones(2, dtype=torch.float64), torch.randn(2, 1500, generator=random, dtype=torch.float64)
    factor = torch.ones((), dtype=torch.float64, requires_grad=True)
    (decaying(factor * rate, offset, start) * weights).sum().backward()
    above, below = ((affine(torch.exp(-at * rate), offset, start) * weights).sum() for at in (1.00001, 0.99999))
    assert float(factor.grad) == pytest.approx(float(above - below) / 2e-5, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("half", [1.0, 30.0])
@pytest.mark.parametrize("length", [*LENGTHS, LARGE])
def test_clamped_is_the_loop(length: int, half: float) -> None:
    """Where every few steps meet a bound, and where hundreds do not."""
    random = torch.Generator().manual_seed(length)
    middle = torch.cumsum(torch.randn(3, length, generator=random, dtype=torch.float64), -1)
    low, high = middle - half, middle + half * (1 + torch.rand(3, length, generator=random, dtype=torch.float64)) / 2
    start = torch.randn(3, generator=random, dtype=torch.float64)
    state, states = start, []
    for k in range(length):
        state = torch.minimum(torch.maximum(state, low[:, k]), high[:, k])
        states.append(state)
    assert torch.equal(clamped(low, high, start), torch.stack(states, -1))


def test_one_gain_serves_a_batch() -> None:
    gain, offset = torch.tensor([0.5, 0.5, 0.5]), torch.tensor([[1.0, 1.0, 1.0], [2.0, 2.0, 2.0]])
    assert affine(gain, offset, torch.zeros(2)).tolist() == [[1.0, 1.5, 1.75], [2.0, 3.0, 3.5]]
