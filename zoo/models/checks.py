"""A model from outside, tried once before it is trained: what is wrong with it would fail obscurely there, or not fail at all."""

from __future__ import annotations

import copy

import torch
from torch import Tensor
from torch.func import functional_call, vmap

from zoo.errors import InputError, in_brief
from zoo.models.base import FeatureModel, Model
from zoo.models.example import example

SAME = 1e-9
"""Relative; a product over more rows may sum in another order."""
BENDS = 1e-6
"""Share by which two equal steps of weights may move a prediction otherwise where it is called linear in them."""


def check_model(model: object, tried: bool = True) -> None:
    """Refuse what is no model, or one that predicts something else than one number a row from that row and those before it.

    Args:
        model: what the YAML's class made; not changed.
        tried: whether it predicts already: one with a fit of its own may have to be fitted first.

    Raises:
        InputError: says what was found and what is needed.
    """
    own = type(model).__name__
    if not isinstance(model, Model):
        raise InputError(f"model: a {own} is no model; a class derived from zoo.models.base.Model is needed, named by _target_ in its YAML")
    inputs = getattr(model, "inputs", None)
    if not isinstance(inputs, list | tuple) or [*inputs[:1]] != ["time_s"]:
        raise InputError(f"{own}.inputs is {inputs}; a list of raw columns is needed, time_s first")
    frozen = [name for name, one in model.named_parameters() if not one.requires_grad]
    if frozen:
        told = "would be trained all the same; what is no weight is a buffer (register_buffer)"
        raise InputError(f"{own}.{frozen[0]} has requires_grad=False, and {told}")
    if not tried:
        return
    model = copy.deepcopy(model).eval()
    with torch.no_grad():
        x = example(model.inputs, {})
        whole = _predicted(model, x)
        half = len(x) // 2
        later = torch.cat([x[:half], torch.cat([x[half:, :1], 1.0 + 1.1 * x[half:, 1:].flip(0)], dim=1)])
        apart = (_predicted(model, later)[:half] - whole[:half]).abs().nan_to_num().amax()
        if float(apart) > SAME * float(whole.nan_to_num().abs().amax()):
            raise InputError(f"{own} looks into the future: its predictions change with rows that come after them")
        if isinstance(model, FeatureModel):
            _check_static(model, x)
        _check_linear(model, x)


def check_many_weights(model: FeatureModel) -> None:
    """Refuse one that cannot be evaluated with many weights in one pass, as swarms, ensembles and Levenberg–Marquardt do.

    Args:
        model: with weights.

    Raises:
        InputError: says what is needed.
    """
    own, x = type(model).__name__, example(model.inputs, {})[:50]
    odd = [name for name, weight in model.named_parameters() if weight.dtype != torch.float64]
    if odd:
        raise InputError(f"{own}: {', '.join(odd)}: weights of torch.float64 are needed here")
    model = copy.deepcopy(model)
    several = {name: torch.stack([weight.detach()] * 2) for name, weight in model.named_parameters()}
    try:
        vmap(lambda weights: functional_call(model, weights, (x,)))(several)
    except Exception as error:
        raise InputError(
            f"{own}: torch.func.vmap, by which many weights are evaluated in one pass, fails with {in_brief(error)}; plain operations go through it, "
            "and nn.GRU, dropout and batch norm do not"
        ) from error


def check_trainable(model: FeatureModel) -> None:
    """Refuse one whose prediction does not depend on its weights in a way that gradients see.

    Args:
        model: with weights.

    Raises:
        InputError: says what is needed.
    """
    with torch.enable_grad():
        if not _predicted(model, example(model.inputs, {})[:50]).requires_grad:
            raise InputError(f"{type(model).__name__}.head: no gradient reaches its weights; they must be nn.Parameters, and nothing detached")


def _predicted(model: Model, x: Tensor) -> Tensor:
    """(T,) prediction for (T, C) raw columns."""
    own, wanted = type(model).__name__, f"one number a row, of shape ({len(x)},), torch.float64,"
    try:
        found = model(x)
    except InputError:
        raise
    except NotImplementedError as error:
        absent = [name for name in ("features", "head") if getattr(type(model), name, None) is getattr(FeatureModel, name)]
        raise InputError(f"{own}: still to be written: {', '.join(absent) or 'forward'}") from error
    except Exception as error:
        raise InputError(
            f"{own} fails with {in_brief(error)} on {len(x)} rows of {', '.join(model.inputs)}, torch.float64; weights as well?"
        ) from error
    if not isinstance(found, Tensor):
        raise InputError(f"{own} returns a {type(found).__name__}; {wanted} is needed")
    if found.shape != x.shape[:1] or found.dtype != torch.float64:
        raise InputError(f"{own} returns shape {tuple(found.shape)}, {found.dtype}; {wanted} is needed")
    return found


def _check_static(model: FeatureModel, x: Tensor) -> None:
    """What a head makes of a row of features is the same whatever rows stand beside it, and in what order."""
    features = model.features(x)
    whole, turned = model.head(features), model.head(features.flip(0)).flip(0)
    if float((turned - whole).abs().nan_to_num().amax()) > SAME * float(whole.nan_to_num().abs().amax()):
        raise InputError(
            f"{type(model).__name__}.head: what it makes of a row depends on the rows beside it; it is a map of one row, and what remembers belongs "
            "into features, without weights"
        )


def _check_linear(model: Model, x: Tensor) -> None:
    """What `linear_in` names must be there, and two equal steps of it move the prediction by as much."""
    named = getattr(model, "linear_in", ())
    weights = dict(model.named_parameters())
    absent = [name for name in named if name not in weights and getattr(model, name.partition(".")[0], "") is not None]  # a part may be left out
    if absent:
        raise InputError(f"{type(model).__name__}.linear_in: {', '.join(absent)}: no such parameter; there are {', '.join(weights)}")
    moved = {name: torch.linspace(0.3, 0.7, weights[name].numel(), dtype=x.dtype).reshape(weights[name].shape) for name in named if name in weights}
    if not moved:
        return
    none, once, twice = (functional_call(model, {name: weights[name] + steps * step for name, step in moved.items()}, (x,)) for steps in (0, 1, 2))
    if float((twice - 2 * once + none).abs().nan_to_num().amax()) > BENDS * float((once - none).abs().nan_to_num().amax()):
        raise InputError(f"{type(model).__name__}.linear_in: the prediction is not linear in {', '.join(moved)}")
