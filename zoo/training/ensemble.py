"""Many members of one architecture, trained as one batch."""

from __future__ import annotations

import copy

import torch
from torch import Tensor, nn

from zoo.models.base import FeatureModel
from zoo.training.fine_blocks import seen
from zoo.training.slopes import Slopes
from zoo.training.weights import member_outputs, set_weights, weight_vector


class Ensemble(nn.Module):
    """The weights of E members as one parameter, whose gradient is each member's own.

    An optimizer that works element by element, as Adam and SGD do, then takes the steps that it would take with each member alone.

    Attributes:
        net: a copy of the model, which lends its structure and its buffers.
        weights: (E, D).
        done: (E,) members that have reached the goal and stay as they are.
        steps: (E,) steps that each has taken.
        latest: (E,) losses before the last of them.
    """

    done: Tensor
    steps: Tensor
    latest: Tensor

    def __init__(self, model: FeatureModel, members: int) -> None:
        super().__init__()
        self.net = copy.deepcopy(model).requires_grad_(False)
        self.over(1)
        self.weights = nn.Parameter(weight_vector(model).repeat(members, 1))
        self.register_buffer("done", torch.zeros(members, dtype=torch.bool))
        self.register_buffer("steps", torch.zeros(members, dtype=torch.int64))
        self._before = self.weights.detach()
        self.register_buffer("latest", self.weights.new_full((members,), torch.inf).detach())

    def over(self, samples: int) -> None:
        """Take rows with so many samples of a block each, see `zoo.training.fine_blocks`."""
        self.samples = samples
        self._slopes = Slopes(seen(self.net, samples))

    def forward(self, features: Tensor) -> Tensor:
        """(M, F) features, or rows, -> (E, M) predicted errors [output's unit]."""
        return member_outputs(seen(self.net, self.samples), self.weights, features)

    def objective(self, features: Tensor, error: Tensor, scale: float) -> tuple[Tensor, Tensor]:
        """What to step down from, and (E,) what the losses are.

        The graph of all members at once would take memory by the gigabyte. So their gradients are taken piece by piece, and what is returned is the
        linear function of the weights that has them.

        Args:
            features: (M, F) of all members, or (E, M, F) of each.
            error: (M,) or (E, M) [output's unit].
            scale: unit of the loss [output's unit].
        """
        self._before = self.weights.detach().clone()
        index = (~self.done).nonzero().squeeze(-1)
        own = (features[index], error[index]) if features.ndim == 3 else (features, error)
        losses, slopes = (one / scale**2 for one in self._slopes(self._before[index], *own))
        self.latest = self.latest.index_copy(0, index, losses)
        return (self.weights * torch.zeros_like(self._before).index_copy(0, index, slopes)).sum(), self.latest

    def stepped(self, reached: Tensor) -> None:
        """Take back the step of those who were done before it, and stop those that have reached the goal.

        Args:
            reached: (E,) who has.
        """
        with torch.no_grad():
            self.weights.copy_(torch.where(self.done.unsqueeze(-1), self._before, self.weights))
        self.steps += ~self.done
        self.done |= reached

    def member(self, k: int) -> FeatureModel:
        """A model with the weights of member k."""
        one = copy.deepcopy(self.net).requires_grad_(True)
        set_weights(one, self.weights[k])
        return one
