"""Whether an output that was recorded beside the true input, or a temperature, is in another unit than it is taken for."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from zoo import units
from zoo.measurements.run import Run
from zoo.measurements.schema import Layout, Source

HOTTEST_C, NEVER_C = 125.0, 150.0
"""What is hotter than a gyro is tested is in °F, most likely; what is hotter than any in K."""
LEAST_DPH = 0.1
"""A true input below [°/h, RMS] is about zero: what the gyro shows beside it is bias. A prior: some thousandths of the Earth's rate."""
NEAR = 0.05
"""Share by which the output over the true input may differ from the factor between two units."""
SCATTER = 0.5
"""Share of the true input, in that unit, up to which the output may scatter around it (RMS)."""


def mistaken_unit(one: Layout, truth: np.ndarray, error: np.ndarray, count: np.ndarray | None = None) -> list[str]:
    """A sentence where the output follows the recorded true input but for the factor between two units of an angular rate.

    The output over the true input is the line through the origin that fits best: where the input is constant, the ratio of the means.

    Args:
        one: the file's columns.
        truth: (M,) true input [output's unit].
        error: (M,) output − true input [output's unit].
        count: (M,) rows behind each; None for one.
    """
    if one.reference is None or not len(truth) or units.UNITS[one.unit].quantity != "rate":
        return []
    weight = np.ones_like(truth) if count is None else count / count.sum() * len(count)
    square = float(np.mean(weight * truth**2))
    if units.convert(square**0.5, one.unit, "dph") < LEAST_DPH:
        return []
    output = truth + error
    ratio = float(np.mean(weight * output * truth)) / square
    left = float(np.mean(weight * (output - ratio * truth) ** 2))
    if left > SCATTER**2 * ratio**2 * square:
        return []
    doubts = _doubts(one.output, ratio, False) | _doubts(one.reference, ratio, True)
    return [f"{one.output.column} is about {_told(max(doubts.values()))} × {one.reference.column}: is {', or '.join(doubts)}?"] if doubts else []


def _doubts(source: Source, ratio: float, upside_down: bool) -> dict[str, float]:
    """In which unit a column would make the ratio 1, and what says so -> the factor between that unit and its own.

    Args:
        source: the column.
        ratio: of the output to the true input.
        upside_down: whether the column is the true input.
    """
    found = {}
    for unit in units.suffixes("rate"):
        factor = units.convert(1.0, *((unit, source.given) if upside_down else (source.given, unit)))
        if unit != source.given and abs(ratio / factor - 1) < NEAR:
            named = units.output_suffix(source.column) is not None
            way = f"a name that ends in _{unit} says so" if named or upside_down else f"data.output_unit={unit}"
            found[f"{source.column} in {units.symbol(unit)} ({way})"] = factor
    return found


def _told(factor: float) -> str:
    """A factor as one says it: 3600, 1/3600."""
    return f"{factor:.0f}" if factor > 1 else f"1/{1 / factor:.0f}"


def too_hot(runs: Iterable[Run], limit_c: float = HOTTEST_C) -> dict[str, float]:
    """The highest reading of a thermometer [°C] in runs where it is beyond a limit, by name."""
    highest = {run.name: float(run.select(list(run.thermometers)).max()) for run in runs}
    return {name: value for name, value in highest.items() if value > limit_c}
