"""Between a parameter's physical value and its place 0…1 between the bounds."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from zoo.effects.base import Parameter, physical_value, unit_value


def to_physical(unit: Tensor, parameters: Sequence[Parameter]) -> Tensor:
    """Values in 0…1 -> physical values; along the logarithm where a parameter says so.

    Args:
        unit: (..., P).
        parameters: P declarations.
    """
    values = [physical_value(unit[..., i], p) for i, p in enumerate(parameters)]
    return torch.stack(values, dim=-1) if values else unit


def to_unit(physical: Tensor, parameters: Sequence[Parameter]) -> Tensor:
    """The inverse of `to_physical`, clipped to the bounds: (..., P) -> (..., P)."""
    values = [unit_value(physical[..., i], p) for i, p in enumerate(parameters)]
    return torch.stack(values, dim=-1).clamp(0.0, 1.0) if values else physical


def slope(unit: Tensor, parameters: Sequence[Parameter]) -> Tensor:
    """Derivative of the physical values with respect to 0…1: (P,) -> (P,), by central differences."""
    step = 1e-6
    return (to_physical(unit + step, parameters) - to_physical(unit - step, parameters)) / (2 * step)
