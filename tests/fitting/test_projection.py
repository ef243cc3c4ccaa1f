"""Projection gives what numpy's least squares gives, also where columns say the same thing twice."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from zoo.fitting.projection import complement, log_volume, orthonormal, project


def drawn(*size: int, seed: int = 1) -> Tensor:
    return torch.randn(*size, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def least_squares(columns: Tensor, target: Tensor) -> tuple[np.ndarray, float]:
    """Amplitudes of least norm and the sum of squared residuals, by numpy's SVD."""
    norm = columns.norm(dim=0).clamp_min(1e-300).numpy()
    weights = np.linalg.lstsq(columns.numpy() / norm, target.numpy(), rcond=1e-9)[0]
    return weights / norm, float(np.square(target.numpy() - columns.numpy() / norm @ weights).sum())


@pytest.mark.parametrize("width", [1, 3, 12])
def test_well_posed_columns(width) -> None:
    columns, target = drawn(200, width), drawn(200, seed=2)
    amplitudes, cost = least_squares(columns, target)
    found = project(columns, target)
    np.testing.assert_allclose(found.amplitudes.numpy(), amplitudes, rtol=1e-6)
    assert float(found.cost) == pytest.approx(cost, rel=1e-9)
    torch.testing.assert_close(found.residual, target - columns @ found.amplitudes, rtol=0, atol=1e-9)


def test_columns_of_very_different_size() -> None:
    """Powers of a temperature, 1 to θ³: seven orders of magnitude apart."""
    theta = torch.linspace(-60, 40, 300, dtype=torch.float64)
    columns = torch.stack([1e-3 * theta**k for k in range(4)], -1)
    truth = torch.tensor([50.0, -2.0, 0.03, 1e-4], dtype=torch.float64)
    found = project(columns, columns @ truth + 1e-4 * drawn(300))
    torch.testing.assert_close(found.amplitudes, truth, rtol=0.02, atol=0.05)
    assert float(found.cost) == pytest.approx(least_squares(columns, columns @ truth + 1e-4 * drawn(300))[1], rel=1e-6)


def test_collinear_columns_share_their_amplitude() -> None:
    one, target = drawn(200, 2), drawn(200, seed=2)
    twice = torch.cat([one, 3 * one[:, :1], one[:, :1] - 2 * one[:, 1:]], dim=1)
    found, alone = project(twice, target), project(one, target)
    assert bool(torch.isfinite(found.amplitudes).all())
    assert float(found.cost) == pytest.approx(float(alone.cost), rel=1e-7)
    torch.testing.assert_close(found.residual, alone.residual, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.amplitudes.numpy(), least_squares(twice, target)[0], rtol=1e-3, atol=1e-4)
    double = project(one[:, :1].expand(-1, 2), target).amplitudes
    assert float(double[0]) == pytest.approx(float(double[1]), rel=1e-5)


def test_collinear_columns_are_harmless_in_single_precision() -> None:
    one, target = drawn(200, 2).float(), drawn(200, seed=2).float()
    for twice in (one[:, :1].expand(-1, 2), torch.cat([one, one.sum(1, keepdim=True)], dim=1), torch.cat([one, -3 * one], dim=1)):
        alone = project(one[:, :1] if twice.shape[1] == 2 else one, target)
        assert float(project(twice, target).cost) == pytest.approx(float(alone.cost), rel=1e-5)


@pytest.mark.parametrize("tilt", [1e-3, 1e-4])
def test_nearly_collinear_columns_still_reach_the_least_cost(tilt) -> None:
    one, other, target = drawn(400), drawn(400, seed=3), drawn(400, seed=2)
    columns = torch.stack([one, one + tilt * other], -1)
    assert float(project(columns, target).cost) == pytest.approx(least_squares(columns, target)[1], rel=1e-3)


def test_a_column_of_zeros_gets_a_finite_amplitude_and_changes_nothing() -> None:
    columns, target = drawn(100, 2), drawn(100, seed=2)
    padded = torch.cat([columns, torch.zeros(100, 1, dtype=torch.float64)], dim=1)
    found = project(padded, target)
    assert bool(torch.isfinite(found.amplitudes).all())
    assert float(found.cost) == pytest.approx(float(project(columns, target).cost), rel=1e-12)


