"""From files to runs: finds the columns, streams the rows, chooses the block length."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import torch

from zoo import units
from zoo.errors import BadRow, InputError
from zoo.given import is_number
from zoo.measurements.dead_readings import jumps
from zoo.measurements.files import find_files, run_names
from zoo.measurements.gaps import unsettled
from zoo.measurements.recording import GAP_STEPS, JITTER, Average, Recording, auto_length
from zoo.measurements.run import Run
from zoo.measurements.schema import Layout, Source, check_references, in_run_units, keep_shared, layout, overruled, without_temperature
from zoo.measurements.table import chunks, column_names
from zoo.measurements.wrong_unit import HOTTEST_C, mistaken_unit

BadRows = Literal["error", "skip"]
HEAD_ROWS = 100_000
_STARTUP_ROWS = 100
SLOW_S = 60.0
"""Hardly a chamber run has fewer rows than one a minute."""
LONGEST_S = 60 * 86400.0
"""What lasts longer was written down in milliseconds."""


def read_runs(
    files: Sequence[str | Path] | str | Path,
    columns: Mapping[str, str | None] | None = None,
    output_unit: str | None = None,
    reference: float | None = None,
    average_s: Average = "auto",
    gap_s: float | None = None,
    bad_rows: BadRows = "error",
    time_unit: str | None = None,
    temperature_unit: str | None = None,
) -> list[Run]:
    """Reads measurement files, one run a file, in memory that grows with the runs' duration and not with their rate.

    Args:
        files: paths and globs of .csv, .csv.gz and .parquet files.
        columns: role (time, temperature, temperature_NAME, output, reference, supply_v, field_ut, humidity_pct, pressure_kpa) -> the files'
            own name; roles left out have their default names. Any other role is a column more, for an effect that needs it by that name.
        output_unit: the output's unit, as suffix or as usually written; None where the column's name tells it.
        reference: true input [output's unit] of runs that do not record it; None for 0, where none of them does.
        average_s: length of the blocks [s]; None for as recorded; ``"auto"`` for the longest of 1, 2, 5, 10, 20, 50, 100 s of which all the
            runs together have 400. Pass the `average_s` of the runs fitted when reading the runs to check on.
        gap_s: longest time between rows that is no gap [s]; None for five median steps.
        bad_rows: what to do about rows with a cell that is empty or not finite, or a time that does not increase: ``"error"``, or ``"skip"`` for
            leaving them out, which the run's notes tell.
        time_unit: the time's unit, ``"ms"``, ``"us"``, ``"min"`` …; None where the column's name tells it, or it is seconds.
        temperature_unit: the thermometers' unit, ``"k"`` or ``"f"``, where their names do not tell it; None for °C.

    Returns:
        The runs in the files' order, with the same columns. The fine grid is a fifth of a block, or the rows themselves where it would hold
        fewer than two of them.

    Raises:
        InputError: anything the user can put right; names the file, row, column or key.
    """
    check_settings(reference, average_s, gap_s, bad_rows)
    paths = find_files(files)
    layouts = keep_shared([layout(path, column_names(path), columns, output_unit, time_unit, temperature_unit) for path in paths])
    check_references(layouts, reference)
    recordings = [_record(one, reference or 0.0, average_s, gap_s, bad_rows, time_unit is None) for one in layouts]
    length = auto_length(recordings) if average_s == "auto" else average_s
    return [_run(*each, length) for each in zip(run_names(paths), layouts, recordings, strict=True)]


def check_settings(reference: float | None, average_s: Average, gap_s: float | None, bad_rows: str) -> None:
    """Refuse what cannot be a true input, a length of blocks, the length of a gap, or a way with bad rows; the arguments are those of `read_runs`.

    Raises:
        InputError: one of them is none.
    """
    for key, value, words in (("average_s", average_s, ("auto",)), ("gap_s", gap_s, ())):
        if value is not None and value not in words and not (is_number(value) and float(value) > 0):
            raise InputError(f"data.{key}={value}: possible are {', '.join(('a positive number of seconds', *words))} and null")
    if reference is not None and not is_number(reference):
        raise InputError(f"data.reference={reference}: a number is needed, the true input in the output's unit, or null")
    if bad_rows not in get_args(BadRows):
        raise InputError(f"data.bad_rows={bad_rows}: possible are {', '.join(get_args(BadRows))}")


def _record(one: Layout, reference: float, average_s: Average, gap_s: float | None, bad_rows: BadRows, short: bool) -> Recording:
    """Streams one file; one that must be `short` is refused where its time is hardly in seconds."""
    skipped: list[int] = []
    stream = _chunks(one, skipped.append if bad_rows == "skip" else None)
    head = list(_at_least(HEAD_ROWS, stream))
    step = median_step(one.path, head)
    gap = GAP_STEPS * step if gap_s is None else gap_s
    if gap < step:
        raise InputError(f"{one.path}: data.gap_s={gap:g} is shorter than the time between rows, {step:g} s; every row would stand alone")
    recording = Recording(step, average_s, gap)
    startup = _startup(np.concatenate([chunk[:, -1] for chunk in head])[:_STARTUP_ROWS], one.output.column)
    recording.notes += [*one.notes, *overruled(one, reference), *(_slow(one, step) if short else []), *startup]
    lowest, highest = math.inf, -math.inf
    for chunk in itertools.chain(head, stream):
        lowest, highest = min(lowest, chunk[:, -1].min()), max(highest, chunk[:, -1].max())
        recording.push(_with_error(chunk, one, reference))
        if short:
            check_length(one, chunk[-1, 0] - head[0][0, 0])
    if lowest == highest:
        raise InputError(f"{one.path}, column {one.output.column}: is {lowest:g} in all {recording.rows} rows; a gyro's output varies")
    recording.close()
    if sum(skipped) > recording.rows:
        raise InputError(f"{one.path}: data.bad_rows=skip would leave out {sum(skipped)} of {sum(skipped) + recording.rows} rows; see to the file")
    if skipped:
        lacking = "row(s) without a number in every cell, or whose time does not increase, are left out"
        recording.notes.append(f"{one.path.name}: {sum(skipped)} {lacking}")
    return recording


def _chunks(one: Layout, skipped: Callable[[int], None] | None) -> Iterator[np.ndarray]:
    """The columns of a file in a run's units."""
    try:
        for chunk in chunks(one.path, [source.column for source in one.sources], skipped=skipped):
            warm = _warm_enough(one, in_run_units(chunk, one.sources), skipped)
            if len(warm):
                yield warm
    except BadRow as error:
        raise InputError(f"{error}; data.bad_rows=skip leaves such rows out") from error


def _warm_enough(one: Layout, chunk: np.ndarray, skipped: Callable[[int], None] | None) -> np.ndarray:
    """A chunk without rows below absolute zero, with which some recorders say that they have no temperature.

    Raises:
        BadRow: there is one, and nobody is to be told that it was skipped.
    """
    marked = without_temperature(chunk, one.sources)
    cold = marked.any(axis=1)
    if not cold.any():
        return chunk
    if skipped is None:
        row, place = chunk[cold.argmax()], int(marked[cold.argmax()].argmax())
        what = f"{one.path}, column {one.sources[place].column}"
        raise BadRow(f"{what}: {row[place]:g} °C at {row[0]:g} s is below absolute zero, as a mark for no value")
    skipped(int(cold.sum()))
    return chunk[~cold]


def _at_least(rows: int, stream: Iterable[np.ndarray]) -> Iterable[np.ndarray]:
    """The first chunks of a stream, enough for some rows; leaves the rest in it."""
    for chunk in stream:
        yield chunk
        rows -= len(chunk)
        if rows <= 0:
            return


def median_step(path: Path, head: Sequence[np.ndarray]) -> float:
    """Median time between the first rows [s]; a fixed number of them, so that it does not depend on the chunks' size.

    Args:
        path: the file, for the message.
        head: its first chunks, the time first.

    Raises:
        InputError: there is one row.
    """
    time = np.concatenate([chunk[:, 0] for chunk in head])[:HEAD_ROWS]
    if len(time) < 2:
        raise InputError(f"{path}: has one row; a run needs at least two")
    return float(np.median(np.diff(time)))


def _slow(one: Layout, step: float) -> list[str]:
    """A note where rows are far apart by a clock whose unit nobody has said."""
    time = one.inputs[0]
    if step <= SLOW_S or units.output_suffix(time.column, "time") is not None:
        return []
    return [f"{time.column} is taken as seconds, a row every {step:g} s; if it is another unit: data.time_unit=ms, us, min or h (s if it is true)"]


def _startup(output: np.ndarray, column: str) -> list[str]:
    """A note where the first row is far off the next ones: what a gyro says while it starts is no drift."""
    scatter = float(np.median(np.abs(np.diff(output[1:])))) if len(output) > 2 else 0.0
    jump = abs(float(output[0] - output[1]))
    if scatter == 0 or jump < 20 * scatter:
        return []
    return [f"{column} jumps after the first row by {jump / scatter:.0f} times its usual step, as after a start; the row is used"]


def _with_error(chunk: np.ndarray, one: Layout, reference: float) -> np.ndarray:
    """(M, C + 1): the run's table, reference last, and the error."""
    output = chunk[:, -1:]
    truth = chunk[:, -2:-1] if one.reference else np.full_like(output, reference)
    return np.concatenate([chunk[:, : len(one.inputs)], truth, output - truth], axis=1)


def _run(name: str, one: Layout, recording: Recording, length: float | None) -> Run:
    fine, block, thin = recording.grids(length)
    cut_short = int(block[-1] < 0)  # the last block, of which nobody asks where its other half is
    thermometers = [place for place, source in enumerate(one.inputs) if source.name.startswith("temperature_")]
    lost = unsettled(fine.segment, fine.mean[:, 0], fine.mean[:, thermometers])
    block, forgetting = _without(block, lost)
    average = recording.step_s if length is None or length < (1.0 - JITTER) * recording.step_s else float(length)
    if block.max() < 0:
        lasts = f"its {recording.rows} rows span {recording.span_s:g} s"
        raise InputError(f"{one.path}: no block of {average:g} s has half of its rows ({lasts}); choose a shorter data.average_s")
    table = torch.from_numpy(fine.mean)
    hot = [note for place, source in enumerate(one.inputs) for note in implausible(source, float(fine.mean[:, place].max()))]
    dead = [
        f"{name}: {note}" for place in thermometers for note in jumps(one.inputs[place].column, fine.mean[:, 0], fine.mean[:, place], fine.segment)
    ]
    doubt = mistaken_unit(one, fine.mean[:, -2], fine.mean[:, -1], fine.count)
    return Run(
        name=name,
        unit=one.unit,
        average_s=average,
        columns=(*(source.name for source in one.inputs), f"reference_{one.unit}"),
        table=table[:, :-1].contiguous(),
        error=table[:, -1].contiguous(),
        count=torch.from_numpy(fine.count),
        block=torch.from_numpy(block),
        rows=recording.rows,
        notes=(*recording.notes, *_notes(recording, average, length, thin - cut_short), *forgetting, *hot, *dead, *doubt),
        recorded=one.sources,
    )


def _without(block: np.ndarray, lost: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """(T,) blocks, numbered anew, without those of some samples, unless these were most of all; and a note on that."""
    gone = np.unique(block[lost & (block >= 0)])
    if not len(gone):
        return block, []
    unknown = "nobody knows how the temperature went in a gap"
    if 2 * len(gone) > block.max() + 1:
        return block, [f"{unknown}, and what remembers it may be wrong for an hour after each: {len(gone)} of {block.max() + 1} blocks"]
    kept = (block >= 0) & ~np.isin(block, gone)
    numbered = np.full_like(block, -1)
    numbered[kept] = np.unique(block[kept], return_inverse=True)[1]
    return numbered, [f"{len(gone)} block(s) are not judged: {unknown} in which it did not go straight on, and an hour after it that matters"]


def check_length(one: Layout, span_s: float) -> None:
    """Refuse a file whose time is hardly in the unit that it is taken for.

    Args:
        one: the file's columns.
        span_s: how long it lasts, so taken.

    Raises:
        InputError: longer than any run.
    """
    if span_s > LONGEST_S:
        time = one.inputs[0]
        named = f"column {time.column} is taken as {units.UNITS[time.given].symbol}, and the run would last {span_s / 86400.0:.0f} days or longer"
        instead = f"say data.time_unit=ms, us, min or h if it is another unit, and data.time_unit={time.given} if it is true"
        raise InputError(f"{one.path}: {named}; {instead}")


def implausible(source: Source, hottest: float) -> list[str]:
    """A sentence where a thermometer's highest value [°C] looks like another unit than the one that it is taken for."""
    if not source.name.startswith("temperature_") or source.given != source.wanted or hottest <= HOTTEST_C:
        return []
    otherwise = "from a name that ends in _k or _f, or with data.temperature_unit, it would be converted"
    return [f"{source.column} reaches {hottest:.0f}; it is taken as °C ({otherwise})"]


def _notes(recording: Recording, average: float, length: float | None, thin: int) -> list[str]:
    """What averaging noticed, one sentence each."""
    notes = []
    if recording.clock.gaps:
        notes.append(recording.clock.told())
    if thin:
        notes.append(f"{thin} block(s) of {average:g} s with less than half of their rows are not judged")
    if length is not None and length < average:
        notes.append(f"taken as recorded, every {average:g} s, as blocks of {length:g} s would be shorter")
    return notes
