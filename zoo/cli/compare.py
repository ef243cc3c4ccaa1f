"""The verb `compare`: models, exported files and predictions made elsewhere side by side, over seeds and against the noise."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from omegaconf import DictConfig, OmegaConf
from rich.console import Console
from rich.progress import track
from rich.text import Text
from torch import Generator, Tensor

from zoo.artifacts import write_json, write_text
from zoo.catalog import names
from zoo.cli.command_line import plain
from zoo.cli.entrants import find_entrants, given_predictions, named
from zoo.cli.given_predictions import named_files
from zoo.cli.inputs import print_notes, read_data
from zoo.cli.trained_columns import as_trained
from zoo.comparison.entrant import Entrant
from zoo.comparison.judging import Scored, judge
from zoo.comparison.known_noise import KnownNoise, floors
from zoo.comparison.methods import methods_of
from zoo.errors import InputError, WorkError
from zoo.fitting.noise import of_all
from zoo.measurements.run import Run
from zoo.models.prediction import usable_device
from zoo.scoring.comparison import UNCOMPENSATED, residuals, rms_by_kind, rms_by_stage
from zoo.scoring.noise import CHECK_ALLOWED, DIFFERENCED
from zoo.scoring.stages import Stage, bias_stability, label_stages, rms
from zoo.threads import threads_for
from zoo.units import convert, symbol

WHAT_IT_WAS = ("init", "optimizer", "seed")
MANY = 8
"""From so many models on, progress is shown."""


def run(config: DictConfig, out: Path) -> Path:
    """Predict, score, judge, write.

    Args:
        config: as composed from conf/compare.yaml.
        out: folder of the results.

    Returns:
        The table's file.
    """
    device, files = usable_device(config.torch_device), named_files(plain(config.predictions))
    given = [str(one) for one in (config.runs if OmegaConf.is_list(config.runs) else [config.runs])]
    if not given and not files:
        raise InputError("nothing to compare: give runs=[FOLDER,…] of train or refine, or predictions={NAME: FILES}")
    models, skipped = find_entrants(given) if given else ([], [])
    if skipped:
        Console(stderr=True).print(Text(f"skipped, without a finished model: {', '.join(skipped)}"), style="yellow", soft_wrap=True, highlight=False)
    config = _as_trained(_with_trained_blocks(config, models), models)
    runs = _judged(config)
    print_notes(runs)
    entrants = named([*models, *given_predictions(files, [one.name for one in runs], plain(config.data))])
    scored, stages = _scored(entrants, runs, device, float(config.data.get("holdout", 0.0)))
    judged = judge(methods_of(entrants, names("init")), scored, Generator().manual_seed(config.seed))
    document = _document(entrants, scored, stages) | judged | {"skipped": skipped}
    _write(out, document, scored, stages)
    path = write_text(out / "comparison.csv", _csv(scored.rows, ["run", "stage", "blocks", *document["rms"]]))
    _print(document)  # last: who reads it may have gone
    print(f"page: {out / 'comparison.html'}")
    return path


def _judged(config: DictConfig) -> list[Run]:
    """The runs; under settings that keep pieces of them from a fit, those pieces and the check runs alone, as the rest is what was fitted."""
    runs, check_runs = read_data(config)
    apart = config.data.get("holdout", 0.0) > 0 or (config.data.points is not None and config.data.points.get("checked", 0) > 0)
    judged = check_runs if apart else [*runs, *check_runs]
    short = next((one for one in judged if one.blocks <= DIFFERENCED), None)
    if short is not None:
        few = f"{short.name}: {short.blocks} means of {short.average_s:g} s are too few to tell noise from anything ({DIFFERENCED + 1} at least)"
        raise InputError(f"{few}; leave it out, or give a shorter data.average_s")
    return judged


def _with_trained_blocks(config: DictConfig, models: list[Entrant]) -> DictConfig:
    """Under `data.average_s=auto`, the block length of the training where the models agree on one: noise, and so the RMS, depends on it."""
    lengths = {model.facts.get("average_s") for model in models} - {None}
    if config.data.get("average_s") == "auto" and len(lengths) == 1:
        config = config.copy()
        config.data.average_s = lengths.pop()
    return config


def _as_trained(config: DictConfig, models: list[Entrant]) -> DictConfig:
    """The columns called as in the training of the first model, where nothing is said of them."""
    if not models or OmegaConf.is_missing(config.data, "files") or config.data.get("simulated") is not None:
        return config
    config = config.copy()
    config.data = OmegaConf.create(as_trained(plain(config.data), models[0].folder))
    return config


def _scored(entrants: list[Entrant], runs: list[Run], device: torch.device, holdout: float) -> tuple[Scored, list[list[Stage]]]:
    """Every entrant predicts every run once."""
    watched, predicted = Console(stderr=True), [dict[str, Tensor]() for _ in runs]
    moved = [one.to(device) for one in runs]
    quiet = not watched.is_terminal or len(entrants) < MANY
    with threads_for(max(one.table.numel() for one in runs)):
        for entrant in track(entrants, "predicting", console=watched, transient=True, disable=quiet):
            for one, found in zip(moved, predicted, strict=True):
                found[entrant.name] = _prediction(entrant, one, device)
    left = [residuals(one.block_mean(one.error), found) for one, found in zip(runs, predicted, strict=True)]
    stages = [label_stages(one.block_mean(one.time), one.block_mean(one.temperature)) for one in runs]
    rows = [{"run": one.name} | row for one, each, cut in zip(runs, left, stages, strict=True) for row in rms_by_kind(each, cut)]
    return Scored(runs, left, rows, holdout, _known_noise(entrants, left, runs)), stages


def _known_noise(entrants: list[Entrant], left: list[dict[str, Tensor]], runs: list[Run]) -> KnownNoise | None:
    """What a refinement among them has found, if its model comes down to that here as well; of several, that of the one which leaves least."""
    known = {one.name: noise for one in entrants if (noise := one.noise) and all(map(noise.applies, runs))}
    if not known:
        return None
    least, best = min((rms(torch.cat([each[name] for each in left])), name) for name in known)
    return known[best] if least <= CHECK_ALLOWED * of_all(runs, floors(runs, known[best]).values()) else None


def _prediction(entrant: Entrant, one: Run, device: torch.device) -> Tensor:
    """(N,) predicted error of one run [output's unit]."""
    unit = entrant.unit(one)
    try:
        asked = one.in_unit(unit)
    except InputError as error:
        raise InputError(f"{entrant.folder}: was trained on errors in {symbol(unit)}; {one.name} is in {symbol(one.unit)}: {error}") from error
    predicted = convert(entrant.predict(asked, device), unit, one.unit)
    if entrant.facts.get("refuse_outside") and bool(predicted.isnan().any()):
        where = f"exported with refuse_outside=true, and {one.name} goes beyond what it was trained on"
        raise InputError(f"{entrant.folder}: {where}; export it again without, or leave out that run")
    if not bool(torch.isfinite(predicted).all()):
        raise WorkError(f"{entrant.folder}: predicts values that are no numbers for {one.name}")
    return predicted


def _document(entrants: list[Entrant], scored: Scored, stages: list[list[Stage]]) -> dict[str, Any]:
    first = scored.runs[0]
    return {
        "schema_version": 1,
        "unit": first.unit,
        "average_s": first.average_s,
        "models": [{"name": one.name, "folder": str(one.folder)} | {key: one.facts.get(key) for key in WHAT_IT_WAS} for one in entrants],
        "rows": scored.rows,
        "runs": [
            {"run": one.name, "bias_stability": {name: bias_stability(value) for name, value in left.items()}, "stages": rms_by_stage(left, cut)}
            for one, left, cut in zip(scored.runs, scored.left, stages, strict=True)
        ],
    }


def _csv(rows: list[dict[str, Any]], columns: list[str]) -> str:
    import pandas as pd

    text: str = pd.DataFrame(rows, columns=columns).to_csv(index=False, float_format="%.6g", lineterminator="\n")
    return text


def _write(out: Path, document: dict[str, Any], scored: Scored, stages: list[list[Stage]]) -> None:
    # Matplotlib and TensorBoard take a second to import: only here, once the work is done.
    from zoo.report.comparison_events import write_comparison_events
    from zoo.report.comparison_page import write_comparison
    from zoo.report.comparison_words import headline, statement
    from zoo.report.run_figure import Curves

    for pair in document["pairs"]:
        pair["statement"] = statement(pair)
    document["statement"] = headline(document)
    typical = {one["name"]: one["typical"] for one in document["methods"]}
    curves = [
        Curves.of(one, cut, {UNCOMPENSATED: left[UNCOMPENSATED]} | {name: left[model] for name, model in typical.items()})
        for one, cut, left in zip(scored.runs, stages, scored.left, strict=True)
    ]
    write_json(out / "comparison.json", document)
    write_comparison(out, document, curves)
    write_comparison_events(out, document, curves)


def _print(document: dict[str, Any]) -> None:
    from zoo.report.comparison_table import print_comparison

    print_comparison(document)
