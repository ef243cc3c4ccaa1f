"""Standardisation of features and error, kept in buffers so that it travels with the model."""

from typing import Any

import torch
from torch import Tensor, nn


class Scaler(nn.Module):
    """Centres and scales F features and the error; an untouched scaler changes nothing.

    Attributes:
        centre: (F,) mean of each feature.
        scale: (F,) its standard deviation; 1 for a feature that never changes.
        error_centre: () mean error [output's unit].
        error_scale: () its standard deviation [output's unit].
    """

    centre: Tensor
    scale: Tensor
    error_centre: Tensor
    error_scale: Tensor

    def __init__(self, features: int) -> None:
        super().__init__()
        self.register_buffer("centre", torch.zeros(features, dtype=torch.float64))
        self.register_buffer("scale", torch.ones(features, dtype=torch.float64))
        self.register_buffer("error_centre", torch.zeros((), dtype=torch.float64))
        self.register_buffer("error_scale", torch.ones((), dtype=torch.float64))

    def fit(self, features: Tensor, error: Tensor) -> None:
        """Take centre and scale from training data.

        Args:
            features: (M, F).
            error: (M,) [output's unit].
        """
        self.centre.copy_(features.mean(0))
        self.scale.copy_(spread(features))
        self.error_centre.copy_(error.mean())
        self.error_scale.copy_(spread(error))

    def forward(self, features: Tensor) -> Tensor:
        """(..., F) features in their units -> standardised."""
        return (features - self.centre) / self.scale

    def restore(self, value: Tensor) -> Tensor:
        """(...) standardised error -> [output's unit]."""
        return self.error_centre + self.error_scale * value

    def folded(self, weight: Tensor, bias: Tensor) -> tuple[Tensor, Tensor]:
        """What (H, F) weights and (H,) biases of standardised features are of features in their units."""
        own = weight.detach() / self.scale
        return own, bias.detach() - own @ self.centre


def neurons(names: list[str], weights: Tensor, biases: Tensor, inputs: Tensor) -> list[dict[str, Any]]:
    """H neurons as JSON takes them: what each counts in the output (H,), its bias (H,), and its weight of each feature (H, F) by name."""
    return [
        {"weight": weight, "bias": bias, "inputs": dict(zip(names, row, strict=True))}
        for weight, bias, row in zip(weights.tolist(), biases.tolist(), inputs.tolist(), strict=True)
    ]


def spread(value: Tensor) -> Tensor:
    """(M, ...) -> (...) standard deviation, and 1 of what is constant but for rounding: that must not be blown up to unit variance."""
    deviation = value.std(0, correction=0)
    return torch.where(deviation > 1e-9 * value.abs().amax(0), deviation, torch.ones_like(deviation))
