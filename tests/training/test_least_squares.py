"""Closed form: exact where the model is linear, refused where it is not."""

import pytest
import torch

from zoo.errors import InputError
from zoo.models.bp import BP
from zoo.models.polynomial import Polynomial
from zoo.training.least_squares import LeastSquares, solve
from zoo.training.variable_projection import VariableProjection

FEATURES = ["temperature", "temperature_rate"]


def chance() -> torch.Generator:
    return torch.Generator().manual_seed(1)


@pytest.mark.parametrize(("order", "rate_order"), [(1, 1), (4, 4), (7, 2)])
def test_planted_coefficients_come_back(make_run, order: int, rate_order: int) -> None:
    model = Polynomial(FEATURES, order, rate_order)
    LeastSquares().fit(model, [make_run(), make_run("run_2", high=60.0)], chance())
    found = model.formula()["coefficients"]
    expected = {"1": 0.3, "temperature": 0.02, "temperature_rate": -0.15}
    assert len(found) == 1 + order + rate_order
    for name, value in found.items():
        assert value == pytest.approx(expected.get(name, 0.0), abs=1e-7)


def test_the_solution_is_the_minimum_of_what_is_judged(make_run) -> None:
    """The block means of the prediction, which with powers of a rate are not the prediction of the block means."""
    run = make_run(noise=0.1, bend=0.5)
    model = Polynomial(FEATURES, 2, 4)
    LeastSquares().fit(model, [run], chance())
    fine, error = model.features(run.select(model.inputs)), run.block_mean(run.error)
    (gradient,) = torch.autograd.grad((run.block_mean(model.head(fine)) - error).square().mean(), model.weight)
    (other,) = torch.autograd.grad((model.head(run.block_mean_columns(fine)) - error).square().mean(), model.weight)
    assert float(gradient.abs().max()) < 1e-11
    assert float(other.abs().max()) > 1e-6


def test_a_run_at_one_temperature_gives_its_mean(make_run) -> None:
    run = make_run(low=20.0, high=20.0)
    model = Polynomial(FEATURES)
    LeastSquares().fit(model, [run], chance())
    torch.testing.assert_close(model(run.select(model.inputs)), torch.full_like(run.error, 0.7), atol=1e-9, rtol=0)


def test_dependent_columns_get_the_shortest_solution() -> None:
    column = torch.tensor([1.0, 2.0, 3.0], dtype=torch.float64)
    weights = solve(torch.stack([column, 1000 * column, 0 * column], dim=-1), 2 * column)
    torch.testing.assert_close(weights, torch.tensor([1.0, 1e-3, 0.0], dtype=torch.float64))


def test_a_network_is_refused(make_run) -> None:
    with pytest.raises(InputError, match=r"BP, which is not linear.*adam"):
        LeastSquares().fit(BP(FEATURES), [make_run()], chance())


@pytest.mark.parametrize("iterations", [0, -5, 2.5, "abc"])
def test_steps_of_a_grey_boxs_fit_are_a_whole_number(iterations) -> None:
    with pytest.raises(InputError, match=r"optimizer\.iterations"):
        VariableProjection(iterations)
