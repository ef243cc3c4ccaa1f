"""The verb `export`: a trained model as files that run with torch alone."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import chdir, nullcontext
from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from rich.console import Console

from zoo.catalog import MODEL_FILE, RANGES_FILE, load_ranges
from zoo.cli.inputs import read_data
from zoo.cli.saved_models import SavedModel, command_config, find_model, given_in, physical_values
from zoo.comparison.facts import fitted_runs
from zoo.errors import InputError
from zoo.export.files import SCRIPT
from zoo.export.write import input_unit, write_export
from zoo.given import check_switch
from zoo.measurements.run import OUTPUT, Run
from zoo.models.features import RATE, Features
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.prediction import raw_columns, usable_device
from zoo.models.ranges import unknown_ranges
from zoo.threads import threads_for
from zoo.training.run import versions
from zoo.units import symbol

TOLD = (
    *("init", "optimizer", "seed", "average_s", "rms", "rms_check", "rms_uncompensated", "rms_check_uncompensated"),
    *("noise_floor", "noise_floor_by_run", "noise", "verdict"),
)
"""What the metadata take from the result file of the training, where it has it."""


def run(config: DictConfig, out: Path) -> Path:
    """Export one model.

    Args:
        config: as composed from conf/export.yaml.
        out: folder of the files.

    Returns:
        The TorchScript file.

    Raises:
        InputError: no trained model there, or one that cannot be exported.
    """
    usable_device(config.torch_device)
    for key in ("refuse_outside", "program"):
        check_switch(key, config[key])
    saved = find_model("run", str(config.run))
    if "unit" not in saved.facts:
        raise InputError(
            f"run={saved.folder}: no metrics.json or refinement.json beside the model, which says the unit; give the whole output folder"
        )
    ranges = load_ranges(saved.folder)
    unknown = unknown_ranges(saved.module, ranges)
    if config.refuse_outside and (not ranges or unknown):
        lacking = f"{RANGES_FILE} there has no range of {', '.join(unknown)}" if ranges else f"no {RANGES_FILE} there"
        raise InputError(f"run={saved.folder}: {lacking}, so it is not known what refuse_outside=true should refuse; train the model again")
    with Console(stderr=True).status("exporting, and trying the files against the model"), threads_for(0):
        runs = _training_runs(saved)
        metadata = write_export(
            saved.module,
            saved.facts["unit"],
            ranges,
            {one.name: raw_columns(saved.module, one) for one in runs},
            out,
            about=_about(saved, runs),
            refuse_outside=config.refuse_outside,
            program=config.program,
        )
    _print(metadata)
    return out / SCRIPT


def _training_runs(saved: SavedModel) -> list[Run]:
    """The recordings of the training, if they are still where they were, seen from where the command was given."""
    path = command_config(saved.folder)
    if path is None:
        return []
    there = given_in(saved.folder)
    try:
        config = OmegaConf.load(path)
        with chdir(there) if there.is_dir() else nullcontext():
            runs, _ = read_data(config)  # type: ignore[arg-type]
    except (InputError, OSError, OmegaConfBaseException):
        return []
    return [one for one in runs if set(saved.module.inputs) <= {*one.columns, OUTPUT}]


def _about(saved: SavedModel, runs: Sequence[Run]) -> dict[str, Any]:
    """Where the model comes from; names of files, but no folder of this machine."""
    module, facts = saved.module, saved.facts
    features = next((part for part in module.modules() if isinstance(part, Features)), None)
    physics = module.physics if isinstance(module, Hybrid) else module
    last = (facts.get("ladder") or [{}])[-1]
    return {
        "schema_version": 1,
        "model": saved.kind,
        "settings": OmegaConf.to_container(OmegaConf.load(saved.folder / MODEL_FILE)),
        "formula": module.formula() or None,
        "features": features.definitions() if features else None,
        "effects": [name for name, _ in physics.named_effects()] if isinstance(physics, GrayBox) else [],
        "physical": physical_values(facts),
        "trained_on": {
            "runs": fitted_runs(facts),
            "sample_interval_s": _intervals(runs),
            "recorded_as": _recorded_as(runs),
            **{key: facts.get(key, last.get(key)) for key in TOLD},
            # Of many seeds, the one that is kept.
            "seed": (facts.get("members") or facts).get("best_seed", facts.get("seed")),
            "versions": facts.get("versions"),
        },
        "versions": versions(),
    }


def _intervals(runs: Sequence[Run]) -> list[float] | None:
    """Shortest and longest mean time between the rows of a run [s]; None where the recordings are gone."""
    # The fine grid's first and last time are those of the middles of the rows behind them.
    steps = [one.rows - float(one.count[0] + one.count[-1]) / 2 for one in runs]
    means = [float(one.time[-1] - one.time[0]) / many for one, many in zip(runs, steps, strict=True) if many > 0]
    return [min(means), max(means)] if means else None


def _recorded_as(runs: Sequence[Run]) -> dict[str, dict[str, str | None]] | None:
    """What the files of the training call each column and the output, and its unit there; None where the recordings are gone."""
    if not runs:
        return None
    return {one.name: {"column": one.column, "unit": symbol(one.given) if one.given else input_unit(one.name)} for one in runs[0].recorded}


def _print(metadata: dict[str, Any]) -> None:
    console = Console(markup=False, highlight=False)
    recorded = metadata["trained_on"]["recorded_as"] or {}
    for name in metadata["inputs"]:
        known, unit, was = metadata["trained_range"][name], metadata["input_units"][name] or "", recorded.get(name, {})
        trained = f"trained from {known[0]:g} to {known[1]:g} {unit}" if known else ""
        console.print(f"input       {name:24s} {trained}")
        if was and (was["column"], was["unit"] or "") != (name, unit) and name != OUTPUT:
            there = f", in {was['unit']}" if was["unit"] else ""
            console.print(f"            in the recordings {was['column']}{there}")
    for name, known in metadata["trained_range"].items():
        if known and name not in metadata["inputs"]:
            unit = "K/min" if name.endswith(RATE) else "°C"
            console.print(f"feature     {name:24s} trained from {known[0]:g} to {known[1]:g} {unit}")
    console.print(f"prediction  error in {metadata['unit_symbol']}, to be subtracted from the output")
    for what, apart in metadata["parity"]["largest_difference"].items():
        console.print(f"parity      {what}: {apart:.1e} {symbol(metadata['unit'])} at most")
