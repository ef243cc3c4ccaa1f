"""How far a model is asked for what it was not fitted to."""

from __future__ import annotations

from collections.abc import Sequence

from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.example import deciding_inputs
from zoo.models.ranges import TIME, Ranges, Watched, fitted_ranges, outside, watched_values

SELDOM = 0.01
"""Share of the rows of runs that may lie outside without a word."""


def beyond(model: Model, fitted: Sequence[Run], others: Sequence[Run]) -> dict[str, dict[str, object]]:
    """How far other runs go beyond what a model was fitted to, where they do in more than 1 % of their rows.

    Args:
        model: whose `inputs` are asked for.
        fitted: the runs that it was fitted to.
        others: runs that are only predicted.

    Returns:
        ``{"fitted": [low, high], "reached": [low, high], "share": of the rows}`` by raw column that decides something, and by feature made of one.
    """
    return beyond_ranges(model, fitted_ranges(model, fitted), others) if others else {}


def beyond_ranges(model: Model, ranges: Ranges, runs: Sequence[Run]) -> dict[str, dict[str, object]]:
    """The same of a model of which it is kept within which values it was fitted.

    Args:
        model: whose `inputs` are asked for.
        ranges: by raw column, rate and lag; what has none is not told.
        runs: that are only predicted.
    """
    told, found = Watched(model).of([TIME, *deciding_inputs(model, ranges)]), {}
    for name, values in watched_values(model, runs).items():
        share = float(outside(values.unsqueeze(1), [name], ranges).double().mean())
        if name in told and share > SELDOM:
            found[name] = {"fitted": list(ranges[name]), "reached": [float(values.min()), float(values.max())], "share": share}
    return found
