"""Weights of the exponential integrator against their definition in many digits."""

from __future__ import annotations

from decimal import Decimal, getcontext

import pytest
import torch

from zoo.physics.exponential import SERIES_BELOW, exponential_weights


@pytest.mark.parametrize("x", [1e-300, 1e-12, 1e-5, 0.99 * SERIES_BELOW, 1.01 * SERIES_BELOW, 0.3, 1.0, 30.0, 1e4])
def test_they_are_what_fifty_digits_say(x: float) -> None:
    getcontext().prec = 700 if x < 1e-100 else 50
    exact = Decimal(x)
    decay = (-exact).exp()
    first = (1 - decay) / exact
    found = exponential_weights(torch.tensor(x, dtype=torch.float64))
    for ours, theirs in zip(found, (decay, first, (1 - first) / exact), strict=True):
        assert float(ours) == pytest.approx(float(theirs), rel=1e-13, abs=0)


def test_without_decay_they_are_one_one_and_a_half() -> None:
    assert [float(one) for one in exponential_weights(torch.zeros((), dtype=torch.float64))] == [1.0, 1.0, 0.5]


def test_gradients_are_those_of_finite_differences() -> None:
    x = torch.tensor([1e-6, 5e-3, 0.02, 0.5, 5.0], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(exponential_weights, (x,), eps=1e-7)
