"""Losses of the members of an ensemble and their gradients."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.models.base import FeatureModel
from zoo.training.population import even, parts_of
from zoo.training.tape import Recorded
from zoo.training.weights import member_outputs


class Slopes:
    """Squared errors of a model with many weights and their gradients, in bounded memory.

    A model whose buffers change afterwards needs new ones.
    """

    def __init__(self, model: FeatureModel) -> None:
        """Prepare.

        Args:
            model: lends its structure and its buffers.
        """
        self.model, self._sums = model, Recorded(self._computed)

    def __call__(self, weights: Tensor, features: Tensor, error: Tensor) -> tuple[Tensor, Tensor]:
        """Evaluate.

        Args:
            weights: (E, D).
            features: (M, F) of all members, or (E, M, F) of each.
            error: (M,) or (E, M) [output's unit].

        Returns:
            (E,) mean squared errors [output's unit, squared] and (E, D) their derivatives.
        """
        rows, members = parts_of(features, features.shape[-2])
        own, losses, slopes = features.ndim == 3, error.new_zeros(len(weights)), torch.zeros_like(weights)
        for start in range(0, len(weights), even(len(weights), members)):
            some = slice(start, start + even(len(weights), members))
            here, wanted = (features[some], error[some]) if own else (features, error)
            for piece in zip(here.split(rows, dim=-2), wanted.split(rows, dim=-1), strict=True):
                loss, slope = self._sums(weights[some], *piece)
                losses[some] += loss
                slopes[some] += slope
        return losses / error.shape[-1], slopes / error.shape[-1]

    def _computed(self, weights: Tensor, features: Tensor, error: Tensor) -> tuple[Tensor, Tensor]:
        here = weights.detach().requires_grad_()
        with torch.enable_grad():
            losses = (member_outputs(self.model, here, features) - error).square().sum(-1)
            (slopes,) = torch.autograd.grad(losses.sum(), here)
        return losses.detach(), slopes
