"""The exported files: made, tried against the model, and only then written, all of them or none."""

from __future__ import annotations

import datetime
import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from torch import Tensor

from zoo.artifacts import replacing
from zoo.export.files import FORMATS, METADATA, PROGRAM, SCRIPT, STEP
from zoo.export.narrowed import narrowed
from zoo.export.parity import AGREEMENT, STEPPED, Files, differences
from zoo.export.program import to_programs
from zoo.export.torchscript import to_torchscript
from zoo.measurements.run import OUTPUT
from zoo.models.base import Model
from zoo.models.example import example_within
from zoo.models.ranges import ROOM, Ranges, Watched
from zoo.units import output_suffix, symbol

CALL = "step.pt2: (row of inputs, state) -> (prediction, state), the first state step_state times NaN; in it first the time of the last row used"
"""How the file that keeps no state of its own is used, for the metadata."""
MEANING = {
    "inputs": "columns of a row, in this order",
    "inputs_without_influence": "columns that the model was given and that decide nothing: not among the inputs",
    "trained_range": "lowest and highest of each column, rate and lag in the fitted runs; null where any value is as good as another",
    "room_outside": "step_checked and refuse_outside take a value for inside up to this share of the range beyond its ends",
    "refuse_outside": "whether predictions outside are NaN",
    "step_state": "numbers of step.pt2's state",
    "features": "how each feature comes from its column, row by row",
    "formula": "the model in physical units, of the features; of physical effects their formulas, parameters under physical",
    "physical": "parameters with standard errors",
    "settings": "the model's class and its arguments",
    "average_s": "block means that the model was fitted and judged on",
    "parity": "largest differences between files and model, measured as they were written",
}
"""What the metadata's fields are, for who has nothing else."""
PLAIN = {"v": "V", "ut": "µT", "pct": "%", "kpa": "kPa"}
"""Units of columns that the zoo never converts, by suffix."""


def write_export(
    model: Model,
    unit: str,
    ranges: Ranges,
    recorded: Mapping[str, Tensor],
    out: Path,
    *,
    about: Mapping[str, Any],
    refuse_outside: bool = False,
    program: bool = True,
) -> dict[str, Any]:
    """Write a trained model as ``model.ts``, ``model.pt2``, ``step.pt2`` and ``metadata.json``.

    Args:
        model: on the CPU, in evaluation mode.
        unit: of its prediction.
        ranges: of the raw columns, rates and lags that it was fitted to.
        recorded: (T, C) raw columns of runs to try the files on, by name; a made-up run is tried besides.
        out: folder of the files.
        about: what is known of the model, first in the metadata.
        refuse_outside: whether the files give NaN outside of the trained range.
        program: whether the files of `torch.export` are wanted as well.

    Returns:
        The metadata.

    Raises:
        InputError: this kind of model cannot be exported.
        WorkError: a file does not say what the model says.
    """
    asked = narrowed(model, ranges)
    made_up = example_within(model, ranges)
    own = made_up[:, [model.inputs.index(name) for name in asked.inputs]]
    files = {SCRIPT: to_torchscript(asked, unit, own, ranges, refuse_outside)}
    if program:
        files[PROGRAM], files[STEP] = to_programs(asked, own, ranges, refuse_outside)
    tables = dict(recorded) | {"a made-up run": made_up}
    loaded = Files.of(files)
    apart = differences(model, asked, loaded, tables, ranges if refuse_outside else {})
    metadata = dict(about) | {
        "inputs": list(asked.inputs),
        "input_units": {name: symbol(unit) if name == OUTPUT else input_unit(name) for name in asked.inputs},
        "unit": unit,
        "unit_symbol": symbol(unit),
        "inputs_without_influence": [name for name in model.inputs if name not in asked.inputs],
        "trained_range": {name: list(ranges[name]) if name in ranges else None for name in Watched(asked).names},
        "room_outside": ROOM,
        "refuse_outside": refuse_outside,
        "step_call": CALL if program else None,
        "step_state": None if loaded.fresh is None else len(loaded.fresh),
        "parity": {
            "largest_difference": apart,
            "allowed_over_largest_prediction": AGREEMENT,
            "runs": {name: len(x) for name, x in tables.items()},
            "rows_stepped": STEPPED,
        },
        "files": {name: {"format": FORMATS[name], "bytes": len(file), "sha256": hashlib.sha256(file).hexdigest()} for name, file in files.items()},
        "meaning": MEANING,
        "exported": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    }
    text = json.dumps(metadata, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    _write(out, files | {METADATA: text.encode()})
    return metadata


def input_unit(column: str) -> str | None:
    """The unit in a column's name as usually written; None where it has none."""
    suffix = output_suffix(column, "time", "temperature", "rate", "acceleration", "pulses", "counts")
    return symbol(suffix) if suffix else PLAIN.get(column.rpartition("_")[2])


def _write(out: Path, files: Mapping[str, bytes]) -> None:
    """All files take their places once all are complete; none of an earlier export stays beside them."""
    with ExitStack() as places:
        temporary: Sequence[Path] = [places.enter_context(replacing(out / name)) for name in files]
        for path, file in zip(temporary, files.values(), strict=True):
            path.write_bytes(file)
    for name in FORMATS.keys() - files.keys():  # of an earlier export, with more formats
        (out / name).unlink(missing_ok=True)
