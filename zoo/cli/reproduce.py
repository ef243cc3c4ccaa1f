"""The verb `reproduce`: a paper's methods trained by its protocol, and its tables and figures beside ours."""

from __future__ import annotations

import importlib
import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any, cast

import pandas as pd
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, open_dict
from rich.console import Console
from rich.table import Table
from rich.text import Text
from torch import Tensor

from zoo.artifacts import writable_folder, write_text
from zoo.catalog import create, load_members, load_model, names
from zoo.cli.command_line import composed, searchpath, typed
from zoo.cli.inputs import read_data
from zoo.cli.papers import GROUP
from zoo.cli.simulated_data import NOISELESS
from zoo.cli.train import fitted, trained
from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.measurements.write import write_measurements
from zoo.models.base import Model
from zoo.models.prediction import predict_blocks, predict_blocks_of_each
from zoo.papers.study import Claim, Row, Study, seed_by_seed
from zoo.processes import in_processes
from zoo.progress import progress
from zoo.scoring.stages import rms

TABLE, TEXT, FIGURES, METHODS = "table.csv", "table.md", "figures", "methods"
OtherData = Mapping[str, tuple[Sequence[Run], Sequence[Run]]]
"""Runs to fit and runs to check on, by name: what every method is fitted to besides the paper's runs."""
OF_A_METHOD = ("model", "optimizer", "init")
"""Config groups that say what a method is."""
Task = tuple[DictConfig, Sequence[Run], Sequence[Run], Mapping[str, Any]]
"""Settings of a training, the runs to fit and to check on, and what was chosen of every config group."""


def run(config: DictConfig, out: Path) -> Path:
    """Train every method and compare with what the paper prints.

    Args:
        config: as composed from conf/reproduce.yaml.
        out: folder of the results: the table, the figures, and a folder of `train` for each method.

    Returns:
        The table's file.

    Raises:
        InputError: no paper, or settings that do not fit.
    """
    if "paper" not in config:
        raise InputError(f"paper is not set; possible: {', '.join(names(GROUP, searchpath()))}")
    paper, console = importlib.import_module(config.paper), Console()
    settings = {str(name): _composed(config, list(own)) for name, own in config.methods.items()}
    runs, checks = read_data(config)
    others: OtherData = create(config.others) if "others" in config else {}
    floors = _floors(config, [*runs, *checks])
    _check_complete(paper, list(settings), runs, checks, others, floors)
    predicted: dict[str, dict[int, list[Tensor]]] = {}
    for place, (name, own) in enumerate(settings.items(), 1):
        console.print(Text(f"{place}/{len(settings)} {name}"))
        folder = writable_folder(out / METHODS / re.sub(r"\W+", "_", name).lower())
        predicted[name] = _predicted(own, runs, checks, folder)
    elsewhere = _predicted_elsewhere(settings, others)
    apart = {data: Study.of([*fit, *check], len(fit), elsewhere[data]) for data, (fit, check) in others.items()}
    study = Study.of([*runs, *checks], len(runs), seed_by_seed(predicted), apart)
    rows, claims = paper.rows(study), paper.claims(study, floors)
    _write(study, rows, claims, config, out)
    _print(claims, console)
    print(f"tables beside the paper's: {out / TEXT}\nfigures: {out / FIGURES}")
    return out / TABLE


def _composed(config: DictConfig, own: list[str]) -> DictConfig:
    """The settings of one method, as `fogzoo train` would have them: the experiment's, the user's, the method's own.

    Raises:
        InputError: something was typed that makes another method of it.
    """
    given = [one for one in typed() if not one.lstrip("+~").startswith((f"{GROUP}=", "methods"))]
    other = next((one for one in given if one.partition("=")[0] in OF_A_METHOD), None)
    if other:
        raise InputError(f"{other}: every method of a paper has its own; to try another beside them: '+methods.mine=[{other}]'")
    paper = HydraConfig.get().runtime.choices[GROUP]
    return composed("train", [f"{GROUP}={paper}", f"seeds={config.seeds}", *given, *own], with_hydra=True)


