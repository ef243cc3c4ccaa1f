"""A fuzzy model: what its formula says, near its rules and far from them."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Generator, Tensor

from zoo.catalog import build
from zoo.errors import InputError
from zoo.models.takagi_sugeno import NARROWEST, TakagiSugeno
from zoo.training.population import Population
from zoo.training.weights import reset, set_weights, weight_vector


def drawn(rules: int = 4, seed: int = 3) -> TakagiSugeno:
    """Standardised on features of very different scales, with random weights."""
    model: TakagiSugeno = build("model", "takagi_sugeno", rules=rules)
    reset(model, Generator().manual_seed(seed))
    features = inputs()
    model.standardise(features, 1e-4 * (features[:, 0] - 3 * features[:, 1]) + 0.7)
    return model


def inputs(samples: int = 200) -> Tensor:
    chance = torch.randn(samples, 2, generator=Generator().manual_seed(1), dtype=torch.float64)
    return chance * torch.tensor([25.0, 0.4], dtype=torch.float64) + torch.tensor([15.0, -0.1], dtype=torch.float64)


def test_it_is_the_formula_in_physical_units() -> None:
    model, features = drawn(), inputs(20)
    for row, found in zip(features.tolist(), model.head(features).tolist(), strict=True):
        value = dict(zip(("temperature", "temperature_rate"), row, strict=True))
        weights, planes = [], []
        for rule in model.formula()["rules"]:
            weights.append(math.exp(-sum((value[name] - c) ** 2 / (2 * rule["width"][name] ** 2) for name, c in rule["centre"].items())))
            planes.append(sum(slope * (1.0 if name == "1" else value[name]) for name, slope in rule["consequent"].items()))
        expected = sum(weight * plane for weight, plane in zip(weights, planes, strict=True)) / sum(weights)
        assert found == pytest.approx(expected, rel=1e-10)


def test_one_rule_is_a_plane_wherever_it_stands() -> None:
    model, features = drawn(rules=1), inputs()
    columns = torch.cat([torch.ones_like(features[:, :1]), features], dim=-1)
    plane = torch.tensor(list(model.formula()["rules"][0]["consequent"].values()), dtype=torch.float64)
    torch.testing.assert_close(model.head(features).detach(), columns @ plane, rtol=1e-12, atol=1e-12)


def test_equal_planes_are_that_plane_however_the_rules_stand() -> None:
    """Shares that sum to 1: what all rules say is said."""
    model, features = drawn(), inputs()
    with torch.no_grad():
        model.consequent[:] = torch.tensor([0.3, -1.0, 2.0], dtype=torch.float64)
    one = drawn(rules=1)
    with torch.no_grad():
        one.consequent[:] = model.consequent[:1]
    torch.testing.assert_close(model.head(features), one.head(features), rtol=1e-12, atol=1e-15)


def test_the_columns_carry_the_planes() -> None:
    model, features = drawn(), inputs()
    value = model.columns(features) @ model.consequent.flatten()
    torch.testing.assert_close(model.scaler.restore(value), model.head(features), rtol=1e-12, atol=1e-15)


def test_far_from_all_rules_the_least_far_one_speaks_alone() -> None:
    model = drawn()
    model.set_antecedents(torch.tensor([[-1.0, 0.0], [0.0, 0.0], [0.5, 0.0], [1.0, 0.0]], dtype=torch.float64), torch.full((4, 2), 0.1).double())
    far = model.scaler.centre + model.scaler.scale * torch.tensor([[1e4, 0.0], [-1e4, 0.0]], dtype=torch.float64)
    expected = model.consequent[[3, 0], 0] + model.consequent[[3, 0], 1] * torch.tensor([1e4, -1e4], dtype=torch.float64)
    torch.testing.assert_close(model.head(far), model.scaler.restore(expected), rtol=1e-12, atol=0)
    for gradient in torch.autograd.grad(model.head(far).sum(), list(model.parameters())):
        assert bool(torch.isfinite(gradient).all())


@pytest.mark.parametrize("step", [-1e12, -800.0, 800.0, 1e12])
def test_no_step_of_an_optimizer_makes_a_width_zero_or_infinite(step: float) -> None:
    model, features = drawn(), inputs()
    with torch.no_grad():
        model.free_width += step
    width = model.width()
    assert float(width.detach().min()) >= NARROWEST
    assert bool(torch.isfinite(width).all())
    predicted = model.head(features)
    for tensor in (predicted, *torch.autograd.grad(predicted.sum(), list(model.parameters()))):
        assert bool(torch.isfinite(tensor).all())


def test_widths_come_back_as_they_were_set() -> None:
    model = drawn()
    width = torch.tensor([[0.01, 0.1], [1.0, 5.0], [50.0, 1e4], [NARROWEST / 5, 0.3]], dtype=torch.float64)
    model.set_antecedents(torch.zeros(4, 2, dtype=torch.float64), width)
    width[3, 0] = 2 * NARROWEST
    torch.testing.assert_close(model.width().detach(), width, rtol=1e-9, atol=0)


def test_a_drawn_model_depends_on_the_generator_alone_and_uses_all_its_rules() -> None:
    for seed in range(10):
        model = drawn(seed=seed)
        assert torch.equal(weight_vector(model), weight_vector(drawn(seed=seed)))
        share = model.columns(inputs()).detach()[:, ::3]
        assert float(share.amax(dim=0).min()) > 0.05
    assert not torch.equal(weight_vector(drawn(seed=1)), weight_vector(drawn(seed=2)))


def test_a_population_is_evaluated_as_its_members_one_by_one() -> None:
    model, features = drawn(), inputs(30)
    weights = weight_vector(model) + torch.randn(5, len(weight_vector(model)), generator=Generator().manual_seed(1), dtype=torch.float64)
    for row, expected in zip(weights, Population(model, features).outputs(weights), strict=True):
        set_weights(model, row)
        torch.testing.assert_close(model.head(features).detach(), expected)


def test_no_rule_is_no_model() -> None:
    with pytest.raises(InputError, match=r"model\.rules=0: a whole number from 1 up is possible"):
        TakagiSugeno(["temperature"], rules=0)
