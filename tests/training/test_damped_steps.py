"""Levenberg–Marquardt on the weights of a network."""

from __future__ import annotations

from itertools import pairwise

import pytest
import torch
from torch import Generator, Tensor

from zoo.catalog import build
from zoo.training import damped_steps
from zoo.training.damped_steps import descend
from zoo.training.least_squares import LeastSquares
from zoo.training.weights import derivatives, reset, set_weights, weight_vector


def plain(columns: Tensor) -> Tensor:
    return columns


def task(samples: int = 300) -> tuple[Tensor, Tensor]:
    """Features and an error that a small network can follow."""
    features = torch.randn(samples, 2, generator=Generator().manual_seed(1), dtype=torch.float64)
    return features, torch.tanh(features[:, 0] - 0.5) - 0.3 * torch.tanh(2 * features[:, 1] + features[:, 0])


def test_the_jacobian_is_that_of_finite_differences() -> None:
    model, (features, _) = build("model", "bp", hidden=3), task(20)
    reset(model, Generator().manual_seed(2))
    here = weight_vector(model)
    outputs, slopes = derivatives(model, torch.stack([2 * here, here]), features)
    torch.testing.assert_close(outputs[1], model.head(features).detach(), rtol=1e-12, atol=1e-12)
    for k in range(len(here)):
        ends = []
        for step in (1e-6, -1e-6):
            set_weights(model, here + step * torch.eye(len(here), dtype=torch.float64)[k])
            ends.append(model.head(features).detach())
        torch.testing.assert_close(slopes[1, k], (ends[0] - ends[1]) / 2e-6, rtol=1e-6, atol=1e-8)


def test_what_is_linear_is_solved_as_least_squares_solve_it(make_run) -> None:
    run = make_run(noise=0.02, bend=0.1, average_s=10.0)  # a block is a sample: both then have the same mean
    solved, descended = build("model", "polynomial", order=3), build("model", "polynomial", order=3)
    LeastSquares().fit(solved, [run], Generator().manual_seed(1))
    features = run.block_mean_columns(descended.features(run.select(descended.inputs)))
    error = run.block_mean(run.error)
    descended.standardise(features, error)
    left = descend(descended, features, error, plain, 50)
    torch.testing.assert_close(descended.head(features), solved.head(features), rtol=0, atol=1e-6)
    assert left == pytest.approx(float((error - descended.head(features)).detach().square().sum()))


def test_a_network_finds_the_bottom_and_never_goes_up() -> None:
    model, (features, error) = build("model", "bp", hidden=4), task()
    reset(model, Generator().manual_seed(3))
    model.standardise(features, error)
    costs = [descend(model, features, error, plain, 1) for _ in range(80)]
    assert all(after <= before for before, after in pairwise(costs))
    assert costs[-1] < 1e-4 * float((error - error.mean()).square().sum())


def test_weighing_is_obeyed() -> None:
    """Of two halves that contradict each other, the one that weighs a thousand times more is followed."""
    model, (features, _) = build("model", "polynomial"), task(100)
    model.standardise(features, torch.ones(100, dtype=torch.float64))
    target = torch.cat([torch.full((50,), 3.0), torch.full((50,), -3.0)]).double()
    weight = torch.where(torch.arange(100) < 50, 1000.0, 1.0).double().unsqueeze(1)
    descend(model, features, target, lambda columns: weight * columns, 50)
    assert float((model.head(features).detach()[:50] - 3).abs().max()) < 1e-3


def test_samples_in_pieces_take_the_steps_of_all_at_once(monkeypatch) -> None:
    costs = []
    for rows in (300, 37):
        monkeypatch.setattr(damped_steps, "ROWS_OF_COLUMNS", rows)
        model, (features, error) = build("model", "bp", hidden=4), task()
        reset(model, Generator().manual_seed(3))
        model.standardise(features, error)
        costs.append(descend(model, features, error, plain, 6))
    assert costs[1] == pytest.approx(costs[0], rel=1e-8)
