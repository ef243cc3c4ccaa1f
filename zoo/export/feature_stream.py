"""Features one sample at a time: the recurrences of `zoo.physics.lag` and `zoo.physics.differentiator` on plain numbers."""

# No `from __future__ import annotations`: TorchScript reads class annotations.
import math

import torch
from torch import Tensor, nn

from zoo.export.recipe import Recipe
from zoo.models.features import one_feature
from zoo.units import convert


class FeatureStream(nn.Module):
    """(C,) raw columns of the next sample -> (F,) features, with a state of two numbers a feature and the last sample.

    Scripted, arithmetic on numbers costs a tenth of that on tensors of one number.

    Attributes:
        column: (F,) where each feature's raw column stands.
        tau: (F,) time constant of its lag [s]; 0 for a column as it is.
        is_rate: (F,) whether it is a rate.
        before: (C,) the last sample; empty before the first.
        once: (F,) column behind one lag [column's unit].
        rate: (F,) its rate behind two lags [column's unit per second].
    """

    column: list[int]
    tau: list[float]
    is_rate: list[bool]
    before: list[float]
    once: list[float]
    rate: list[float]

    def __init__(self, recipes: list[Recipe]) -> None:
        super().__init__()
        self.column = [one.column for one in recipes]
        self.tau = [one.lag_s for one in recipes]
        self.is_rate = [one.is_rate for one in recipes]
        self.before = []
        self.once = [0.0] * len(recipes)
        self.rate = [0.0] * len(recipes)
        self.per_minute = convert(1.0, "min", "s")

    def forget(self) -> None:
        """Back to before the first sample."""
        nothing: list[float] = []  # TorchScript takes a bare [] for tensors
        self.before = nothing

    def whole(self, x: Tensor) -> Tensor:
        """(T, C) raw columns of a whole run -> (T, F) features; nothing is remembered of it."""
        features = [x[:, 0]]
        for column, tau, is_rate in zip(self.column, self.tau, self.is_rate):  # noqa: B905 (TorchScript's zip knows no `strict`)
            features.append(one_feature(x[:, 0], x[:, column], tau, is_rate))
        return torch.stack(features, dim=1)[:, 1:]

    def forward(self, now: list[float]) -> list[float]:
        """Take one sample.

        With b the slope since the last one and c = x − u[k−1] + b·τ, where x is behind one lag and r behind two:
        r ← a·r + (1 − a)·b − a·(h/τ²)·c and x ← a·x + (m − a)·u[k−1] + (1 − m)·u[k]; a = exp(−h/τ), m = (τ/h)(1 − a).

        Args:
            now: (C,) raw columns, the time later than before [s].

        Returns:
            (F,) features.
        """
        features: list[float] = []
        fresh = len(self.before) == 0
        step = 0.0 if fresh else now[0] - self.before[0]
        for i, column in enumerate(self.column):
            value = now[column]
            tau = self.tau[i]
            if tau == 0.0:
                features.append(value)
                continue
            if fresh:
                self.once[i] = value
                self.rate[i] = 0.0
            else:
                last = self.before[column]
                ratio = step / tau
                decay = math.exp(-ratio)
                lost = -math.expm1(-ratio)
                mean = lost / ratio
                slope = (value - last) / step
                behind = self.once[i] - last + slope * tau
                self.rate[i] = decay * self.rate[i] + lost * slope - decay * ratio / tau * behind
                self.once[i] = decay * self.once[i] + (mean - decay) * last + (1 - mean) * value
            features.append(self.per_minute * self.rate[i] if self.is_rate[i] else self.once[i])
        self.before = now
        return features
