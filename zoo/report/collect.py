"""From fitted models to what the report draws."""

from __future__ import annotations

from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.prediction import predict_blocks
from zoo.physics.differentiator import temperature_rate
from zoo.report.trace import Trace
from zoo.scoring.stages import label_stages, stage_names


def traces(runs: list[Run], role: str, model: Model, refined: Model | None = None) -> list[Trace]:
    """Block means of runs and what models say of them.

    Args:
        runs: fitted runs, or runs only checked on.
        role: ``"fit"`` or ``"check"``.
        model: the model as it stands.
        refined: the same with effects added.
    """
    return [_trace(run, role, model, refined) for run in runs]


def _trace(run: Run, role: str, model: Model, refined: Model | None) -> Trace:
    time, temperature = run.block_mean(run.time), run.block_mean(run.temperature)
    return Trace(
        run=run.name,
        role=role,
        time_s=time.numpy(),
        temperature_c=temperature.numpy(),
        rate_k_per_min=run.block_mean(temperature_rate(run.time, run.temperature)).numpy(),
        error=run.block_mean(run.error).numpy(),
        model=predict_blocks(model, run).numpy(),
        refined=None if refined is None else predict_blocks(refined, run).numpy(),
        stage=list(stage_names(label_stages(time, temperature))),
    )
