"""One model with many weights at once: the batched pass behind the swarms."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import torch
from torch import Tensor, nn
from torch.func import vmap
from torch.overrides import TorchFunctionMode

from zoo.models.base import FeatureModel
from zoo.models.head import Head
from zoo.training.tape import Recorded

AT_ONCE = {"cpu": (10, 2048), "cuda": (256, 16_384)}
"""Particles and samples in one pass: what passes between a small net's layers, 1.5 MB for nine nodes, then hardly leaves a core's own cache; a GPU
wants to be filled instead."""


class _Faster(TorchFunctionMode):
    """The same numbers, but for rounding, from operations that are faster on a CPU.

    tanh z = 2 σ(2z) − 1 (to 4e-16 of the output's 1): torch's sigmoid is vectorised everywhere, its tanh is not (7 × slower on an AMD processor).
    A linear layer of few nodes is fastest with the samples along the last axis, and what follows it elementwise keeps that order in memory.
    """

    def __torch_function__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        if func in (torch.tanh, Tensor.tanh) and not kwargs:
            return 2 * (2 * args[0]).sigmoid() - 1
        if func is nn.functional.linear and not kwargs and args[0].dim() == 2:
            value, weight, bias = args if len(args) == 3 else (*args, None)
            nodes = weight @ value.mT
            return (nodes if bias is None else nodes + bias.unsqueeze(-1)).mT
        return func(*args, **(kwargs or {}))


class Population:
    """A model's structure and buffers, to be evaluated with many weights.

    What does not depend on the weights is computed once: a model whose buffers change afterwards needs a new population.
    """

    def __init__(self, model: FeatureModel, features: Tensor) -> None:
        """Prepare.

        Args:
            model: lends its structure and its buffers.
            features: (M, F), for which `FeatureModel.head` gives one output a row.
        """
        self.head = Head(model)
        rows, self.particles = parts_of(features, len(features))
        self.parts = features.split(rows)
        self.passes = Recorded(self._whole)

    def outputs(self, weights: Tensor) -> Tensor:
        """(P, D) weights, ordered as `zoo.training.weights.weight_vector` does, -> (P, M) predicted errors [output's unit]."""
        return self.costs(weights, lambda predicted: predicted)

    def affine(self) -> tuple[Tensor, Tensor]:
        """Of a model that is linear in all its D weights: (M,) output without weights and (D, M) what each weight adds."""
        size, like = self.head.size, self.parts[0]
        outputs = self.outputs(torch.eye(size + 1, size, dtype=like.dtype, device=like.device).roll(1, dims=0))
        return outputs[0], outputs[1:] - outputs[0]

    def costs(self, weights: Tensor, cost: Callable[[Tensor], Tensor]) -> Tensor:
        """What a population costs, without ever holding all its predictions.

        Args:
            weights: (P, D).
            cost: (p, M) predicted errors [output's unit] -> (p, ...), any number of particles at a time. What it is given it may change, and must not
                keep: the next particles' errors lie there.

        Returns:
            (P, ...).
        """
        weights = weights.detach()
        if len(weights) <= self.particles:
            return cost(self.passes(weights)).clone()
        at_once = even(len(weights), self.particles)
        first = cost(self.passes(weights[:at_once]))
        costs = first.new_empty(len(weights), *first.shape[1:])
        costs[:at_once] = first
        for start in range(at_once, len(weights), at_once):
            costs[start : start + at_once] = cost(self.passes(weights[start : start + at_once]))
        return costs

    def _whole(self, weights: Tensor) -> Tensor:
        return (
            torch.cat([self._batched(weights, part) for part in self.parts], dim=-1) if len(self.parts) > 1 else self._batched(weights, self.parts[0])
        )

    def _batched(self, weights: Tensor, features: Tensor) -> Tensor:
        with nullcontext() if weights.is_cuda else _Faster():
            outputs: Tensor = vmap(self.head.outputs, in_dims=(0, None))(weights, features)
        return outputs


def parts_of(features: Tensor, samples: int) -> tuple[int, int]:
    """Rows of one part of so many samples, and how many particles go with them."""
    particles, most = AT_ONCE["cuda" if features.is_cuda else "cpu"]
    rows = even(samples, most)
    return rows, max(particles * most // rows, 1)


def even(total: int, most: int) -> int:
    """The size of the fewest parts, as equal as can be, of at most so many."""
    parts = -(-total // most)
    return max(-(-total // max(parts, 1)), 1)
