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
    return Reach(model, fitted_ranges(model, fitted)).beyond(others) if others else {}


class Reach:
    """Within which values a model is at home."""

    def __init__(self, model: Model, ranges: Ranges) -> None:
        """Find what decides, see `deciding_inputs`.

        Args:
            model: whose `inputs` are asked for.
            ranges: within which it was fitted, by raw column, rate and lag; what has none is nowhere outside.
        """
        self.model = model
        self.ranges = ranges
        self._told = [name for name in Watched(model).of([TIME, *deciding_inputs(model, ranges)]) if name in ranges] if ranges else []

    def beyond(self, runs: Sequence[Run]) -> dict[str, dict[str, object]]:
        """How far some runs go beyond that, see the function of this name."""
        found = {}
        for name, values in watched_values(self.model, runs).items() if self._told else ():
            share = float(outside(values.unsqueeze(1), [name], self.ranges).double().mean())
            if name in self._told and share > SELDOM:
                found[name] = {"fitted": list(self.ranges[name]), "reached": [float(values.min()), float(values.max())], "share": share}
        return found
