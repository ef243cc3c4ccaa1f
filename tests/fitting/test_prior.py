"""What is known of parameters before: where it decides, and where the runs do."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Generator, Tensor

from zoo.effects.base import Parameter
from zoo.errors import InputError
from zoo.fitting.prior import Prior
from zoo.fitting.variable_projection import fit

LAG = Parameter("lag", 300.0, "s", 5.0, 7200.0, "log", within=3.0)
LEAD = Parameter("lead", -300.0, "s", -3600.0, 3600.0, within=900.0)
ANY = Parameter("any", 2.0, "1", 0.0, 10.0)
TIME = torch.linspace(0.0, 5.0, 400, dtype=torch.float64)


def line(theta: Tensor) -> Tensor:
    """A column exp(−θt), which has no amplitude to hide behind but its own."""
    return torch.exp(-theta.unsqueeze(-1) * TIME.view(1, -1, 1))


def test_a_standard_deviation_is_the_factor_or_the_width_that_is_declared() -> None:
    prior = Prior.of([LAG, LEAD, ANY])
    span = math.log(7200.0 / 5.0)
    center = torch.tensor([math.log(300.0 / 5.0) / span, 3300.0 / 7200.0, 0.7], dtype=torch.float64)
    away = torch.tensor([math.log(3.0) / span, 900.0 / 7200.0, 0.3], dtype=torch.float64)
    assert float(prior.cost(center)) == pytest.approx(0.0, abs=1e-12), "nothing is known of the third"
    moved = torch.stack([center + 2 * torch.eye(3, dtype=torch.float64)[i] * away for i in range(3)])
    torch.testing.assert_close(prior.cost(moved), torch.tensor([4.0, 4.0, 0.0], dtype=torch.float64))


def test_the_slope_is_that_of_the_cost() -> None:
    prior = Prior.of([LAG, LEAD, ANY])
    theta = torch.tensor([0.9, 0.2, 0.4], dtype=torch.float64, requires_grad=True)
    (gradient,) = torch.autograd.grad(prior.cost(theta), theta)
    torch.testing.assert_close(prior.slope(theta.detach()), -0.5 * gradient)


@pytest.mark.parametrize(("scale", "within"), [("log", 1.0), ("log", 0.5), ("linear", -1.0)])
def test_what_is_no_width_is_refused(scale, within) -> None:
    with pytest.raises(InputError, match="within"):
        Parameter("lag", 300.0, "s", 5.0, 7200.0, scale, within=within)


def test_runs_that_say_nothing_leave_a_parameter_where_it_was_expected_with_the_error_that_was_expected() -> None:
    prior = Prior(torch.tensor([0.3], dtype=torch.float64), torch.tensor([1 / 0.1**2], dtype=torch.float64))
    noise = 1e-3 * torch.randn(400, generator=Generator().manual_seed(0), dtype=torch.float64)
    found = fit(line, noise, torch.tensor([0.9], dtype=torch.float64), prior=prior)
    assert float(found.theta) == pytest.approx(0.3, abs=0.01)
    assert math.sqrt(float(found.covariance()[0, 0])) == pytest.approx(0.1, rel=0.05)


def test_runs_that_say_much_are_believed() -> None:
    prior = Prior(torch.tensor([0.3], dtype=torch.float64), torch.tensor([1 / 0.1**2], dtype=torch.float64))
    noise = torch.randn(400, generator=Generator().manual_seed(0), dtype=torch.float64)
    target = 300.0 * line(torch.tensor([[0.8]], dtype=torch.float64))[0, :, 0] + noise
    free, known = (fit(line, target, torch.tensor([0.5], dtype=torch.float64), prior=one) for one in (None, prior))
    error = math.sqrt(float(free.covariance()[0, 0]))
    assert error < 1e-3
    assert abs(float(known.theta - free.theta)) < 0.1 * error
    assert known.total == pytest.approx(known.cost + 25.0, abs=0.1)


def test_between_the_two_precisions_add() -> None:
    """χ² and the prior are both parabolas near their least: the least of their sum is the mean weighted by both."""
    sigma, noise = 0.002, torch.randn(400, generator=Generator().manual_seed(1), dtype=torch.float64)
    target = 300.0 * line(torch.tensor([[0.5]], dtype=torch.float64))[0, :, 0] + noise
    alone = fit(line, target, torch.tensor([0.5], dtype=torch.float64), tolerance=1e-9)
    prior = Prior(alone.theta + sigma, 1.0 / alone.covariance()[0, :1])
    both = fit(line, target, alone.theta, tolerance=1e-9, prior=prior)
    assert float(both.theta - alone.theta) == pytest.approx(0.5 * sigma, rel=0.15)


PAST = Parameter("past", 0.0, "1", -1.0, 1.0, "share")


@pytest.mark.parametrize(("truth", "start"), [(0.6, 0.49), (0.6, 0.51), (0.6, 0.9), (0.3, 0.49), (0.3, 0.1)])
def test_a_share_of_which_the_runs_call_for_none_is_none_and_no_freedom_whatever_side_the_fit_comes_from(truth, start) -> None:
    """Beyond its default it moves nothing, before it a bend that is there or is not."""

    def kinked(theta: Tensor) -> Tensor:
        steady = torch.exp(-TIME).expand(len(theta), -1)
        return (steady + (theta[:, 1:] - 0.5).clamp_max(0.0) * (3.0 * TIME).sin() + 0.1 * theta[:, :1] * TIME).unsqueeze(-1)

    sigma = 0.02
    true = torch.tensor([[0.4, truth]], dtype=torch.float64)
    target = (kinked(true)[0, :, 0] + sigma * torch.randn(len(TIME), generator=Generator().manual_seed(5), dtype=torch.float64)) / sigma
    found = fit(lambda t: kinked(t) / sigma, target, torch.tensor([0.5, start], dtype=torch.float64), prior=Prior.of([ANY, PAST]))
    assert float(found.theta[0]) == pytest.approx(0.4, abs=0.05)
    if truth > 0.5:
        assert float(found.theta[1]) == 0.5
        assert found.moves.tolist() == [[True], [False]]
    else:
        assert float(found.theta[1]) == pytest.approx(truth, abs=0.05)
        assert found.moves.tolist() == [[True], [True]]
