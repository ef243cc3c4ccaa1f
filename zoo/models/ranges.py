"""Within which values a model was fitted: outside of them it extrapolates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.features import Features, remembering

Ranges = Mapping[str, tuple[float, float]]
"""Smallest and largest value by raw column, in the column's unit, and by rate [K/min] or lag that a network is made of."""
TIME = "time_s"
ROOM = 0.02
"""Share of a range by which a value may lie outside of it: noise that the fit's means over a few seconds did not have. Engineering prior."""
ROUNDING = 1e-9
"""Room besides, over the largest value or over 1: what stands still has a range without any width."""


def fitted_ranges(model: Model, runs: Sequence[Run]) -> dict[str, tuple[float, float]]:
    """Range of each raw column of a model, and of each rate and lag in it, over the blocks that it was fitted to.

    Not of the time, as a clock may start anywhere, unless it is a feature.

    Args:
        model: whose `inputs` are asked for.
        runs: fitted.
    """
    return {name: (_rounded(values.min()), _rounded(values.max())) for name, values in watched_values(model, runs).items()}


def _rounded(value: Tensor) -> float:
    """A number to twelve digits: means of what was recorded as 58.74 are 58.739999999999995."""
    return float(f"{float(value):.12g}")


def outside(x: Tensor, names: Sequence[str], ranges: Ranges) -> Tensor:
    """Where values lie outside of what was fitted.

    Args:
        x: (T, C) raw columns or features.
        names: theirs.
        ranges: by name; what has no range is nowhere outside.

    Returns:
        (T, C) bool.
    """
    low, high = torch.tensor(limits(names, ranges), dtype=x.dtype, device=x.device).reshape(-1, 2).unbind(1)
    return (x < low) | (x > high)


class Watched:
    """What of a record is held against ranges, (T, C) raw columns of a model -> (T, C + W): these, and the rates and lags that are made of them.

    Attributes:
        names: of the columns returned.
    """

    def __init__(self, model: Model) -> None:
        """Look what a model, or a network in it, is made of."""
        self._extract = remembering(model)
        self._places = [] if self._extract is None else [model.inputs.index(name) for name in self._extract.inputs]
        self.names = [*model.inputs, *(self._extract.names if self._extract else [])]

    def of(self, columns: Sequence[str]) -> list[str]:
        """Those of the names that stand for some raw columns or are made of them."""
        extract = self._extract
        made = [] if extract is None else [name for name, at in zip(extract.names, extract.column, strict=True) if extract.inputs[at] in columns]
        return [name for name in self.names if name in columns or name in made]

    def __call__(self, x: Tensor) -> Tensor:
        """See the class."""
        return x if self._extract is None else torch.cat([x, self._extract(x[:, self._places])], dim=1)


def unknown_ranges(model: Model, ranges: Ranges) -> list[str]:
    """Rates and lags that a model is made of and that have no range: of a training before these were kept."""
    return [name for name in Watched(model).names if name not in (*model.inputs, *ranges)]


@torch.no_grad()
def watched_values(model: Model, runs: Sequence[Run]) -> dict[str, Tensor]:
    """(N,) values of what has a range, by name, over the rows of some runs that are judged."""
    timed = any(TIME in part.names for part in model.modules() if isinstance(part, Features))
    found = {name: torch.cat([run.column(name)[run.block >= 0] for run in runs]) for name in model.inputs if name != TIME or timed}
    extract = remembering(model)
    if extract is not None:
        table = torch.cat([extract(run.select(extract.inputs))[run.block >= 0] for run in runs])
        found |= {name: values for name, values in zip(extract.names, table.T, strict=True) if name not in found}
    return found


def limits(names: Sequence[str], ranges: Ranges) -> list[tuple[float, float]]:
    """Between which values each raw column or feature is taken for fitted: its range and some room for noise; anything, where it has no range."""
    known = [ranges.get(name, (-math.inf, math.inf)) for name in names]
    rooms = [ROOM * (high - low) + ROUNDING * max(1.0, abs(low), abs(high)) if high - low < math.inf else 0.0 for low, high in known]
    return [(low - room, high + room) for (low, high), room in zip(known, rooms, strict=True)]


def checked(ranges: object) -> dict[str, tuple[float, float]]:
    """Ranges as they are read from a file.

    Raises:
        InputError: they are none.
    """
    try:
        found = {str(name): (float(low), float(high)) for name, (low, high) in dict(ranges).items()}  # type: ignore[call-overload]
    except (TypeError, ValueError) as error:
        raise InputError("no ranges by column or feature, {NAME: [lowest, highest], …}") from error
    if not all(-math.inf < low <= high < math.inf for low, high in found.values()):
        raise InputError("a range does not go from a lowest to a highest number")
    return found
