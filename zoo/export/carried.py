"""Any model made of the primitives of `zoo.physics`, some rows at a time, with what they remember as one vector handed in and out."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from zoo.errors import InputError
from zoo.models.base import Model
from zoo.models.streaming import check_streams, continued

CHUNK = 256
"""Rows of a long record that exported code takes at a time. Longer chunks need more passes a row, shorter ones more calls."""


class First(nn.Module):
    """The first row of a record, (1, C) -> (1,) predicted error and (S,) the state after it."""

    def __init__(self, model: Model, shapes: list[torch.Size]) -> None:
        """Put together.

        Args:
            model: whose memory lies in primitives that ask `zoo.physics.carry`.
            shapes: of all that is remembered.
        """
        super().__init__()
        self.model = model
        self.shapes = shapes

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """See the class."""
        predicted, states = continued(self.model, x, [])
        return predicted, packed(states, self.shapes, x)


class Next(nn.Module):
    """Rows that follow others, (L, C) and (S,) the state before them -> (L,) predicted error and (S,) the state after them."""

    def __init__(self, model: Model, shapes: list[torch.Size]) -> None:
        """Put together, see `First`."""
        super().__init__()
        self.model = model
        self.shapes = shapes

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """See the class."""
        parts = state.split([shape.numel() for shape in self.shapes]) if self.shapes else ()  # no node of a graph may have no outputs
        states = [part.reshape(shape) for part, shape in zip(parts, self.shapes, strict=True)]
        predicted, states = continued(self.model, x, states)
        return predicted, packed(states, self.shapes, x)


def packed(states: list[Tensor], shapes: list[torch.Size], like: Tensor) -> Tensor:
    """(S,) the states one after another, `like` a tensor of the record; a state that the first row leaves narrower than later ones is widened."""
    if not states:
        return like.new_zeros(0)
    return torch.cat([state.expand(shape).reshape(-1) for state, shape in zip(states, shapes, strict=True)])


def in_pieces(model: Model, x: Tensor) -> tuple[First, Next]:
    """A model as its first row and those that follow.

    Args:
        model: trained.
        x: (T, C) raw columns of a record to try it on, some thousand rows.

    Raises:
        InputError: the model needs more than one row to begin.
        WorkError: it remembers in a way that cannot be handed on.
    """
    if any(getattr(part, "in_motion", False) for part in model.modules()):
        raise InputError(
            "in_motion=true: what this model predicts depends on all of a record's first minute, and cannot be exported sample by sample"
        )
    check_streams(model, x)
    with torch.no_grad():
        _, states = continued(model, x[:1], [])
        _, states = continued(model, x[1:2], states)
    shapes = [state.shape for state in states]
    return First(model, shapes), Next(model, shapes)
