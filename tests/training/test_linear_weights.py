"""Weights that a model is linear in, solved for."""

import torch
from torch import Generator, Tensor

from zoo.models.bp import BP
from zoo.models.wavelet import Wavelet
from zoo.training.linear_weights import LinearWeights
from zoo.training.population import Population
from zoo.training.problem import Problem

FEATURES = ["temperature", "temperature_rate"]


def drawn(problem: Problem, members: int) -> Tensor:
    return torch.randn(members, problem.size, generator=Generator().manual_seed(1), dtype=torch.float64)


def test_they_are_those_of_least_squares(make_run) -> None:
    """Against LAPACK's solution by singular values, with columns by differences."""
    for model in (BP(FEATURES, hidden=4), Wavelet(FEATURES, hidden=3, linear=True)):
        problem = Problem.of_runs(model, [make_run(bend=0.5, noise=0.05)])
        weights = drawn(problem, 3)
        found, losses = problem.solved(weights)
        index = problem.linear.index
        torch.testing.assert_close(losses, problem.losses(found), rtol=1e-10, atol=0)
        kept = torch.ones(problem.size).index_fill(0, index, 0).bool()
        assert torch.equal(found[:, kept], weights[:, kept])
        for one, loss in zip(weights, losses, strict=True):
            unit = torch.eye(problem.size, dtype=torch.float64)[index]
            population = Population(problem.model, problem.features)
            here = population.outputs(one.unsqueeze(0))
            columns, target = population.outputs(one + unit) - here, problem.error - here[0]
            best = torch.linalg.lstsq(columns.mT, target.unsqueeze(-1), driver="gelsd").solution
            left = (target - (best.mT @ columns)[0]).square().mean() / problem.scale**2
            torch.testing.assert_close(loss, left, rtol=1e-9, atol=0)


def test_nodes_that_are_alike_or_never_change_hurt_nobody(make_run) -> None:
    problem = Problem.of_runs(BP(FEATURES, hidden=4), [make_run(bend=0.5, noise=0.05)])
    weights = drawn(problem, 3)
    weights[1, :8], weights[1, 8:12] = 0.0, 40.0  # all four nodes are 1 throughout
    weights[2] = torch.inf
    found, losses = problem.solved(weights)
    alone, loss = problem.solved(weights[:1])
    torch.testing.assert_close(found[0], alone[0], rtol=1e-9, atol=1e-9)
    torch.testing.assert_close(losses[0], loss[0], rtol=1e-9, atol=0)
    assert abs(float(losses[1]) - 1) < 1e-9  # the variance, which a constant leaves
    assert bool(found[1].isfinite().all())
    assert not bool(losses[2].isfinite())


def test_columns_are_the_same_recorded_or_not(make_run) -> None:
    problem = Problem.of_runs(BP(FEATURES), [make_run(bend=0.5)])
    linear, weights = LinearWeights(problem.model), drawn(problem, 2)
    first = linear.columns(weights, problem.features)
    linear.columns(2 * weights, problem.features)
    for again, once in zip(linear.columns(weights, problem.features), first, strict=True):
        torch.testing.assert_close(again, once, rtol=1e-12, atol=1e-12)
