"""A model subtracted from one recording of any length: the file again, with what was predicted and what is left."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch

from zoo import units
from zoo.errors import InputError, WorkError
from zoo.measurements.append import append_columns
from zoo.measurements.read import check_length, implausible, median_step
from zoo.measurements.recording import GAP_STEPS, Average, Recording, auto_length, block_means
from zoo.measurements.run import OUTPUT
from zoo.measurements.schema import Layout, Source, overruled
from zoo.measurements.wrong_unit import mistaken_unit
from zoo.models.base import Model
from zoo.models.places import FIRST_S
from zoo.models.ranges import TIME, Ranges, Watched, outside
from zoo.models.streaming import Stream, check_streams

TRIED_ROWS = 3000
"""Rows of a file's beginning on which the prediction in pieces is compared with that of the whole."""
PREDICTED, LEFT = "predicted_error_", "_compensated"
"""How the new columns' names begin and end."""


@dataclass(frozen=True, eq=False)
class Compensator:
    """A model with what has to be known to apply it.

    Attributes:
        model: trained, where it shall be computed.
        unit: suffix of its error's unit; None where that was not saved, and files are taken to be in it.
        ranges: within which it was fitted.
        used: the raw columns that its prediction depends on.
    """

    model: Model
    unit: str | None
    ranges: Ranges
    used: list[str]

    @property
    def device(self) -> torch.device:
        """Where the model is."""
        return next((one.device for one in [*self.model.parameters(), *self.model.buffers()]), torch.device("cpu"))


@dataclass(eq=False)
class Tally:
    """What one pass through a file counts.

    Attributes:
        rows: of the file.
        unpredicted: rows without a prediction, as a column that it needs has no number there.
        first_unpredicted: the first of them, the header counted as row 1, and the column that it lacks; empty where there is none.
        outside: by column, rate or lag, rows outside of what was fitted, and the lowest and highest value there.
        notes: one sentence each.
        average_s: length of the blocks [s].
        blocks: (N, 4) means of time [s], error, predicted error and true input [output's unit].
    """

    rows: int = 0
    unpredicted: int = 0
    first_unpredicted: str = ""
    outside: dict[str, tuple[int, float, float]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    average_s: float = 0.0
    blocks: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))


def columns_needed(compensator: Compensator, one: Layout) -> tuple[Source, ...]:
    """What has to be read of a file: the time, what the model uses, the true input where it is recorded, and last the output.

    Raises:
        InputError: a column is missing, the output's unit is of another quantity, or the file is compensated already.
    """
    known = {source.name: source for source in one.inputs}
    takes = [name for name in compensator.used if name != OUTPUT and not name.startswith("reference_")]
    missing = [name for name in takes if name not in known]
    if missing:
        kind = type(compensator.model).__name__
        raise InputError(f"{one.path}: the model {kind} needs the column {', '.join(missing)}; the file has {', '.join(known)}")
    if compensator.unit is not None:
        _check_unit(one, compensator.unit)
    return (known["time_s"], *(known[name] for name in takes), *([one.reference] if one.reference else []), one.output)


def check_uncompensated(path: Path, present: tuple[str, ...]) -> None:
    """Refuse a file to which a model was applied before: subtracted twice, it would be put back in with the opposite sign.

    Raises:
        InputError: names the column that tells.
    """
    told = [name for name in present if is_compensated([name])]
    if told:
        raise InputError(f"{path}: is compensated already, it has the column {told[0]}; give the file as it was recorded")


def is_compensated(present: Sequence[str]) -> bool:
    """Whether a file of these columns had a model subtracted."""
    return any(name.startswith(PREDICTED) or name.endswith(LEFT) for name in present)


def _check_unit(one: Layout, unit: str) -> None:
    try:
        units.convert(0.0, unit, one.unit)
    except InputError as error:
        raise InputError(f"{one.path}: the model was trained on errors in {units.symbol(unit)}; {error}") from None


