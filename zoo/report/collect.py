"""From fitted models to what the report draws."""

from __future__ import annotations

from torch import Tensor

from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.prediction import predict_blocks
from zoo.physics.differentiator import temperature_rate
from zoo.report.trace import Trace
from zoo.scoring.stages import label_stages, stage_names


def traces(
    runs: list[Run], role: str, model: Model, refined: Model | None = None, left: Tensor | None = None, left_refined: Tensor | None = None
) -> list[Trace]:
    """Block means of runs and what models say of them.

    Args:
        runs: fitted runs, or runs only checked on.
        role: ``"fit"`` or ``"check"``.
        model: the model as it stands.
        refined: the same with effects added.
        left: (ΣN,) its residual where it was fitted to these runs [unit]. It is believed rather than a prediction, as an effect may have values for
            each fitted run, which it has for no other: a line in time with a phase of its own.
        left_refined: (ΣN,) the same with effects added.
    """
    sizes = [run.blocks for run in runs]
    parts, more = ([None] * len(runs) if one is None else one.cpu().split(sizes) for one in (left, left_refined))
    return [
        _trace(run, role, _said(run, model, part), None if refined is None else _said(run, refined, of))
        for run, part, of in zip(runs, parts, more, strict=True)
    ]


def _said(run: Run, model: Model, left: Tensor | None) -> Tensor:
    """(N,) what a model says of a run [unit]."""
    return predict_blocks(model, run) if left is None else run.block_mean(run.error) - left


def _trace(run: Run, role: str, said: Tensor, refined: Tensor | None) -> Trace:
    time, temperature = run.block_mean(run.time), run.block_mean(run.temperature)
    return Trace(
        run=run.name,
        role=role,
        time_s=time.numpy(),
        temperature_c=temperature.numpy(),
        rate_k_per_min=run.block_mean(temperature_rate(run.time, run.temperature)).numpy(),
        error=run.block_mean(run.error).numpy(),
        model=said.numpy(),
        refined=None if refined is None else refined.numpy(),
        stage=list(stage_names(label_stages(time, temperature))),
        start_s=run.span_s[0],
    )
