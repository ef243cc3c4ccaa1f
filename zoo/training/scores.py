"""How good a trained model is, as the numbers in `metrics.json`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor

from zoo.errors import WorkError
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.prediction import predict_blocks
from zoo.models.reach import beyond
from zoo.scoring.comparison import UNCOMPENSATED, WHOLE, rms_by_kind
from zoo.scoring.stages import bias_stability, label_stages, rms


def residual_blocks(model: Model, run: Run) -> Tensor:
    """(N,) what a model leaves of a run's error [output's unit].

    Raises:
        WorkError: the model predicts something that is no number.
    """
    left = run.block_mean(run.error) - predict_blocks(model, run)
    if not bool(torch.isfinite(left).all()):
        raise WorkError(f"{run.name}: the model {type(model).__name__} predicts values that are no numbers")
    return left


def score_runs(model: Model, runs: Sequence[Run], check_runs: Sequence[Run]) -> dict[str, Any]:
    """RMS of fitted and check runs, each as a whole and by stage [output's unit], and how far the latter go beyond the former, see `beyond`."""
    fitted, checked = [_score(model, run) for run in runs], [_score(model, run) for run in check_runs]
    return {
        "unit": runs[0].unit,
        "average_s": runs[0].average_s,
        "rms": _pooled(fitted, "rms"),
        "rms_check": _pooled(checked, "rms") if checked else None,
        "rms_uncompensated": _pooled(fitted, UNCOMPENSATED),
        "rms_check_uncompensated": _pooled(checked, UNCOMPENSATED) if checked else None,
        "runs": fitted,
        "check_runs": checked,
        "beyond": beyond(model, runs, check_runs),
    }


def _score(model: Model, run: Run) -> dict[str, Any]:
    error = run.block_mean(run.error)
    left = residual_blocks(model, run)
    stages = label_stages(run.block_mean(run.time), run.block_mean(run.temperature))
    rows = rms_by_kind({UNCOMPENSATED: error, "rms": left}, stages)
    whole = next(row for row in rows if row["stage"] == WHOLE)
    return {
        "run": run.name,
        "blocks": run.blocks,
        "rms": rms(left),
        UNCOMPENSATED: whole[UNCOMPENSATED],
        "bias_stability": bias_stability(left),
        "bias_stability_uncompensated": bias_stability(error),
        "stages": {row.pop("stage"): row for row in rows if row["stage"] != WHOLE},
    }


def _pooled(scores: list[dict[str, Any]], key: str) -> float:
    total = sum(score["blocks"] for score in scores)
    return float((sum(score["blocks"] * score[key] ** 2 for score in scores) / max(total, 1)) ** 0.5)
