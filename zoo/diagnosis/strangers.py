"""Runs to doubt: that do not go with the others, being of another gyro, say, or without their true input; and that no gyro would stand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from torch import Tensor

from zoo.diagnosis.cross_validation import from_other_runs
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.noise import floor_of
from zoo.measurements.read import HOTTEST_C
from zoo.measurements.run import Run
from zoo.models.prediction import predict_blocks

NO_BETTER = 0.9
"""Share of a run's own error that the other runs must leave of it to predict it no better than nothing does."""
NOTICED = 3.0
"""Multiple of the run's noise floor that this must be as well."""


def strangers(bench: Workbench, models: Sequence[Solved], check_runs: Iterable[Run] = ()) -> list[dict[str, Any]]:
    """Runs that no model, fitted to the other runs, predicts better than no compensation would.

    An effect of one run alone, such as a step, is unknown to the others too, but little beside all that a gyro's runs have in common.

    Args:
        bench: the fitted runs.
        models: as it stands, and with everything that was found.
        check_runs: runs that were not fitted.

    Returns:
        ``{"run": …, "rms_from_others": …, "rms_uncompensated": …}`` [output's unit], the worst first.
    """
    listed = [_said(bench.runs[place], left) for place, left in _odd(bench, models, [*range(len(bench.runs))]).items()]
    for run in check_runs:
        left = min(_rms(run.block_mean(run.error) - predict_blocks(one.model, run)) for one in models)
        listed += [_said(run, left)] if _is_strange(run, left, models[-1]) else []
    return sorted(listed, key=lambda one: -one["rms_from_others"] / one["rms_uncompensated"])


def too_hot(runs: Iterable[Run]) -> dict[str, float]:
    """The highest reading of a thermometer [°C] in runs where it is another unit's, most likely, by name."""
    highest = {run.name: float(run.select(list(run.thermometers)).max()) for run in runs}
    return {name: value for name, value in highest.items() if value > HOTTEST_C}


def _odd(bench: Workbench, models: Sequence[Solved], places: list[int]) -> dict[int, float]:
    """Which of some runs do not go with the others, and the RMS that these leave of each: of several the one without which the rest go together.

    Of two runs either both are strange to each other or, as one of them may know less than the other needs, none is.
    """
    known = [found for one in models if len(places) > 1 and (found := from_other_runs(bench, one, places)) is not None]
    left = {place: min(values) for place, values in zip(places, zip(*known, strict=True), strict=True)} if known else {}
    odd = {place: rms for place, rms in left.items() if _is_strange(bench.runs[place], rms, models[-1])}
    if len(places) == 2:
        return odd if len(odd) == 2 else {}
    if len(odd) > 1:
        alone = [place for place in odd if not _odd(bench, models, [other for other in places if other != place])]
        return {place: odd[place] for place in alone} if len(alone) == 1 else odd
    return odd


def _is_strange(run: Run, left: float, last: Solved) -> bool:
    """Whether others leave so much of a run that they know nothing of it, and that by far more than its noise."""
    bare = _rms(run.block_mean(run.error))
    return left > max(NO_BETTER * bare, NOTICED * floor_of(run, last.likely.noise)) and bare > 0


def _said(run: Run, left: float) -> dict[str, Any]:
    return {"run": run.name, "rms_from_others": left, "rms_uncompensated": _rms(run.block_mean(run.error))}


def _rms(values: Tensor) -> float:
    return float(values.square().mean().sqrt())
