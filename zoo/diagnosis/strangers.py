"""Runs that do not go with the others: of another gyro, say, in another unit, or without their true input."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, cast

from zoo.diagnosis.cross_validation import KNOWN, from_other_runs
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.noise import floor_of
from zoo.measurements.run import Run
from zoo.models.prediction import predict_blocks
from zoo.models.reach import beyond
from zoo.scoring.stages import rms

NO_BETTER = 0.9
"""Share of a run's own error that the other runs must leave of it to predict it no better than nothing does."""
NOTICED = 3.0
"""Multiple of the run's noise floor that this must be as well."""


def strangers(bench: Workbench, models: Sequence[Solved], check_runs: Iterable[Run] = ()) -> list[dict[str, Any]]:
    """Runs that no model, fitted to the other runs, predicts better than no compensation would.

    An effect of one run alone, such as a step, is unknown to the others too, but little beside all that a gyro's runs have in common; where it is
    not, they must predict the rest of the run.

    Args:
        bench: the fitted runs.
        models: as it stands, and with everything that was found.
        check_runs: runs that were not fitted.

    Returns:
        ``{"run": …, "rms_from_others": …, "rms_uncompensated": …}`` [output's unit], the worst first.
    """
    listed = [_said(bench.runs[place], *numbers) for place, numbers in _odd(bench, models).items()]
    for run in check_runs:
        asks = [cast(float, one["share"]) for one in beyond(models[-1].model, bench.runs, [run]).values()]
        error = run.block_mean(run.error)
        left = min(rms(error - predict_blocks(one.model, run)) for one in models)
        if max(asks, default=0.0) <= 1.0 - KNOWN and _is_strange(run, left, rms(error), models[-1]):
            listed.append(_said(run, left, rms(error)))
    return sorted(listed, key=lambda one: -one["rms_from_others"] / one["rms_uncompensated"])


def _odd(bench: Workbench, models: Sequence[Solved]) -> dict[int, tuple[float, float]]:
    """Which runs do not go with the others, with what these leave of each: of several the one without which the rest go together."""
    places = [*range(len(bench.runs))]
    odd = _strange(bench, models, places)
    alone = [place for place in odd if not _strange(bench, models, [other for other in places if other != place])] if len(odd) > 1 else []
    return {place: odd[place] for place in alone} if len(alone) == 1 else odd


def _strange(bench: Workbench, models: Sequence[Solved], places: list[int]) -> dict[int, tuple[float, float]]:
    """Which of some runs the others of them predict no better than nothing: the RMS that they leave of each, and that of its error.

    Whom any model predicts is none, though the others had to extrapolate, nor is whom they predict but for what happens in it alone. Of two either
    both are strange to each other or, as one of them may know less than the other needs, none is.
    """
    if len(places) < 2:
        return {}
    odd = {}
    for place, numbers in zip(places, zip(*(from_other_runs(bench, one, places) for one in models), strict=True), strict=True):
        known = [(one.left, one.bare) for one in numbers if one.known]
        run, last = bench.runs[place], models[-1]
        explained = numbers[-1].beside_own <= NOTICED * floor_of(run, last.likely.noise)
        if known and not explained and all(_is_strange(run, one.left, one.bare, last) for one in numbers):
            odd[place] = min(known, key=lambda one: one[0] / one[1])
    return odd if len(places) > 2 or len(odd) == len(places) else {}


def _is_strange(run: Run, left: float, bare: float, last: Solved) -> bool:
    """Whether others leave so much of a run's error that they know nothing of it, and that by far more than its noise."""
    return left > max(NO_BETTER * bare, NOTICED * floor_of(run, last.likely.noise)) and bare > 0


def _said(run: Run, left: float, bare: float) -> dict[str, Any]:
    return {"run": run.name, "rms_from_others": left, "rms_uncompensated": bare}
