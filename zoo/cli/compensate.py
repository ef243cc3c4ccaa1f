"""The verb `compensate`: subtracts a trained model from recordings of any length."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from omegaconf import DictConfig, OmegaConf
from rich.console import Console
from rich.table import Table
from rich.text import Text

from zoo.artifacts import write_json
from zoo.catalog import load_ranges
from zoo.cli.saved_models import SavedModel, find_model
from zoo.cli.trained_columns import as_trained
from zoo.compensation import Compensation, Compensator, Tally, check_uncompensated, is_compensated, remarks
from zoo.errors import BadRow, InputError
from zoo.export.narrowed import narrowed
from zoo.measurements.files import find_files, run_names, suffix
from zoo.measurements.read import check_settings
from zoo.measurements.schema import Layout, check_references, layout
from zoo.measurements.table import column_names
from zoo.models.example import example
from zoo.models.prediction import usable_device
from zoo.models.streaming import check_streams
from zoo.progress import progress
from zoo.report.wording import worse_than_none
from zoo.threads import threads_for
from zoo.units import own_time, symbol

RESULT = "compensation.json"
STEPS = 1000
"""Of the progress bar."""


def run(config: DictConfig, out: Path) -> Path:
    """Predict, subtract, write each file again.

    Args:
        config: as composed from conf/compensate.yaml.
        out: folder of the results.

    Returns:
        The folder; the new file where there is one.
    """
    device, asked = usable_device(config.torch_device), str(config.run)
    data: dict[str, Any] = OmegaConf.to_container(config.data, resolve=True, throw_on_missing=True)  # type: ignore[assignment]
    check_settings(data["reference"], data["average_s"], data["gap_s"], data["bad_rows"])
    saved = find_model("run", asked)
    layouts = _layouts(as_trained(data, saved.folder))
    targets = _targets([one.path for one in layouts], out)
    with threads_for(0):
        compensator = _compensator(saved, device)
        skip, short = data["bad_rows"] == "skip", data["time_unit"] is None
        if any(name.startswith("reference_") for name in compensator.used):
            check_references(layouts, data["reference"])
        reference = data["reference"] or 0.0
        passes = [Compensation(compensator, one, reference, _average(data, saved), data["gap_s"], skip, short) for one in layouts]
        done = [_written(one, target) for one, target in zip(passes, targets, strict=True)]
    known = [one.reference is not None or data["reference"] is not None for one in layouts]
    facts = [_facts(*each, compensator) for each in zip(layouts, targets, done, known, strict=True)]
    model = {"path": str(saved.folder), "name": saved.kind}
    write_json(out / RESULT, {"schema_version": 1, "model": model, "files": facts})
    _draw(targets, layouts, done)
    _print(facts)  # last: who reads it may have gone
    return targets[0] if len(targets) == 1 else out


def _layouts(data: dict[str, Any]) -> list[Layout]:
    found = []
    for path in find_files(data["files"]):
        present = column_names(path)
        check_uncompensated(path, present)
        found.append(layout(path, present, data["columns"], data["output_unit"], data["time_unit"], data["temperature_unit"]))
    return found


def _targets(paths: Sequence[Path], out: Path) -> list[Path]:
    """The new files: called as the old ones, with the folder's name before it where two are called alike, and a number where that is not enough."""
    targets: list[Path] = []
    for name, path in zip(run_names(paths), paths, strict=True):
        kind = path.name[-len(suffix(path)) :]
        stem = name.removesuffix(kind).strip("/").replace("/", "_")
        possible = (out / f"{stem}{number}{kind}" for number in ("", *(f"_{place}" for place in range(2, len(paths) + 1))))
        targets.append(next(one for one in possible if one not in targets))
    there = {path.resolve() for path in paths}
    for target in targets:
        if target.resolve() in there:
            raise InputError(f"{target}: would be overwritten by its compensated self; choose another folder with hydra.run.dir=…")
        if target.exists() and not is_compensated(column_names(target)):
            raise InputError(f"{target}: is there, and nothing that was compensated; choose another folder with hydra.run.dir=…")
    return targets


def _compensator(saved: SavedModel, device: Any) -> Compensator:
    """The model, tried before a long file is."""
    ranges = load_ranges(saved.folder)
    tried = example(saved.module.inputs, ranges)
    check_streams(saved.module, tried)
    named = [name.removeprefix("reference_") for name in saved.module.inputs if name.startswith("reference_")]
    unit = saved.facts.get("unit") or (named[0] if named else None)
    used = narrowed(saved.module, ranges).inputs[1:]
    return Compensator(saved.module.to(device), unit, ranges, used)


