"""The verb `compare`: trained models side by side, by run and stage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from omegaconf import DictConfig, OmegaConf
from rich.console import Console
from rich.table import Table
from torch import Tensor

from zoo.artifacts import write_json, write_text
from zoo.cli.inputs import read_data
from zoo.cli.saved_models import SavedModel, find_models
from zoo.errors import InputError, WorkError
from zoo.measurements.run import Run
from zoo.models.prediction import predict_blocks, usable_device
from zoo.scoring.comparison import UNCOMPENSATED, WHOLE, residuals, rms_by_kind, rms_by_stage
from zoo.scoring.stages import Stage, bias_stability, label_stages, rms
from zoo.units import symbol

Scored = tuple[Run, dict[str, Tensor]]
UNLIMITED = 10_000
WHAT_IT_WAS = ("init", "optimizer", "seed")


def run(config: DictConfig, out: Path) -> Path:
    """Predict, score, write.

    Args:
        config: as composed from conf/compare.yaml.
        out: folder of the results.

    Returns:
        The table's file.
    """
    device = usable_device(config.torch_device)
    given = config.runs if OmegaConf.is_list(config.runs) else [config.runs]
    models = find_models([str(one) for one in given])
    runs, check_runs = read_data(_with_trained_blocks(config, models))
    scored = [(one, _residuals(models, one, device)) for one in [*runs, *check_runs]]
    stages = [label_stages(one.block_mean(one.time), one.block_mean(one.temperature)) for one, _ in scored]
    rows = [{"run": one.name} | row for (one, left), cut in zip(scored, stages, strict=True) for row in rms_by_kind(left, cut)]
    columns = [UNCOMPENSATED, *(model.name for model in models)]
    pooled = {name: rms(torch.cat([left[name] for _, left in scored])) for name in columns}
    write_json(out / "comparison.json", _document(models, scored, stages, rows, pooled))
    _draw(out, scored, rows, columns, pooled)
    _print(rows, columns, pooled, runs[0])
    return write_text(out / "comparison.csv", _csv(rows, ["run", "stage", "blocks", *columns]))


def _with_trained_blocks(config: DictConfig, models: list[SavedModel]) -> DictConfig:
    """Under `data.average_s=auto`, the block length of the training where the models agree on one: noise, and so the RMS, depends on it."""
    lengths = {model.facts.get("average_s") for model in models} - {None}
    if config.data.get("average_s") == "auto" and len(lengths) == 1:
        config = config.copy()
        config.data.average_s = lengths.pop()
    return config


def _residuals(models: list[SavedModel], one: Run, device: torch.device) -> dict[str, Tensor]:
    """(N,) what each model leaves of a run, the uncompensated error first [output's unit]."""
    predicted = {}
    for model in models:
        if model.facts.get("unit", one.unit) != one.unit:
            raise InputError(f"{model.folder}: trained on an output in {model.facts['unit']}, but {one.name} is in {one.unit}")
        predicted[model.name] = predict_blocks(model.module.to(device), one)
        if not bool(torch.isfinite(predicted[model.name]).all()):
            raise WorkError(f"{model.folder}: predicts values that are no numbers for {one.name}")
    return residuals(one.block_mean(one.error), predicted)


def _document(
    models: list[SavedModel], scored: list[Scored], stages: list[list[Stage]], rows: list[dict[str, Any]], pooled: dict[str, float]
) -> dict[str, Any]:
    first = scored[0][0]
    return {
        "schema_version": 1,
        "unit": first.unit,
        "average_s": first.average_s,
        "models": [{"name": model.name, "folder": str(model.folder)} | {key: model.facts.get(key) for key in WHAT_IT_WAS} for model in models],
        "rms": pooled,
        "rows": rows,
        "runs": [
            {"run": one.name, "bias_stability": {name: bias_stability(value) for name, value in left.items()}, "stages": rms_by_stage(left, cut)}
            for (one, left), cut in zip(scored, stages, strict=True)
        ],
    }


def _csv(rows: list[dict[str, Any]], columns: list[str]) -> str:
    import pandas as pd

    text: str = pd.DataFrame(rows, columns=columns).to_csv(index=False, float_format="%.6g", lineterminator="\n")
    return text


def _draw(out: Path, scored: list[Scored], rows: list[dict[str, Any]], columns: list[str], pooled: dict[str, float]) -> None:
    # Matplotlib and TensorBoard take a second to import: only here, once the work is done.
    from torch.utils.tensorboard import SummaryWriter

    from zoo.report.comparison_figure import residual_figure, rms_figure
    from zoo.report.palette import styled

    unit = symbol(scored[0][0].unit)
    with styled(), SummaryWriter(str(out / "tensorboard")) as board:
        figures = {"comparison": rms_figure(rows, columns, unit)}
        for one, left in scored:
            hours = (one.block_mean(one.time) / 3600).numpy()
            figures[f"residual_{one.name}"] = residual_figure(one.name, hours, {name: value.numpy() for name, value in left.items()}, unit)
        for name, figure in figures.items():
            figure.savefig(out / f"{name}.png", dpi=100)
            board.add_figure(name, figure)
        for name, value in pooled.items():
            board.add_scalar(f"rms/{name}", value)


def _print(rows: list[dict[str, Any]], columns: list[str], pooled: dict[str, float], first: Run) -> None:
    table = Table("run", "stage", "blocks", *columns, title=f"RMS of the error [{symbol(first.unit)}], {first.average_s:g} s means")
    for row in rows:
        table.add_row(row["run"], row["stage"], str(row["blocks"]), *_cells(row, columns), end_section=row["stage"] == WHOLE)
    table.add_row("all", WHOLE, str(sum(row["blocks"] for row in rows if row["stage"] == WHOLE)), *_cells(pooled, columns))
    console = Console()
    # A file or a pipe has no width; the table shall not be cut there.
    whole = console.measure(table, options=console.options.update(width=UNLIMITED)).maximum
    console.print(table, width=None if console.is_terminal else whole, crop=False)


def _cells(values: dict[str, Any], columns: list[str]) -> list[str]:
    best = min(values[name] for name in columns)
    return [f"[bold]{values[name]:#.3g}[/bold]" if values[name] == best else f"{values[name]:#.3g}" for name in columns]