class Compensation:
    """One file on its way through a model."""

    def __init__(
        self, compensator: Compensator, one: Layout, reference: float, average_s: Average, gap_s: float | None, skip: bool = False, short: bool = True
    ) -> None:
        """Prepare.

        Args:
            compensator: the model.
            one: the file's columns.
            reference: true input where it is not recorded [output's unit].
            average_s: length of the blocks by which the result is judged [s].
            gap_s: longest time between rows that is no gap [s]; None for five median steps.
            skip: whether rows whose time is missing or does not increase get empty cells; else they are an error.
            short: whether a file that would last longer than any run is refused, as its time is hardly in the unit that it is taken for.

        Raises:
            InputError: see `columns_needed`.
        """
        self.tally = Tally(notes=overruled(one, reference))
        self._with, self._one = compensator, one
        self._sources = columns_needed(compensator, one)
        self._reference, self._average_s, self._gap_s, self._skip = reference, average_s, gap_s, skip
        self._short, self._begin, self._hottest = short, math.inf, [-math.inf] * len(self._sources)
        self._stream, self._watched = Stream(compensator.model), Watched(compensator.model)
        self._told = self._watched.of((*compensator.used, TIME))
        self._watch = Stream(self._watched)
        self._recording: Recording | None = None

    def write(self, target: Path, progress: Callable[[float], None]) -> Tally:
        """Write the file again, whole or not at all.

        Args:
            target: of the same kind.
            progress: told the share that is done.

        Raises:
            InputError: a cell or a row of the file is wrong, or no row can be predicted.
            WorkError: the model cannot go on from chunk to chunk, or predicts what is no number.
        """

        def compute(numbers: np.ndarray, share: float) -> np.ndarray:
            added = self._added(numbers)
            progress(share)
            return added

        names = (f"{PREDICTED}{self._one.unit}", f"{self._one.output.column}{LEFT}")
        append_columns(self._one.path, target, self._sources, names, compute, filled=1, skip=self._skip, first_s=FIRST_S, check=self._check_predicted)
        self.tally.notes += [note for one, hottest in zip(self._sources, self._hottest, strict=True) for note in implausible(one, hottest)]
        self._close()
        return self.tally

    def _check_predicted(self) -> None:
        if self.tally.unpredicted == self.tally.rows:
            raise InputError(f"{self._one.path}: {', '.join(self._with.used)}: no row has a number in each; there is nothing to predict from")

    def _added(self, numbers: np.ndarray) -> np.ndarray:
        """(M, C) rows -> (M, 2) prediction and what is left [output's unit]."""
        self._doubt(numbers)
        table, truth, output = self._raw(numbers)
        used = [place for place, name in enumerate(self._with.model.inputs) if name in self._with.used]
        finite = np.isfinite(table[:, [0, *used]])  # the time always: models that ask for no column may go by it
        known = finite.all(axis=1)
        if not (known.all() or self.tally.first_unpredicted):
            row = int(known.argmin())
            self.tally.first_unpredicted = f"row {self.tally.rows + row + 2}, {self._name([0, *used][int(finite[row].argmin())])}"
        self.tally.rows += len(known)
        self.tally.unpredicted += int((~known).sum())
        x = torch.from_numpy(np.nan_to_num(table[known], posinf=0.0, neginf=0.0)).to(self._with.device)
        predicted = np.full(len(known), np.nan)
        predicted[known] = self._predicted(x)
        self._count_outside(x)
        self._push(numbers, output - truth, predicted, truth)
        return np.stack([predicted, output - predicted], axis=1)

    def _doubt(self, numbers: np.ndarray) -> None:
        """Looks whether the file is in other units than it is taken for."""
        lowest, highest = (extreme(np.where(np.isfinite(numbers), numbers, end), axis=0) for extreme, end in ((np.min, np.inf), (np.max, -np.inf)))
        self._begin = min(self._begin, lowest[0])
        if self._short:
            check_length(self._one, highest[0] - self._begin)
        self._hottest = [max(pair) for pair in zip(self._hottest, highest.tolist(), strict=True)]

    def _raw(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(M, C) the model's raw columns, 0 where it does not use them, and (M,) true input and output [output's unit]."""
        output = numbers[:, -1]
        truth = numbers[:, -2] if self._one.reference else np.full_like(output, self._reference)
        by_name = {source.name: numbers[:, place] for place, source in enumerate(self._sources)}
        for name in self._with.model.inputs:
            if name.startswith("reference_"):
                by_name[name] = units.convert(truth, self._one.unit, name.removeprefix("reference_"))
            elif name == OUTPUT:
                by_name[name] = units.convert(output, self._one.unit, self._with.unit or self._one.unit)
        nothing = np.zeros_like(output)
        return np.stack([by_name.get(name, nothing) for name in self._with.model.inputs], axis=1), truth, output

    def _name(self, place: int) -> str:
        """What the file calls one of the model's raw columns; the true input may be there in another unit."""
        name, truth = self._with.model.inputs[place], "reference_"
        return next(one.column for one in self._sources if one.name == name or (name.startswith(truth) and one.name.startswith(truth)))

    def _predicted(self, x: torch.Tensor) -> np.ndarray:
        if self._recording is None and len(x) > 1:
            check_streams(self._with.model, x[:TRIED_ROWS])
        predicted = units.convert(self._stream(x), self._with.unit or self._one.unit, self._one.unit).cpu().numpy()
        if not np.isfinite(predicted).all():
            raise WorkError(f"{self._one.path}: the model {type(self._with.model).__name__} predicts values that are no numbers")
        return predicted

    def _count_outside(self, x: torch.Tensor) -> None:
        if not len(x):
            return
        table, names = self._watch(x), self._watched.names
        beyond = outside(table, names, self._with.ranges)
        for place, name in enumerate(names):
            values = table[beyond[:, place], place]
            if name in self._told and len(values):
                count, low, high = self.tally.outside.get(name, (0, np.inf, -np.inf))
                self.tally.outside[name] = count + len(values), min(low, float(values.min())), max(high, float(values.max()))

    def _push(self, numbers: np.ndarray, error: np.ndarray, predicted: np.ndarray, truth: np.ndarray) -> None:
        """Takes rows for the means by which the result is judged."""
        if self._recording is None:
            timed = numbers[np.isfinite(numbers[:, 0])]
            step = median_step(self._one.path, [timed]) if len(timed) > 1 else 1.0  # a row alone is a block, whatever its length
            self._recording = Recording(step, self._average_s, GAP_STEPS * step if self._gap_s is None else max(self._gap_s, step))
        rows = np.stack([numbers[:, 0], error, predicted, truth], axis=1)
        rows = rows[np.isfinite(rows).all(axis=1)]
        if len(rows):
            self._recording.push(rows)

    def _close(self) -> None:
        assert self._recording is not None
        tally, recording = self.tally, self._recording
        if not recording.rows:
            return
        recording.close()
        length = auto_length([recording]) if self._average_s == "auto" else self._average_s
        tally.blocks = block_means(recording, length)
        tally.average_s = recording.step_s if length is None else max(float(length), recording.step_s)
        tally.notes += mistaken_unit(self._one, tally.blocks[:, 3], tally.blocks[:, 1])
        if recording.clock.gaps:
            tally.notes.append(f"{recording.clock.told()}; what the model remembers goes on along a straight line")


def remarks(one: Layout, tally: Tally, ranges: Ranges) -> list[str]:
    """What a user should know of one file, a line each."""
    found = [*one.notes, *tally.notes]
    if tally.unpredicted:
        lacking = f"lack a number in a column that the model needs, or a time that increases (the first: {tally.first_unpredicted})"
        found.append(f"{tally.unpredicted} of {tally.rows} rows {lacking}; their new cells are empty")
    for name, (count, low, high) in tally.outside.items():
        fitted = " … ".join(f"{value:.4g}" for value in ranges[name])
        found.append(f"{name} is outside of what was fitted ({fitted}) in {count} of {tally.rows} rows: {low:.4g} … {high:.4g}")
    return found