def _average(data: dict[str, Any], saved: SavedModel) -> Any:
    """Length of the blocks: as given, else as in the training."""
    given = data["average_s"]
    return saved.facts.get("average_s", "auto") if given in (None, "auto") else given


def _written(one: Compensation, target: Path) -> Tally:
    try:
        return _with_progress(one, target)
    except BadRow as error:
        raise InputError(f"{error}; with data.bad_rows=skip such rows get empty cells") from error


def _with_progress(one: Compensation, target: Path) -> Tally:
    with progress(target.name, STEPS) as advance:
        told = 0

        def tell(share: float) -> None:
            nonlocal told
            steps = int(share * STEPS) - told
            told += steps
            advance(steps)

        return one.write(target, tell)


def _facts(one: Layout, target: Path, tally: Tally, known: bool, compensator: Compensator) -> dict[str, Any]:
    """What is told of one file; numbers are of block means, [output's unit]."""
    error, predicted = tally.blocks[:, 1], tally.blocks[:, 2]
    before, after = (_numbers(value) for value in (error, error - predicted))
    notes = remarks(one, tally, compensator.ranges)
    if before and not before["std"]:
        notes.append("the output never changes: is it a recording of a gyro that was on?")
    if known and before and after and (worse := worse_than_none(after["rms"], before["rms"])):
        notes.append(f"{worse}; for this file it is of no use")
    return {
        "file": str(one.path),
        "written": str(target),
        "unit": one.unit,
        "reference_known": known,
        "rows": tally.rows,
        "rows_without_prediction": tally.unpredicted,
        "rows_outside": {name: {"rows": count, "from": low, "to": high} for name, (count, low, high) in tally.outside.items()},
        "average_s": tally.average_s,
        "blocks": len(tally.blocks),
        "before": before,
        "after": after,
        "notes": notes,
    }


def _numbers(value: np.ndarray) -> dict[str, float] | None:
    if not len(value):
        return None
    return {"mean": float(value.mean()), "std": float(value.std()), "rms": float(np.sqrt(np.square(value).mean()))}


def _draw(targets: list[Path], layouts: list[Layout], done: list[Tally]) -> None:
    from zoo.report.canvas import write_png  # matplotlib takes a second to import: only once the work is done
    from zoo.report.compensation_figure import compensation_figure
    from zoo.report.palette import styled

    with styled():
        for target, name, one, tally in zip(targets, _distinct(targets), layouts, done, strict=True):
            if len(tally.blocks) > 1:
                time_s, error, predicted = tally.blocks[:, 0], tally.blocks[:, 1], tally.blocks[:, 2]
                hours = own_time(time_s, float(time_s[0])) / 3600
                figure = compensation_figure(name, hours, error, predicted, symbol(one.unit))
                write_png(target.with_name(f"{name}.png"), figure)


def _distinct(targets: list[Path]) -> list[str]:
    """The new files' stems; their names in full where two of one stem are of different kinds."""
    stems = [target.name.removesuffix(suffix(target)) for target in targets]
    return stems if len(set(stems)) == len(stems) else [target.name for target in targets]


def _print(facts: list[dict[str, Any]]) -> None:
    """A row a file, and below what should be known of each."""
    console = Console(highlight=False)
    table = Table("file", "rows", "means of", "", "mean", "σ", "RMS", box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for one in facts:
        start = [Path(one["written"]).name, str(one["rows"]), f"{one['average_s']:g} s [{symbol(one['unit'])}]"]
        for when, first in (("before", start), ("after", ["", "", ""])):
            table.add_row(*(Text(cell) for cell in (*first, when, *_cells(one[when], one["reference_known"]))))
    needed = console.measure(table, options=console.options.update(width=10_000)).maximum
    console.print(table, width=None if console.is_terminal else max(needed, console.width), crop=False)
    for one in facts:
        for note in one["notes"]:
            console.print(Text(f"{Path(one['written']).name}: {note}"), soft_wrap=True)
    if not all(one["reference_known"] for one in facts):
        unknown = [Path(one["written"]).name for one in facts if not one["reference_known"]]
        of = f" of {', '.join(unknown)}" if len(unknown) < len(facts) else ""
        told = (
            f"the true input{of} is neither recorded nor given (data.reference), so the mean and σ are those of output less 0, whatever the gyro did"
        )
        console.print(Text(told), soft_wrap=True)


def _cells(numbers: dict[str, float] | None, known: bool) -> list[str]:
    if numbers is None:
        return ["–"] * 3
    return [f"{numbers['mean']:.4g}", f"{numbers['std']:.4g}", f"{numbers['rms']:.4g}" if known else "–"]
