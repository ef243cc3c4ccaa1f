"""Within which values a model was fitted: outside of them it extrapolates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.features import Features

Ranges = Mapping[str, tuple[float, float]]
"""Smallest and largest value by raw column, in the column's unit."""
TIME = "time_s"
SELDOM = 0.01
"""Share of the rows of runs that may lie outside without a word."""
ROOM = 0.02
"""Share of a range by which a value may lie outside of it: noise that the fit's means over a few seconds did not have. Engineering prior."""


def fitted_ranges(model: Model, runs: Sequence[Run]) -> dict[str, tuple[float, float]]:
    """Range of each raw column of a model over the blocks that it was fitted to; not of the time, as a clock may start anywhere, but for its feature.

    Args:
        model: whose `inputs` are asked for.
        runs: fitted.
    """
    found = {}
    for name in model.inputs:
        if name != TIME or any(TIME in part.names for part in model.modules() if isinstance(part, Features)):
            value = torch.cat([run.column(name)[run.block >= 0] for run in runs])
            found[name] = float(value.min()), float(value.max())
    return found


def outside(x: Tensor, inputs: Sequence[str], ranges: Ranges) -> Tensor:
    """Where values lie outside of what was fitted.

    Args:
        x: (T, C) raw columns.
        inputs: their names.
        ranges: by name; a column without a range is nowhere outside.

    Returns:
        (T, C) bool.
    """
    low, high = torch.tensor(limits(inputs, ranges), dtype=x.dtype, device=x.device).unbind(1)
    return (x < low) | (x > high)


def beyond(model: Model, fitted: Sequence[Run], others: Sequence[Run]) -> dict[str, dict[str, object]]:
    """How far other runs go beyond what a model was fitted to, by raw column and by feature, where they do in more than 1 % of their rows.

    Args:
        model: whose `inputs` are asked for.
        fitted: the runs that it was fitted to.
        others: runs that are only predicted.
    """
    found: dict[str, dict[str, object]] = {}
    if not others:
        return found
    known = _values(model, fitted)
    for name, values in _values(model, others).items():
        ranges = {name: (float(known[name].min()), float(known[name].max()))}
        share = float(outside(values.unsqueeze(1), [name], ranges).double().mean())
        if share > SELDOM:
            found[name] = {"fitted": list(ranges[name]), "reached": [float(values.min()), float(values.max())], "share": share}
    return found


def _values(model: Model, runs: Sequence[Run]) -> dict[str, Tensor]:
    """The raw columns that have a range, and block means of the rates and lags that a table of features has."""
    found = {name: torch.cat([run.column(name)[run.block >= 0] for run in runs]) for name in fitted_ranges(model, runs)}
    extract = getattr(model, "extract", None)
    if isinstance(model, FeatureModel) and isinstance(extract, Features):
        with torch.no_grad():
            table = torch.cat([run.block_mean_columns(extract(run.select(extract.inputs))) for run in runs])
        found |= {name: column for name, kind, column in zip(extract.names, extract.kind, table.T, strict=True) if kind != "column"}
    return found


def limits(inputs: Sequence[str], ranges: Ranges) -> list[tuple[float, float]]:
    """Between which values each raw column is taken for fitted: its range and some room for noise; anything, where it has no range."""
    known = [ranges.get(name, (-math.inf, math.inf)) for name in inputs]
    return [(low - room, high + room) for low, high in known for room in [ROOM * (high - low) if high - low < math.inf else 0.0]]


def checked(ranges: object) -> dict[str, tuple[float, float]]:
    """Ranges as they are read from a file.

    Raises:
        InputError: they are none.
    """
    try:
        return {str(name): (float(low), float(high)) for name, (low, high) in dict(ranges).items()}  # type: ignore[call-overload]
    except (TypeError, ValueError) as error:
        raise InputError("no ranges by column, {COLUMN: [lowest, highest], …}") from error
