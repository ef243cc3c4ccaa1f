"""The verb `compare`: trained models side by side, by run and stage."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from omegaconf import DictConfig, OmegaConf
from torch import Tensor

from zoo.artifacts import write_json, write_text
from zoo.cli.inputs import read_data
from zoo.cli.saved_models import SavedModel, distinct_names, find_models
from zoo.errors import InputError, WorkError
from zoo.measurements.run import Run
from zoo.models.prediction import predict_blocks, usable_device
from zoo.scoring.comparison import UNCOMPENSATED, alike, residuals, rms_by_kind, rms_by_stage
from zoo.scoring.stages import Stage, bias_stability, label_stages, rms
from zoo.units import symbol

Scored = tuple[Run, dict[str, Tensor]]
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
    labels = _labels(models, scored)
    shown = [{key: row[key] for key in ("run", "stage", "blocks")} | _relabelled(row, labels) for row in rows]
    _draw(out, scored, shown, labels, pooled)
    path = write_text(out / "comparison.csv", _csv(rows, ["run", "stage", "blocks", *columns]))
    _print(runs[0], shown, _relabelled(pooled, labels))  # last: who reads it may have gone
    return path


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


def _labels(models: list[SavedModel], scored: list[Scored]) -> dict[str, str]:
    """What is shown, by what it is called: models of one type that predict the same are shown once, with how many they are."""
    left, by_name = [each for _, each in scored], {model.name: model for model in models}
    kinds = dict.fromkeys(model.kind for model in models)
    groups = [group for kind in kinds for group in alike(left, [model.name for model in models if model.kind == kind])]
    names = distinct_names([by_name[group[0]] for group in groups])
    counts = [f" ({len(group)} ×)" if len(group) > 1 else "" for group in groups]
    return {UNCOMPENSATED: UNCOMPENSATED} | {name + count: group[0] for name, count, group in zip(names, counts, groups, strict=True)}


def _relabelled(values: Mapping[str, Any], labels: dict[str, str]) -> dict[str, Any]:
    return {label: values[name] for label, name in labels.items()}


def _draw(out: Path, scored: list[Scored], shown: list[dict[str, Any]], labels: dict[str, str], pooled: dict[str, float]) -> None:
    # Matplotlib and TensorBoard take a second to import: only here, once the work is done.
    from torch.utils.tensorboard import SummaryWriter

    from zoo.report.comparison_figure import colors_of, residual_figure, rms_figure
    from zoo.report.palette import styled

    unit, overall = symbol(scored[0][0].unit), _relabelled(pooled, labels)
    with styled(), SummaryWriter(str(out / "tensorboard")) as board:
        figures = {"comparison": rms_figure(shown, overall, unit)}
        for one, left in scored:
            hours = (one.block_mean(one.time) / 3600).numpy()
            curves = {label: value.numpy() for label, value in _relabelled(left, labels).items()}
            figures[f"residual_{one.name}"] = residual_figure(one.name, hours, curves, unit, colors_of(overall))
        for name, figure in figures.items():
            figure.savefig(out / f"{name}.png", dpi=100)
            board.add_figure(name, figure)
        for name, value in pooled.items():
            board.add_scalar(f"rms/{name}", value)


def _print(first: Run, shown: list[dict[str, Any]], overall: dict[str, float]) -> None:
    from zoo.report.comparison_table import print_comparison

    print_comparison(f"RMS of the error [{symbol(first.unit)}], {first.average_s:g} s means", shown, list(overall), overall)