@pytest.mark.parametrize("shared", [True, False])
def test_a_batch_is_each_by_itself(shared) -> None:
    columns, target = drawn(5, 100, 3), drawn(100, seed=2) if shared else drawn(5, 100, seed=2)
    batch = project(columns, target)
    assert (batch.amplitudes.shape, batch.residual.shape, batch.cost.shape) == ((5, 3), (5, 100), (5,))
    for i in range(5):
        alone = project(columns[i], target if shared else target[i])
        torch.testing.assert_close(batch.amplitudes[i], alone.amplitudes)
        torch.testing.assert_close(batch.cost[i], alone.cost)


def test_the_units_of_columns_and_target_do_not_matter() -> None:
    columns, target = drawn(100, 3), drawn(100, seed=2)
    plain, scaled = project(columns, target), project(1e-9 * columns, 1e6 * target)
    torch.testing.assert_close(scaled.amplitudes, 1e15 * plain.amplitudes, rtol=1e-9, atol=0)


def test_an_orthonormal_basis_has_the_rank_of_the_columns() -> None:
    columns = drawn(100, 3)
    basis = orthonormal(torch.cat([columns, 1e6 * columns[:, :1], columns[:, 1:2] + columns[:, 2:]], dim=1))
    assert basis.shape == (100, 3)
    torch.testing.assert_close(basis.mT @ basis, torch.eye(3, dtype=torch.float64), rtol=0, atol=1e-10)
    assert float(complement(columns, basis).abs().max()) < 1e-10


def test_what_is_left_outside_a_span_is_orthogonal_to_it_and_stays() -> None:
    basis, columns = orthonormal(drawn(100, 4)), drawn(3, 100, 2, seed=2)
    left = complement(columns, basis)
    assert float((basis.mT @ left).abs().max()) < 1e-12
    torch.testing.assert_close(complement(left, basis), left, rtol=0, atol=1e-12)
    weights = project(torch.cat([basis, columns[0]], 1), drawn(100, seed=5))
    inside = project(left[0], drawn(100, seed=5) - basis @ (basis.mT @ drawn(100, seed=5)))
    assert float(inside.cost) == pytest.approx(float(weights.cost), rel=1e-8), "Frisch–Waugh: as if fitted together"


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_a_column_with_nothing_in_it_explains_nothing(dtype: torch.dtype) -> None:
    """In single precision as well, where no number is so small that it could stand for its length."""
    columns, target = drawn(50, 3).to(dtype), drawn(50, 1, seed=3).squeeze(1).to(dtype)
    with_empty = torch.stack([columns, torch.zeros_like(columns)])
    found = project(with_empty, target)
    assert float(found.cost[1]) == pytest.approx(float(target.square().sum()))
    assert bool((found.amplitudes[1] == 0).all())
    assert float(found.cost[0]) == pytest.approx(float(project(columns, target).cost))


def test_the_volume_makes_the_likelihood_of_what_no_column_reaches() -> None:
    """log|KᵀVK| = log|V| + log|XᵀV⁻¹X| − log|XᵀX| with K an orthonormal basis of all that is orthogonal to X (Harville 1974, Biometrika 61:383)."""
    columns, mixed = 10.0 ** torch.tensor([-6.0, 0.0, 5.0]) * drawn(40, 3), drawn(40, 40, seed=3)
    covariance = mixed @ mixed.mT + torch.eye(40, dtype=torch.float64)
    apart = torch.linalg.svd(columns)[0][:, 3:]
    root = torch.linalg.inv(torch.linalg.cholesky(covariance))
    found = torch.logdet(covariance) + log_volume(root @ columns, columns)[0] - log_volume(columns, columns)[0]
    assert float(found) == pytest.approx(float(torch.logdet(apart.mT @ covariance @ apart)), abs=1e-6)
