"""A population of weights in one pass: the same numbers as one network after another."""

import pytest
import torch
from torch import Tensor, nn

from zoo.models.base import FeatureModel
from zoo.models.bp import BP
from zoo.training import population as module
from zoo.training.population import Population
from zoo.training.weights import set_weights, weight_vector


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
    torch.testing.assert_close(population.costs(weights, lambda some: some.square().mean(-1)), torch.stack(expected).square().mean(-1))
    torch.testing.assert_close(weight_vector(model), weights[-1], rtol=0, atol=0)


def test_other_weights_are_played_from_the_same_tape() -> None:
    model = Odd()
    features, weights = sample(model, 5, 40)
    population = Population(model, features)
    for factor in (1.0, 0.5, -2.0, 0.0):
        expected = Population(model, features).outputs(factor * weights)
        torch.testing.assert_close(population.outputs(factor * weights), expected, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("at_once", [(16, 2048), (3, 7)])
def test_what_a_cost_gets_is_its_own_to_change_and_what_it_gives_is_kept(at_once, monkeypatch) -> None:
    monkeypatch.setitem(module.AT_ONCE, "cpu", at_once)
    model = Odd()
    features, weights = sample(model, 11, 17)
    population = Population(model, features)
    expected = Population(model, features).outputs(weights)
    for _ in range(3):
        torch.testing.assert_close(population.costs(weights, lambda some: some.neg_()), -expected, rtol=1e-13, atol=1e-13)
        first = population.costs(weights, lambda some: some[:, :1])
        population.costs(0.5 * weights, lambda some: some.square_().sum(-1))
        torch.testing.assert_close(first, expected[:, :1], rtol=1e-13, atol=1e-13)
