"""What several verbs do with their config: read the runs named in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

from omegaconf import DictConfig, OmegaConf, open_dict

from zoo.catalog import create
from zoo.errors import InputError
from zoo.measurements.files import find_files
from zoo.measurements.points import Points
from zoo.measurements.run import SHARES, Run


def read_data(config: DictConfig) -> tuple[list[Run], list[Run]]:
    """The runs to fit and the runs only to check on, from `config.data`.

    The block length found for the fitted runs is used for the others as well. `data.holdout` keeps pieces of every run for checking, `data.points`
    single blocks.

    Raises:
        InputError: the settings or files are wrong.
    """
    data = config.data.copy()
    with open_dict(data):
        simulated = data.pop("simulated", None)
        if simulated is not None:
            from zoo.cli.simulated_data import recorded  # the simulator, only where it is asked

            _put_into(recorded(_plain(simulated), Path(data.pop("folder"))), data)
        check_files, holdout, points = data.pop("check_files", []), data.pop("holdout", 0.0), _points(data.pop("points"))
    low, high = SHARES
    if not isinstance(holdout, int | float) or not (holdout == 0 or low <= holdout <= high):
        raise InputError(f"data.holdout={holdout}: 0 is possible, or a share of each run from {low} to {high}, taken to whole tenths")
    if holdout > 0 and not points.all:
        raise InputError("data.holdout and data.points: both say what is fitted; one of them is possible")
    runs, checks = points.drawn(points.meeting(create(data)))
    if holdout > 0:
        pairs = [run.split(holdout) for run in runs]
        runs, checks = [early for early, _ in pairs], [late for _, late in pairs]
    if check_files:
        _check_unseen(check_files, data.files)
        average_s = data.average_s if data.average_s is None else runs[0].average_s
        found = create(data, files=[check_files] if isinstance(check_files, str) else list(check_files), average_s=average_s)
        checks += points.meeting([_alike(run, runs[0]) for run in found])
    return runs, checks


def _points(given: Any) -> Points:
    """Which single blocks are asked for; null is for all."""
    if given is not None and not OmegaConf.is_dict(given):
        raise InputError(f"data.points={given}: null is possible, or data.points.where=…, data.points.fitted=…, data.points.checked=…")
    return Points() if given is None else cast(Points, create(given))


def _put_into(place: Path, data: DictConfig) -> None:
    """Let the names of files be those of a recording."""
    for key in ("files", "check_files"):
        data[key] = [str(place / name) for name in data[key]]


def _check_unseen(check_files: Any, files: Any) -> None:
    fitted = {path.resolve() for path in find_files(_plain(files))}
    twin = next((path for path in find_files(_plain(check_files)) if path.resolve() in fitted), None)
    if twin:
        raise InputError(f"data.check_files: {twin} is in data.files too; a run that was fitted checks nothing")


def _plain(value: Any) -> Any:
    return OmegaConf.to_container(value) if OmegaConf.is_config(value) else value


def _alike(run: Run, fitted: Run) -> Run:
    lacking = [name for name in fitted.columns if name not in run.columns]
    if run.unit != fitted.unit:
        raise InputError(f"data.check_files: {run.name} is in {run.unit}, the fitted runs are in {fitted.unit}; one unit is needed")
    if lacking:
        raise InputError(f"data.check_files: {run.name} lacks the column {', '.join(lacking)} that the fitted runs have")
    return run
