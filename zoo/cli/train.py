"""The verb `train`: fits one model of the zoo and scores it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from zoo.artifacts import write_json
from zoo.catalog import create, load
from zoo.cli.command_line import is_typed, plain, searchpath
from zoo.cli.doubts import print_doubts
from zoo.cli.effects import chosen
from zoo.cli.inputs import print_notes, read_data
from zoo.cli.outcomes import made_from
from zoo.cli.saved_models import keep_model
from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.training.files import CHECKPOINT, MEMBERS, PICTURE
from zoo.training.resume import unfinished
from zoo.training.run import EVENTS, train
from zoo.units import own_time, symbol

METRICS = "metrics.json"


def run(config: DictConfig, out: Path) -> Path:
    """Train and write.

    Args:
        config: as composed from conf/train.yaml.
        out: folder of the results.

    Returns:
        The metrics' file.

    Raises:
        InputError: the settings do not fit together.
    """
    trained(config, *read_data(config), out, HydraConfig.get().runtime.choices)
    return out / METRICS


def trained(config: DictConfig, runs: Sequence[Run], check_runs: Sequence[Run], out: Path, choices: Mapping[str, Any]) -> dict[str, Any]:
    """Train, write, draw and print.

    Args:
        config: as composed from conf/train.yaml.
        runs: fitted.
        check_runs: only scored.
        out: folder of the results.
        choices: what was chosen of every config group.

    Returns:
        The metrics.

    Raises:
        InputError: the settings do not fit together.
    """
    settings, model, metrics = fitted(config, runs, check_runs, out, choices)
    keep_model(out, settings, model, runs, own=[CHECKPOINT, *([MEMBERS] if "members" in metrics else [])])
    _draw(out, model, [*runs, *check_runs])
    write_json(out / METRICS, {"schema_version": 1} | metrics)
    print_notes([*runs, *check_runs])
    print_doubts(model, runs, metrics, unused=[key for key in ("init", "epochs", "goal") if is_typed(key)] if metrics["init"] is None else [])
    _print(metrics)  # last: who reads it may have gone
    return metrics


def fitted(
    config: DictConfig, runs: Sequence[Run], check_runs: Sequence[Run], out: Path, choices: Mapping[str, Any]
) -> tuple[dict[str, Any], Model, dict[str, Any]]:
    """The same without a word: the model's settings in full, the model, and the metrics; a checkpoint and TensorBoard's events are left in `out`."""
    model_config = _model_config(config, runs)
    model = create(model_config)
    optimizer_name, optimizer = _optimizer(config, model, choices)
    drawn = not hasattr(optimizer, "fit") and getattr(optimizer, "starts_from_init", True)
    labels = {"model": _choice(choices, "model"), "init": _choice(choices, "init") if drawn else None, "optimizer": optimizer_name}
    settings = _settings(config)
    metrics = train(
        model,
        runs,
        check_runs,
        optimizer=optimizer,
        init=create(config.init) if drawn else None,
        epochs=config.epochs,
        goal=config.goal,
        batch_size=config.batch_size,
        seed=config.seed,
        seeds=config.seeds,
        device=config.torch_device,
        resume=_unfinished(out, settings) or _checkpoint(config.resume),
        out=out,
        labels=labels,
        hyperparameters=dict(_scalars(model_config, "model")) | dict(_scalars(plain(config.optimizer), "optimizer")),
        settings=settings,
    )
    return model_config, model, metrics


def _scalars(settings: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    """What TensorBoard can sort and filter trainings by."""
    for key, value in settings.items():
        if isinstance(value, bool | int | float | str) and not str(key).startswith("_"):
            yield f"{prefix}.{key}", value
        elif isinstance(value, list) and all(isinstance(one, str | int | float) for one in value):
            yield f"{prefix}.{key}", ", ".join(map(str, value))


def _choice(choices: Mapping[str, Any], group: str) -> str | None:
    choice = choices.get(group)
    return None if choice is None else Path(str(choice)).name


def _model_config(config: DictConfig, runs: Sequence[Run]) -> dict[str, Any]:
    """The model's settings in full; `inputs: null` means every column that the runs have."""
    settings: dict[str, Any] = plain(config.model)
    if "inputs" in settings and settings["inputs"] is None:
        settings["inputs"] = list(runs[0].columns)
    if isinstance(settings.get("network"), str):  # its name alone
        settings["network"] = plain(load("model", settings["network"], searchpath()))
    if "effects" in settings:
        chosen(config)  # a wrong one is refused by name here; the model makes its own
    return settings


