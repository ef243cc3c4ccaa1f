"""Tables as a stream of checked numbers: whatever the file, chunks of finite float64 columns whose first one increases strictly."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import ModuleType

import numpy as np

from zoo.errors import InputError
from zoo.measurements import csv_table, parquet_table
from zoo.measurements.files import suffix
from zoo.measurements.rows import Rows

CHUNK_BYTES = 4 << 20


def column_names(path: Path) -> tuple[str, ...]:
    """The names in a file's header.

    Raises:
        InputError: unknown kind of file, empty, not what its name says, or a name that occurs twice.
    """
    names = _kind(path).column_names(path)
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise InputError(f"{path}: the header has {', '.join(twice)} more than once; a column's name must be unique")
    return names


def _kind(path: Path) -> ModuleType:
    return parquet_table if suffix(path) == ".parquet" else csv_table


def chunks(
    path: Path, columns: Sequence[str], chunk_bytes: int = CHUNK_BYTES, *, skipped: Callable[[int], None] | None = None
) -> Iterator[np.ndarray]:
    """Reads some columns of a file in bounded memory.

    Args:
        path: .csv, .csv.gz or .parquet.
        columns: names from the header, the time first.
        chunk_bytes: about how much of the file to hold at a time.
        skipped: told how many rows were left out, as often as there are some, because a cell is empty or not finite or the time does not increase;
            None where such a row is an error.

    Returns:
        (M, C) float64, M rows in the file's order, chunk by chunk.

    Raises:
        InputError: no rows; a cell that is no finite number; a time that does not increase. Names the row, the column and what was found.
    """
    if skipped is None:
        return (part.numbers for part in rows(path, columns, chunk_bytes))
    return _usable(path, columns, chunk_bytes, skipped)


def _usable(path: Path, columns: Sequence[str], chunk_bytes: int, skipped: Callable[[int], None]) -> Iterator[np.ndarray]:
    """The rows of finite numbers that are later than every one before them."""
    some = False
    for part in rows(path, columns, chunk_bytes, skip=True):
        chunk = part.numbers[np.isfinite(part.numbers[:, 0])]
        if len(chunk) < len(part.numbers):
            skipped(len(part.numbers) - len(chunk))
        if len(chunk):
            some = True
            yield chunk
    if not some:
        raise InputError(f"{path}: has no row whose cells all hold a number; there is nothing to read")


def _spoilt(needed: np.ndarray, last: float) -> np.ndarray:
    """(M,) bool: which rows (M, C) lack a number, or are not later than every good one before them and than `last`."""
    complete = np.isfinite(needed).all(axis=1)
    time = np.where(complete, needed[:, 0], -np.inf)
    spoilt: np.ndarray = time <= np.maximum.accumulate(np.concatenate([[last], time]))[:-1]
    return spoilt


def rows(
    path: Path,
    columns: Sequence[str],
    chunk_bytes: int = CHUNK_BYTES,
    *,
    keep: bool = False,
    filled: int | None = None,
    skip: bool = False,
) -> Iterator[Rows]:
    """The same with the rows as they stand in the file.

    Args:
        path: .csv, .csv.gz or .parquet.
        columns: names from the header, the time first.
        chunk_bytes: about how much of the file to hold at a time.
        keep: whether the rows are asked for in full as well.
        filled: how many of the columns, from the first, need a finite number in every row; None for all.
        skip: whether rows without these numbers, or whose time does not increase, come with nothing but NaN; else they are an error.

    Raises:
        InputError: as in `chunks`.
    """
    kind = _kind(path)
    last, done = -np.inf, 0
    for part in kind.rows(path, columns, chunk_bytes, keep, filled):
        needed = part.numbers[:, :filled]
        bad = _spoilt(needed, last)
        if bad.any() and not skip:
            kind.explain(path, columns[:filled], needed, done, last)
        if not bad.all():
            last = float(needed[~bad, 0][-1])
        part.numbers[bad] = np.nan
        done += len(bad)
        yield part
    if done == 0:
        raise InputError(f"{path}: has a header and no rows; there is nothing to read")
