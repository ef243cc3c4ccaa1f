"""A population of weights in one pass: the same numbers as one network after another."""

import pytest
import torch
from torch import Tensor, nn

from zoo.models.base import FeatureModel
from zoo.models.bp import BP
from zoo.training import population as module
from zoo.training.population import Population
from zoo.training.tape import Tape
from zoo.training.weights import population_outputs, set_weights, weight_vector


class Odd(FeatureModel):
    """Two tanh layers, one without bias, a weight used twice, a parameter of its own, and something that depends on no weight."""

    def __init__(self) -> None:
        super().__init__()
        self.first = nn.Linear(2, 4, dtype=torch.float64)
        self.second = nn.Sequential(nn.Linear(4, 4, bias=False, dtype=torch.float64), nn.Tanh())
        self.again = nn.Linear(2, 4, dtype=torch.float64)
        self.again.weight = self.first.weight
        self.bend = nn.Parameter(torch.zeros(4, dtype=torch.float64))

    def head(self, features: Tensor) -> Tensor:
        joined = torch.cat([self.second(self.first(features).tanh()), torch.cos(self.again(features) * self.bend)], dim=-1)
        return joined.sum(-1) + features.square().sum(-1)


def sample(model: FeatureModel, particles: int, samples: int) -> tuple[Tensor, Tensor]:
    chance = torch.Generator().manual_seed(3)
    features = torch.randn(samples, 2, generator=chance, dtype=torch.float64)
    return features, 4 * torch.rand(particles, len(weight_vector(model)), generator=chance, dtype=torch.float64) - 2


@pytest.mark.parametrize("make", [lambda: BP(["temperature", "temperature_rate"]), Odd])
@pytest.mark.parametrize("at_once", [(16, 2048), (3, 7), (1, 1)])
def test_many_weights_at_once_are_each_of_them_alone(make, at_once, monkeypatch) -> None:
    monkeypatch.setitem(module.AT_ONCE, "cpu", at_once)
    model = make()
    features, weights = sample(model, 11, 17)
    expected = []
    for one in weights:
        set_weights(model, one)
        expected.append(model.head(features).detach())
    population = Population(model, features)
    for _ in range(3):  # as it is, recorded, played
        torch.testing.assert_close(population.outputs(weights), torch.stack(expected), rtol=1e-13, atol=1e-13)
    torch.testing.assert_close(population_outputs(model, weights, features), torch.stack(expected), rtol=1e-13, atol=1e-13)
    torch.testing.assert_close(population.costs(weights, lambda some: some.square().mean(-1)), torch.stack(expected).square().mean(-1))
    torch.testing.assert_close(weight_vector(model), weights[-1], rtol=0, atol=0)


def test_other_weights_are_played_from_the_same_tape() -> None:
    model = Odd()
    features, weights = sample(model, 5, 40)
    population = Population(model, features)
    for factor in (1.0, 0.5, -2.0, 0.0):
        torch.testing.assert_close(
            population.outputs(factor * weights), population_outputs(model, factor * weights, features), rtol=1e-13, atol=1e-13
        )


def test_a_tape_follows_lists_views_and_changes_in_place() -> None:
    fixed = torch.arange(6.0)

    def function(x: Tensor) -> Tensor:
        left, right = x.exp().split([2, 4])
        right.mul_(3)
        return torch.cat([right, left.expand(2), fixed.sqrt()]).view(12).cumsum(dim=0)

    x = torch.linspace(-1, 1, 6)
    tape = Tape(function, x)
    for value in (x, 2 * x, x.flip(0)):
        torch.testing.assert_close(tape(value), function(value), rtol=0, atol=0)


def test_a_tape_plays_gradients_and_several_inputs() -> None:
    def function(x: Tensor, y: Tensor) -> tuple[Tensor, Tensor]:
        here = x.detach().requires_grad_()
        with torch.enable_grad():
            value = ((here.sigmoid() * y).tanh() * here.exp()).sum()
            return value.detach(), torch.autograd.grad(value, here)[0]

    x, y = torch.linspace(-1, 1, 6), torch.linspace(2, 3, 6)
    tape = Tape(function, x, y)
    for given in ((x, y), (2 * x, y - 1), (x.flip(0), y.square())):
        for played, expected in zip(tape(*given), function(*given), strict=True):
            torch.testing.assert_close(played, expected, rtol=0, atol=0)


def test_what_is_written_into_a_constant_is_computed_every_time() -> None:
    def function(x: Tensor) -> Tensor:
        sums = torch.ones(3)
        sums[0] += x.sum()
        return sums.cumsum(0)

    x = torch.linspace(-1, 2, 4)
    tape = Tape(function, x)
    assert not tape.faithful
    for value in (x, 2 * x, x):
        torch.testing.assert_close(tape(value), function(value), rtol=0, atol=0)
