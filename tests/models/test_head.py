"""A model as a function of its weights is the model with these weights written into it."""

import pytest
import torch
from torch import Generator, Tensor, nn

from zoo.models.base import FeatureModel, Model
from zoo.models.bp import BP
from zoo.models.head import Head, as_parameters, weights_of
from zoo.models.ls_svm import LsSvm
from zoo.training.weights import set_weights


class Shared(Model):
    """No map of features; one number, and a weight that two layers share."""

    def __init__(self) -> None:
        super().__init__()
        self.inputs = ["time_s", "temperature_c"]
        self.bend = nn.Parameter(torch.tensor(0.5, dtype=torch.float64))
        self.first, self.second = nn.Linear(2, 1, dtype=torch.float64), nn.Linear(2, 1, dtype=torch.float64)
        self.second.weight = self.first.weight

    def forward(self, x: Tensor) -> Tensor:
        return (self.first(x) + torch.cos(self.bend * self.second(x))).squeeze(-1)


@pytest.mark.parametrize("model", [BP(["temperature", "temperature_rate"]), Shared(), LsSvm(["temperature", "temperature_rate"])])
def test_other_weights_are_those_written_into_it(model: Model) -> None:
    head, chance = Head(model), Generator().manual_seed(1)
    weights, given = torch.randn(head.size, generator=chance, dtype=torch.float64), torch.randn(9, 2, generator=chance, dtype=torch.float64)
    before, found = weights_of(model), head.outputs(weights, given)
    assert torch.equal(weights_of(model), before)
    set_weights(model, weights)
    assert torch.equal(weights_of(model), weights)
    assert torch.equal(found, model.head(given) if isinstance(model, FeatureModel) else model(given))


def test_parameters_lie_in_a_vector_one_after_the_other_along_its_last_axis() -> None:
    shapes = {"matrix": torch.Size([2, 3]), "number": torch.Size([]), "none": torch.Size([1, 0])}
    vectors = torch.arange(14).view(2, 7)
    found = as_parameters(vectors, shapes)
    assert {name: one.shape for name, one in found.items()} == {name: (2, *shape) for name, shape in shapes.items()}
    assert found["matrix"][1].tolist() == [[7, 8, 9], [10, 11, 12]]
    assert found["number"].tolist() == [6, 13]
    assert found["number"][0].data_ptr() == vectors[0, 6].data_ptr()
