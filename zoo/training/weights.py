"""Weights as a vector: drawing them at random, and evaluating many of them at once."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable

import torch
from torch import Generator, Tensor, nn
from torch.func import vmap

from zoo.errors import InputError
from zoo.models.base import FeatureModel
from zoo.models.head import Head, as_parameters, weights_of

ROWS_OF_COLUMNS = 8192
"""Samples, of one member or several, whose derivatives are computed at once: those of a small net stay in a core's cache."""


def reset(model: nn.Module, generator: Generator) -> None:
    """Draw a model's weights at random.

    A module may say how in a method ``draw_weights(generator)``; torch's own layers are drawn uniform within ±1/√inputs, as torch does (He et al.
    2015 with a = √5), but for those without a matrix, as norms; parameters of other modules stay as they are.

    Args:
        model: changed in place.
        generator: source of chance; draws are made on its device, so that the same seed gives the same weights everywhere.
    """
    for module in model.modules():
        own: Callable[[Generator], None] | None = getattr(module, "draw_weights", None)
        parameters = [*module.parameters(recurse=False)]
        if own is not None:
            own(generator)
        elif type(module).__module__.startswith("torch.nn.") and any(one.ndim > 1 for one in parameters):
            bound = 1 / math.sqrt(next(one[0].numel() for one in parameters if one.ndim > 1))
            for parameter in parameters:
                drawn = torch.rand(parameter.shape, generator=generator, dtype=parameter.dtype, device=generator.device)
                parameter.data.copy_(bound * (2 * drawn - 1))


def check_drawn(model: nn.Module) -> None:
    """Refuse several seeds of a model of which nothing is drawn.

    Raises:
        InputError: the weights of two seeds are alike.
    """
    two = [copy.deepcopy(model) for _ in range(2)]
    for seed, one in enumerate(two):
        reset(one, Generator().manual_seed(seed))
    if torch.equal(*map(weight_vector, two)):
        names = ", ".join(name for name, _ in model.named_parameters())
        raise InputError(
            f"seeds: {type(model).__name__} starts from the same weights with every seed, so that all would be copies: nothing draws {names}; give "
            "their module a method draw_weights(generator), or leave seeds out"
        )


def weight_vector(model: nn.Module) -> Tensor:
    """(D,) all parameters of a model, one after the other.

    Raises:
        InputError: it has none, as a model whose fit sets buffers.
    """
    weights = weights_of(model)
    if not len(weights):
        raise InputError(f"{type(model).__name__} has no weights to train{'; leave optimizer=auto' if hasattr(model, 'fitted_by') else ''}")
    return weights


def set_weights(model: nn.Module, vector: Tensor) -> None:
    """Write a (D,) vector into a model's parameters, in place."""
    own = dict(model.named_parameters())
    given = as_parameters(vector.detach(), {name: parameter.shape for name, parameter in own.items()})
    with torch.no_grad():
        for name, parameter in own.items():
            parameter.copy_(given[name])


def member_outputs(model: FeatureModel, weights: Tensor, features: Tensor) -> Tensor:
    """One model with many weights, with gradients: (P, D) weights, features (M, F) for all or (P, M, F) for each -> (P, M) predicted errors."""
    found: Tensor = vmap(Head(model).outputs, in_dims=(0, 0 if features.ndim == 3 else None))(weights, features)
    return found


def derivatives(model: FeatureModel, weights: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
    """Outputs and what each weight changes in them.

    With weights of its own for every row, one backward pass gives the gradients of all: a tenth of the time of a pass for every weight.

    Args:
        model: lends its structure and its buffers.
        weights: (E, D) as `weight_vector` orders them.
        features: (M, F).

    Returns:
        (E, M) predicted errors [output's unit] and (E, D, M) their derivatives.
    """
    members, size = weights.shape
    own = weights.detach().unsqueeze(1).expand(-1, len(features), -1).reshape(-1, size).requires_grad_()
    with torch.enable_grad():
        outputs = member_outputs(model, own, features.repeat(members, 1).unsqueeze(1)).squeeze(-1)
        (slopes,) = torch.autograd.grad(outputs.sum(), own)
    return outputs.detach().view(members, -1), slopes.view(members, -1, size).mT
