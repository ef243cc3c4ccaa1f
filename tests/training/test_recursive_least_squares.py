"""Recursive least squares: the textbook's recursion, and what it must agree with."""

from __future__ import annotations

import pytest
import torch
from torch import Generator, Tensor

from zoo.training.recursive_least_squares import Information, begin, learn


def problem(samples: int = 60, size: int = 5) -> tuple[Tensor, Tensor]:
    chance = Generator().manual_seed(1)
    design = torch.randn(samples, size, generator=chance, dtype=torch.float64)
    return design, design @ torch.arange(1.0, size + 1).double() + 0.3 * torch.randn(samples, generator=chance, dtype=torch.float64)


def recursive_least_squares(design: Tensor, target: Tensor, alpha: float, rows: int = 50) -> Information:
    known = begin(design.shape[1], alpha, design)
    for some, targets in zip(design.split(rows), target.split(rows), strict=True):
        known = learn(known, some, targets)
    return known


@pytest.mark.parametrize("alpha", [0.1, 300.0, 1e6])
def test_it_is_the_recursion_of_the_textbooks_row_by_row(alpha: float) -> None:
    """θ ← θ + P·φ·(y − φᵀθ)/(1 + φᵀPφ), P ← P − P·φ·φᵀ·P/(1 + φᵀPφ), from θ0 = 0 and P0 = αI."""
    design, target = problem()
    theta, covariance = torch.zeros(5, dtype=torch.float64), alpha * torch.eye(5, dtype=torch.float64)
    known = begin(5, alpha, design)
    for row, value in zip(design, target, strict=True):
        gain = covariance @ row / (1 + row @ covariance @ row)
        theta = theta + gain * (value - row @ theta)
        covariance = covariance - torch.outer(gain, row @ covariance)
        known = learn(known, row.unsqueeze(0), value.unsqueeze(0))
        torch.testing.assert_close(known.estimate, theta, rtol=0, atol=1e-13 * alpha + 1e-11)


@pytest.mark.parametrize("alpha", [1e-3, 1.0, 300.0, 1e6])
def test_a_finite_start_is_ridge_regression(alpha: float) -> None:
    design, target = problem()
    ridge = torch.linalg.solve(design.T @ design + torch.eye(5, dtype=torch.float64) / alpha, design.T @ target)
    found = recursive_least_squares(design, target, alpha)
    torch.testing.assert_close(found.estimate, ridge, rtol=1e-11, atol=1e-11)
    assert found.cost == pytest.approx(float((target - design @ ridge).square().sum() + ridge.square().sum() / alpha), rel=1e-11)


def test_from_nothing_known_on_it_is_least_squares() -> None:
    """The distance to the batch's solution falls as 1/α, down to rounding."""
    design, target = problem()
    batch = torch.linalg.lstsq(design, target.unsqueeze(-1), driver="gelsd").solution.squeeze(-1)
    away = [float((recursive_least_squares(design, target, alpha).estimate - batch).norm()) for alpha in (1e2, 1e4, 1e6)]
    assert away[0] / away[1] == pytest.approx(100, rel=0.02)
    assert away[1] / away[2] == pytest.approx(100, rel=0.02)
    torch.testing.assert_close(recursive_least_squares(design, target, 1e30).estimate, batch, rtol=1e-12, atol=1e-12)


def test_the_size_of_the_blocks_and_the_order_of_the_rows_do_not_matter() -> None:
    design, target = problem(3000)
    order = torch.randperm(3000, generator=Generator().manual_seed(2))
    found = recursive_least_squares(design[order], target[order], 1e4, rows=7)
    torch.testing.assert_close(found.estimate, recursive_least_squares(design, target, 1e4, rows=3000).estimate, rtol=1e-12, atol=1e-12)


def test_what_no_row_speaks_of_stays_at_zero_and_twins_share() -> None:
    design, target = problem()
    dependent = torch.cat([design[:, :2], design[:, :1], torch.zeros_like(design[:, :1])], dim=1)
    theta = recursive_least_squares(dependent, target, 300.0).estimate
    assert float(theta[3].abs()) == 0
    assert float(theta[0]) == pytest.approx(float(theta[2]), rel=1e-9)
