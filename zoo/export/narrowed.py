"""A model asked only for the raw columns that it uses: a grey box is given all that its files had."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.export.recipe import is_static
from zoo.models.base import Model
from zoo.models.example import deciding_inputs
from zoo.models.ranges import Ranges


class Narrowed(Model):
    """A model whose prediction does not depend on some of its raw columns, without them."""

    def __init__(self, model: Model, used: list[str]) -> None:
        """Put together.

        Args:
            model: trained.
            used: its inputs that decide something, in its order, the time first.
        """
        super().__init__()
        self.model = model
        self.inputs = used
        self.place = [used.index(name) if name in used else None for name in model.inputs]

    def forward(self, x: Tensor) -> Tensor:
        """Predict the error, see `Model.forward`."""
        nothing = torch.zeros_like(x[:, 0])
        predicted: Tensor = self.model(torch.stack([nothing if place is None else x[:, place] for place in self.place], dim=-1))
        return predicted


def narrowed(model: Model, ranges: Ranges) -> Model:
    """The model itself where it uses all that it asks for, else without the rest.

    Args:
        model: trained.
        ranges: of its raw columns.
    """
    if is_static(model):
        return model  # a network names its features
    used = deciding_inputs(model, ranges)
    return (
        model if len(used) + 1 == len(model.inputs) else Narrowed(model, [name for name in model.inputs if name == model.inputs[0] or name in used])
    )