def _check_complete(
    paper: ModuleType, methods: list[str], runs: Sequence[Run], checks: Sequence[Run], others: OtherData, floors: list[float]
) -> None:
    """Try what will be said at the end, with half of each error for a prediction, before hours are spent.

    Raises:
        InputError: a method or a run is missing.
    """

    def tried(fit: Sequence[Run], check: Sequence[Run], apart: Mapping[str, Study]) -> Study:
        half = [0.5 * one.block_mean(one.error).unsqueeze(0) for one in (*fit, *check)]
        return Study.of([*fit, *check], len(fit), dict.fromkeys(methods, half), apart)

    study = tried(runs, checks, {data: tried(*each, {}) for data, each in others.items()})
    try:
        paper.rows(study)
        paper.claims(study, floors)
    except LookupError as error:
        told = f"the method {error}" if isinstance(error, KeyError) else "a run"
        kept = "leave its methods, data.files and data.check_files as they are"
        raise InputError(f"{told} is missing, which the paper's tables compare; {kept}") from error


def _predicted(config: DictConfig, runs: Sequence[Run], checks: Sequence[Run], folder: Path) -> dict[int, list[Tensor]]:
    """(N,) predictions of one method for every run, by seed."""
    choices, config = config.hydra.runtime.choices, config.copy()
    with open_dict(config):
        del config["hydra"]
    trained(config, runs, checks, folder, choices)
    members = load_members(folder) if config.seeds > 1 else [(int(config.seed), load_model(folder))]
    predicted = [predict_blocks_of_each(cast(list[Model], [module for _, module in members]), one) for one in (*runs, *checks)]
    return {seed: [one[place] for one in predicted] for place, (seed, _) in enumerate(members)}


def _predicted_elsewhere(settings: Mapping[str, DictConfig], others: OtherData) -> dict[str, dict[str, list[Tensor]]]:
    """(1, N) predictions for every run of other data by every method, fitted to each with a seed of its own; nothing is kept of these trainings."""
    tasks: dict[tuple[str, str], Task] = {}
    for method, config in settings.items():
        for place, (data, (runs, checks)) in enumerate(others.items()):
            own = config.copy()
            with open_dict(own):
                del own["hydra"]
                own.seed, own.seeds = config.seed + place, 1
            tasks[data, method] = own, runs, checks, dict(config.hydra.runtime.choices)
    keys, found = list(tasks), {}
    known = partial(_in_this_application, HydraConfig.instance().cfg)
    with progress("other data", len(tasks)) as advance:
        for place, predicted in in_processes(_fitted_alone, tasks.values(), first=known):
            found[keys[place]] = predicted
            advance()
    return {data: {method: found[data, method] for method in settings} for data in others}


def _fitted_alone(task: Task) -> list[Tensor]:
    config, runs, checks, choices = task
    with TemporaryDirectory() as folder:
        _, model, _ = fitted(config, runs, checks, Path(folder), choices)
    return [predict_blocks(model, one).unsqueeze(0) for one in (*runs, *checks)]


def _in_this_application(known: Any) -> None:
    """For a process of its own: Hydra is asked there, too, where the user's own configs lie."""
    HydraConfig.instance().set_config(known)


def _floors(config: DictConfig, runs: Sequence[Run]) -> list[float]:
    """RMS of the noise of every run's block means [output's unit]: recorded less what a gyro without noise would have shown.

    Raises:
        InputError: the runs are none that `fogzoo` has simulated.
    """
    quiet = config.copy()
    with open_dict(quiet):
        for key in ("files", "check_files"):
            quiet.data[key] = [f"{NOISELESS}{name}" for name in config.data[key]]
    try:
        known = [one for part in read_data(quiet) for one in part]
    except InputError as error:
        raise InputError(f"a paper's experiment needs runs whose noise is known, as data=… of a paper simulates them: {error}") from error
    return [rms(one.block_mean(one.error) - true.block_mean(true.error)) for one, true in zip(runs, known, strict=True)]


def _write(study: Study, rows: list[Row], claims: list[Claim], config: DictConfig, out: Path) -> None:
    # Matplotlib takes a second to import: only here, once the work is done.
    from zoo.report.canvas import write_png
    from zoo.report.palette import styled
    from zoo.report.paper_figures import table_text

    folder, paper = writable_folder(out / FIGURES), importlib.import_module(config.paper)
    with styled():
        for name, figure in importlib.import_module(config.get("figures", "zoo.report.drift_figures")).figures(study, rows).items():
            write_png(folder / f"{name}.png", figure)
    write_text(out / TEXT, table_text(rows, claims, str(paper.__doc__).strip().splitlines()[0], getattr(paper, "REMARKS", ())))
    write_measurements(out / TABLE, pd.DataFrame([row.record() for row in rows]).rename(columns={"low": "ours_low", "high": "ours_high"}))


def _print(claims: list[Claim], console: Console) -> None:
    table = Table("", "found", "")
    for claim in claims:
        table.add_row(claim.text, claim.value, "yes" if claim.holds else "[bold]no[/bold]")
    console.print(table)
