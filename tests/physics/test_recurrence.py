"""Prefix doubling gives what a plain loop gives."""

from __future__ import annotations

import pytest
import torch

from zoo.physics.recurrence import affine, clamped, geometric

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


@pytest.mark.parametrize("length", [*LENGTHS, 24 * 64, 24 * 64 + 1, 40_000])
def test_one_gain_at_every_step_is_the_same_without_the_doubling(length: int) -> None:
    """Slow, fast, and so fast that nothing is left after a step."""
    random = torch.Generator().manual_seed(length)
    rate = torch.tensor([1e-4, 0.3, 800.0], dtype=torch.float64)
    offset = torch.randn(3, length, generator=random, dtype=torch.float64)
    start = torch.randn(3, generator=random, dtype=torch.float64)
    expected = affine(torch.exp(-rate).unsqueeze(-1).expand(3, length), offset, start)
    rounding = 1e-12 * float(expected.abs().max().clamp_min(1.0))
    torch.testing.assert_close(geometric(rate, offset, start), expected, rtol=1e-12, atol=rounding)
    torch.testing.assert_close(geometric(rate[1], offset[1], start[1]), expected[1], rtol=1e-12, atol=rounding)


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
