"""Raw columns -> named physical features: the part of a network that remembers, so that its head need not."""

import re
from typing import Any

import torch
from torch import Tensor, nn

from zoo.errors import InputError
from zoo.given import check_number
from zoo.models.base import Model
from zoo.physics.differentiator import SMOOTHING_S, temperature_rate
from zoo.physics.lag import lagged

RATE = "_rate"
POSSIBLE = "possible: temperature_rate, temperature_NAME_rate, and lags of so many seconds, temperature_lag600, temperature_NAME_lag600"

_LAG = "h = time − time of the row before; a = exp(−h/tau), m = (1 − a)·tau/h, b = (u − u_before)/h; "
_START = "the first row: x = u"
RECURRENCES = {
    "lag": f"{_LAG}x ← a·x + (m − a)·u_before + (1 − m)·u; {_START}; the feature is x",
    "rate": (
        f"{_LAG}r ← a·r + (1 − a)·b − a·h/tau²·(x − u_before + b·tau) with x of the row before; "
        f"then x ← a·x + (m − a)·u_before + (1 − m)·u; {_START}, r = 0; the feature is 60·r [K/min]"
    ),
}
"""How a column u becomes a feature, row by row; the same as in `zoo.export.feature_stream`, in words that a metadata file can hold."""


class Features(nn.Module):
    """(T, C) raw columns of one run -> (T, F) features by name; causal and scriptable.

    ``temperature`` is the column ``temperature_c`` [°C], ``temperature_outer`` the column ``temperature_outer_c``; with ``_rate`` after it, its
    smoothed rate [K/min]; with ``_lag600`` after it, the temperature behind a first-order lag of 600 s [°C], soaked when the run begins.
    Any other name is a column taken as it is, such as ``supply_v``, ``time_s`` or the true input ``reference_dph``; ``output`` is what the gyro
    shows, by which an error that goes with the input is known where nobody knows the input.

    Attributes:
        names: the features.
        inputs: the raw columns wanted, ``time_s`` first.
        column: where each feature's column stands in `inputs`.
        kind: what each feature is of its column: ``"column"``, ``"rate"`` or ``"lag"``.
        time_constant_s: of a rate, that of each of the differentiator's two lags [s]; of a lag, its own [s]; 0 for a column as recorded.
    """

    inputs: list[str]

    def __init__(self, names: list[str], smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__()
        if isinstance(names, str) or not names:
            raise InputError(f"model.features={names}: a list of at least one is needed, such as [temperature,temperature_rate]")
        if len(set(names)) != len(names):
            raise InputError(f"model.features={list(names)}: each may be named once")
        check_number("model.smoothing_s", smoothing_s, unit=" s")
        if not smoothing_s > 0:
            raise InputError(f"model.smoothing_s={smoothing_s}: must be above 0 s")
        self.names = list(names)
        recipes = [_recipe(name, float(smoothing_s)) for name in names]
        self.inputs = list(dict.fromkeys(["time_s", *(source for source, _, _ in recipes)]))
        self.column = [self.inputs.index(source) for source, _, _ in recipes]
        self.kind = [kind for _, kind, _ in recipes]
        self.time_constant_s = [seconds for _, _, seconds in recipes]

    def definitions(self) -> dict[str, dict[str, Any]]:
        """What each feature is, as JSON takes it: its raw column, and how it is computed row by row."""
        made = zip(self.names, self.column, self.kind, self.time_constant_s, strict=True)
        return {
            name: {"column": self.inputs[column], "kind": kind} | ({"tau_s": seconds, "recurrence": RECURRENCES[kind]} if seconds else {})
            for name, column, kind, seconds in made
        }

    def forward(self, x: Tensor) -> Tensor:
        """Compute the features.

        Args:
            x: (T, C) raw columns `inputs`, in time order, float64.

        Returns:
            (T, F).
        """
        features: list[Tensor] = []
        for column, kind, seconds in zip(self.column, self.kind, self.time_constant_s):  # noqa: B905 (TorchScript's zip knows no `strict`)
            features.append(one_feature(x[:, 0], x[:, column], seconds, kind == "rate"))
        return torch.stack(features, dim=-1)


def one_feature(time: Tensor, value: Tensor, seconds: float, is_rate: bool) -> Tensor:
    """What is made of one raw column, in the subset of Python that TorchScript takes.

    Args:
        time: (T,) [s].
        value: (T,) the column.
        seconds: time constant [s]; 0 for the column as it is.
        is_rate: whether it is the rate through two such lags [K/min], else the column behind one.

    Returns:
        (T,).
    """
    if is_rate:
        return temperature_rate(time, value, seconds)
    return lagged(time, value, torch.full_like(value[0], seconds)) if seconds > 0 else value


def remembering(model: Model) -> Features | None:
    """The rates and lags of a model's `inputs` among the features that it, or the networks in it, are made of; None where there are none.

    A grey box goes by the rates of its thermometers, at whichever of its places. Rates that are smoothed in another way
    than the first are left out, and so is what a class of a user's own makes in its own way.
    """
    found: dict[str, tuple[str, float]] = {}
    for part in model.modules():
        if isinstance(part, Features) and type(part).forward is Features.forward:
            made = zip(part.names, part.column, part.kind, part.time_constant_s, strict=True)
            found = {name: (kind, seconds) for name, at, kind, seconds in made if kind != "column" and part.inputs[at] in model.inputs} | found
    for part in model.modules():
        rates = [f"{name.removesuffix('_c')}{RATE}" for name in getattr(part, "thermometers", ()) if name in model.inputs]
        found |= {name: ("rate", next((own for kind, own in found.values() if kind == "rate"), SMOOTHING_S)) for name in rates if name not in found}
    smoothing = next((seconds for kind, seconds in found.values() if kind == "rate"), SMOOTHING_S)
    names = [name for name, (kind, seconds) in found.items() if kind == "lag" or seconds == smoothing]
    return Features(names, smoothing) if names else None


def _recipe(feature: str, smoothing_s: float) -> tuple[str, str, float]:
    """The raw column behind a feature, what is made of it, and with which time constant [s]."""
    source, kind, seconds = feature, "column", 0.0
    thermal = feature.split("_", maxsplit=1)[0] == "temperature"
    lag = re.fullmatch(r"(.+)_lag([-+.\d]*)", feature.removesuffix(RATE))
    if lag and (thermal or lag[2]):
        if feature.endswith(RATE):
            raise InputError(f"model.features: '{feature}': a lag has no rate; {POSSIBLE}")
        source, kind, seconds = lag[1], "lag", _lag_seconds(feature, lag[2])
    elif feature.endswith(RATE):
        source, kind, seconds = feature.removesuffix(RATE), "rate", smoothing_s
    if thermal:
        return source if source.endswith("_c") else f"{source}_c", kind, seconds
    if kind != "column":
        raise InputError(f"model.features: '{feature}': only temperatures have a {kind}; {POSSIBLE}")
    return feature, kind, seconds


def _lag_seconds(feature: str, digits: str) -> float:
    if not re.fullmatch(r"\d+(\.\d+)?", digits) or float(digits) <= 0:
        raise InputError(f"model.features: '{feature}': a lag is named with its seconds, above 0; {POSSIBLE}")
    return float(digits)
