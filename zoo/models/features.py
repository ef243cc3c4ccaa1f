"""Raw columns -> named physical features: the part of a network that remembers, so that its head need not."""

import torch
from torch import Tensor, nn

from zoo.errors import InputError
from zoo.physics.carry import after_first, with_last
from zoo.physics.differentiator import SMOOTHING_S
from zoo.physics.lag import lagged
from zoo.physics.recurrence import affine

RATE = "_rate"


class Features(nn.Module):
    """(T, C) raw columns of one run -> (T, F) features by name; causal and scriptable.

    ``temperature`` is the column ``temperature_c`` [°C], ``temperature_outer`` the column ``temperature_outer_c``; with ``_rate`` after it, its
    smoothed rate [K/min]. Any other name is a column taken as it is, such as ``supply_v`` or ``time_s``.

    Attributes:
        names: the features.
        inputs: the raw columns wanted, ``time_s`` first.
        column: where each feature's column stands in `inputs`.
        is_rate: whether a feature is a column's rate.
        smoothing_s: time constant of each of the differentiator's two lags [s].
    """

    inputs: list[str]

    def __init__(self, names: list[str], smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__()
        if not names or len(set(names)) != len(names):
            raise InputError(f"model.features={list(names)}: at least one feature is needed, each named once")
        if not smoothing_s > 0:
            raise InputError(f"model.smoothing_s={smoothing_s}: must be above 0 s")
        self.names = list(names)
        self.is_rate = [name.endswith(RATE) for name in names]
        sources = [_column(name) for name in names]
        self.inputs = list(dict.fromkeys(["time_s", *sources]))
        self.column = [self.inputs.index(source) for source in sources]
        self.smoothing_s = float(smoothing_s)

    def forward(self, x: Tensor) -> Tensor:
        """Compute the features.

        Args:
            x: (T, C) raw columns `inputs`, in time order, float64.

        Returns:
            (T, F).
        """
        features: list[Tensor] = []
        for column, is_rate in zip(self.column, self.is_rate):  # noqa: B905 (TorchScript's zip knows no `strict`)
            value = x[:, column]
            features.append(two_lag_rate(x[:, 0], value, self.smoothing_s) if is_rate else value)
        return torch.stack(features, dim=-1)


def _column(feature: str) -> str:
    """The raw column behind a feature."""
    source = feature.removesuffix(RATE)
    if source.split("_")[0] == "temperature":
        return source if source.endswith("_c") else f"{source}_c"
    if source != feature:
        raise InputError(f"model.features: '{feature}': only temperatures have a rate; possible: temperature_rate, temperature_NAME_rate")
    return feature


def two_lag_rate(time: Tensor, temperature: Tensor, smoothing_s: float) -> Tensor:
    """`zoo.physics.differentiator.temperature_rate` in the subset of Python that TorchScript takes (a test holds them equal).

    Args:
        time: (T,) [s].
        temperature: (T,) [°C].
        smoothing_s: time constant of each lag [s].

    Returns:
        (T,) [K/min].
    """
    tau = torch.full_like(temperature[0], smoothing_s)
    once = with_last(lagged(time, temperature, tau))
    step, known = torch.diff(with_last(time)), with_last(temperature)
    slope = torch.diff(known) / step
    ratio = step / tau
    decay = torch.exp(-ratio)
    behind = once[:-1] - known[:-1] + slope * tau
    gain = -torch.expm1(-ratio) * slope - decay * ratio / tau * behind
    start = torch.zeros_like(temperature[0])
    return 60.0 * after_first(start, affine(decay, gain, start))