def _optimizer(config: DictConfig, model: Model, choices: Mapping[str, Any]) -> tuple[str | None, Any]:
    """The optimizer chosen, or under `optimizer=auto` the one that the model's class names in `fitted_by`."""
    if "_target_" in config.optimizer:
        return _choice(choices, "optimizer"), create(config.optimizer)
    name = getattr(model, "fitted_by", "adam")
    settings = load("optimizer", name, searchpath())
    given = {key: value for key, value in config.optimizer.items() if value is not None}
    unknown = [str(key) for key in given if key not in settings]
    if unknown:
        raise InputError(f"optimizer.{unknown[0]}: optimizer={name}, which this model asks for, has no such setting")
    return name, create(settings, **given)


def _checkpoint(resume: str | None) -> Path | None:
    if resume is None:
        return None
    given = Path(str(resume))  # folders of a multirun are called by numbers
    path = given / CHECKPOINT if given.is_dir() else given
    if not path.is_file():
        raise InputError(f"resume={resume}: no checkpoint there; give the output folder of a train command, or its {CHECKPOINT}")
    return path


def _settings(config: DictConfig) -> str:
    """All that decides where a training leads, as text: a checkpoint tells by it whether it belongs to this command and these measurements."""
    return made_from(config, but=("hydra", "epochs", "torch_device", "objective"))


def _unfinished(out: Path, settings: str) -> Path | None:
    """The same command in the same folder goes on from where it was killed."""
    found = unfinished(out, settings)
    if found is not None:
        print(f"going on from {found}, which an earlier training has left")
    return found


def _draw(out: Path, model: Model, runs: Sequence[Run]) -> None:
    # Matplotlib and TensorBoard take a second to import: only here, once the work is done.
    from torch.utils.tensorboard import SummaryWriter

    from zoo.models.prediction import predict_blocks
    from zoo.report.canvas import write_png
    from zoo.report.palette import styled
    from zoo.report.prediction_figure import Prediction, prediction_figure

    curves = []
    for one in runs:
        hours, error, predicted = own_time(one.block_mean(one.time), float(one.time[0])) / 3600, one.block_mean(one.error), predict_blocks(model, one)
        curves.append(Prediction(one.name, hours.numpy(), error.numpy(), predicted.numpy()))
    with styled(), SummaryWriter(str(out / EVENTS)) as board:
        figure = prediction_figure(curves, symbol(runs[0].unit))
        write_png(out / PICTURE, figure)
        board.add_figure("prediction", figure)


def _print(metrics: dict[str, Any]) -> None:
    title = f"RMS of the error [{symbol(metrics['unit'])}], {metrics['average_s']:g} s means"
    console = Console()
    table = Table("run", "used for", "uncompensated", str(metrics["model"]), title=escape(title))
    for use in ("runs", "check_runs"):
        for one in metrics[use]:
            table.add_row(escape(one["run"]), "fit" if use == "runs" else "check", f"{one['uncompensated']:.4g}", f"{one['rms']:.4g}")
    console.print(table)
    if "members" in metrics:
        _print_members(console, metrics)


def _print_members(console: Console, metrics: dict[str, Any]) -> None:
    members = metrics["members"]
    alike = members["rms_quantiles"]["low"] == members["rms_quantiles"]["high"]
    title = f"{len(members['seeds'])} seeds, {'all alike' if alike else 'the best of the fit first'}"
    table = Table("used for", f"seed {members['best_seed']}", "median", "90 % range", title=title)
    for use, key in (("fit", "rms"), ("check", "rms_check")):
        if members[key] is not None:
            spread = members[f"{key}_quantiles"]
            table.add_row(use, f"{metrics[key]:.4g}", f"{spread['median']:.4g}", f"{spread['low']:.4g} … {spread['high']:.4g}")
    console.print(table)
    if members["failed_seeds"]:
        console.print(f"training failed with {len(members['failed_seeds'])} more: {', '.join(map(str, members['failed_seeds']))}")
