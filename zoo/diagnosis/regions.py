"""Where the model fails: run, stage, temperature, worst first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from torch import Tensor

from zoo.measurements.run import Run
from zoo.scoring.stages import label_stages, rms

SHOWN = 24


def regions(runs: list[Run], residual: Tensor, floors: Mapping[str, float]) -> list[dict[str, Any]]:
    """RMS of the residual in every stage of every run.

    Args:
        runs: R runs.
        residual: (N,) block means, runs one after the other [unit].
        floors: noise floor of each run [unit].

    Returns:
        The contract's `where`, worst first, 24 at most.
    """
    found: list[dict[str, Any]] = []
    for run, part in zip(runs, residual.cpu().split([run.blocks for run in runs]), strict=True):
        time, temperature = run.block_mean(run.time).cpu(), run.block_mean(run.temperature).cpu()
        first, last = (round(moment, 3) + 0.0 for moment in run.span_s)  # a zero has no sign then
        for stage in label_stages(time, temperature):
            here = temperature[stage.blocks]
            left = rms(part[stage.blocks])
            found.append(
                {
                    "run": run.name,
                    "start_s": first,
                    "from_s": max(round(stage.from_s - run.average_s / 2, 3), first),
                    "to_s": min(round(stage.to_s + run.average_s / 2, 3), last),
                    "stage": stage.kind,
                    "temperature_c": [round(float(here.min()), 2), round(float(here.max()), 2)],
                    "rate_k_per_min": round(_mean_rate(time[stage.blocks], here), 3),
                    "rms": left,
                    "excess": left / floors[run.name],
                }
            )
    return sorted(found, key=lambda region: -region["excess"])[:SHOWN]


def _mean_rate(time: Tensor, temperature: Tensor) -> float:
    if len(time) < 2:
        return 0.0
    centred = time - time.mean()
    return float((centred * temperature).sum() / centred.square().sum().clamp_min(1e-12) * 60.0)


def runs_rms(runs: list[Run], residual: Tensor) -> dict[str, float]:
    """RMS of each run's residual [unit], by name."""
    parts = residual.split([run.blocks for run in runs])
    return {run.name: rms(part) for run, part in zip(runs, parts, strict=True)}
