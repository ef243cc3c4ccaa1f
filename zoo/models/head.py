"""A model as a function of its weights: all of them in one vector, parameter by parameter."""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.func import functional_call

from zoo.models.base import FeatureModel, Model


class Head(nn.Module):
    """The part of a model that its weights are in: a map of features is not asked for its features again.

    Attributes:
        shapes: of the parameters, by the names that they have in here.
        size: D, the number of weights.
    """

    prefix = "model."
    """Before the names that the model's parameters have of their own."""

    def __init__(self, model: Model) -> None:
        """Wrap a model, which lends its structure and its buffers."""
        super().__init__()
        self.model = model
        self.shapes = {name: parameter.shape for name, parameter in self.named_parameters()}
        self.size = sum(shape.numel() for shape in self.shapes.values())

    def forward(self, given: Tensor) -> Tensor:
        """(..., F) features, or of a model that is no map of these (T, C) raw columns -> (...) predicted errors."""
        output: Tensor = self.model.head(given) if isinstance(self.model, FeatureModel) else self.model(given)
        return output

    def outputs(self, weights: Tensor, given: Tensor) -> Tensor:
        """The same with a vector (D,) of other weights."""
        output: Tensor = functional_call(self, as_parameters(weights, self.shapes), (given,))
        return output


def weights_of(model: nn.Module) -> Tensor:
    """(D,) all parameters of a model, one after the other; none of a model whose fit sets buffers."""
    weights = [parameter.detach().flatten() for parameter in model.parameters()]
    return torch.cat(weights) if weights else torch.zeros(0, dtype=torch.float64)


def as_parameters(vector: Tensor, shapes: Mapping[str, torch.Size]) -> dict[str, Tensor]:
    """(..., D) -> (..., *shape) each, the parameters that lie in a vector one after the other, as views of it."""
    pieces = vector.split([shape.numel() for shape in shapes.values()], dim=-1)
    return {name: piece.view(vector.shape[:-1] + shape) for (name, shape), piece in zip(shapes.items(), pieces, strict=True)}
