"""Fitted values with their standard errors and units, ready for JSON."""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor

from zoo.effects.base import Parameter
from zoo.effects.bounds import slope, to_physical
from zoo.fitting.variable_projection import Fit
from zoo.models.graybox import GrayBox

Fitted = dict[str, dict[str, Any]]

ANYWHERE = 10.0
"""Standard error of a nonlinear parameter, in ranges between its bounds, beyond which the runs say nothing of it."""
PRESSED = 2.0
"""Standard deviations beyond a bound from which on the runs speak for a value that is not possible."""


def parameters_of(model: GrayBox, fit: Fit, unit: str, covariance: Tensor | None = None, least: Tensor | None = None) -> dict[str, Fitted]:
    """Value, standard error and unit of every parameter, by owner (``"coil"`` or an effect) and name.

    What the runs would have beyond its bound has ``"at_bound": "low"`` or ``"high"`` as well: an effect with such a value may stand in for another.

    Args:
        model: the grey box.
        fit: its fit.
        unit: suffix of the output's unit, which replaces ``unit`` in the declarations.
        covariance: (P+K, P+K) of θ and amplitudes, see `Fit.covariance`; by default the fit's own.
        least: (P,) errors of θ, where theirs are smaller.
    """
    spread = (fit.covariance() if covariance is None else covariance).diagonal().clamp_min(0.0).sqrt()
    if least is not None:
        spread = torch.cat([torch.maximum(spread[: len(least)], least), spread[len(least) :]])
    declared = model.parameters_of_theta()
    parameters = [p for _, p in declared]
    values, factors, pressed = to_physical(fit.theta, parameters), slope(fit.theta, parameters), fit.pressed.tolist()
    owners: dict[str, Fitted] = {"coil": {}, **{name: {} for name, _ in model.named_effects()}}
    for i, (owner, parameter) in enumerate(declared):
        error = spread[i] * factors[i].abs() if float(spread[i]) <= ANYWHERE else values.new_tensor(math.nan)
        owners[owner][parameter.name] = _entry(parameter, values[i], error, unit)
        if abs(pressed[i]) > PRESSED and not parameter.ends_as_likely:
            owners[owner][parameter.name]["at_bound"] = "low" if pressed[i] < 0 else "high"
    at = len(declared)
    for name, effect in model.named_effects():
        for parameter in effect.amplitudes:
            owners[name][parameter.name] = _entry(parameter, fit.amplitudes[at - len(declared)], spread[at], unit)
            at += 1
    return owners


def _entry(parameter: Parameter, value: Tensor, error: Tensor, unit: str) -> dict[str, Any]:
    known = math.isfinite(float(error)) and parameter.scale != "index"  # a residual that does not depend on it, or a whole number, gives no error bar
    stderr = float(error) if known else None
    return {"value": float(value), "stderr": stderr, "unit": parameter.unit.replace("unit", unit)}
