"""Parquet files, read batch by batch."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from zoo.errors import BadRow, InputError
from zoo.measurements.arrow import numbers
from zoo.measurements.rows import Rows


def column_names(path: Path) -> tuple[str, ...]:
    """The names in the file's schema, and that of a range by which pandas numbers the rows where it has one.

    Raises:
        InputError: the file is empty or no parquet.
    """
    with _opened(path) as file:
        return (*file.schema_arrow.names, *_numbering(file.schema_arrow))


def rows(path: Path, columns: Sequence[str], chunk_bytes: int, keep: bool = False, filled: int | None = None) -> Iterator[Rows]:
    """Some columns as float64, with the rows in full where they are to be kept; the arguments are those of `csv_table.rows`.

    Raises:
        InputError: a column that holds no numbers, or a damaged file.
    """
    del filled  # every cell is a number or missing
    with _opened(path) as file:
        numbering = {name: one for name, one in _numbering(file.schema_arrow).items() if name in columns}
        stored = [name for name in columns if name not in numbering]
        _check_types(path, file.schema_arrow, stored)
        wanted = list(file.schema_arrow.names if keep else stored)
        size, done = max(1, chunk_bytes // (8 * len(wanted))), 0
        try:
            for batch in file.iter_batches(batch_size=size, columns=wanted):
                place = np.arange(done, done + batch.num_rows)
                done += batch.num_rows
                if batch.num_rows:
                    ranges = {name: start + step * place.astype(np.float64) for name, (start, step) in numbering.items()}
                    parsed = np.column_stack([ranges[name] if name in ranges else numbers(batch.column(name)) for name in columns])
                    yield Rows(parsed, (batch,) if keep else (), done / file.metadata.num_rows)
        except (pa.ArrowException, OSError) as error:
            raise InputError(f"{path}: cannot be read to its end ({str(error).splitlines()[0]})") from error


def explain(path: Path, columns: Sequence[str], chunk: np.ndarray, before: int, last: float) -> NoReturn:
    """Says which cell of a chunk is wrong, by its place in the file.

    Args:
        path: the file.
        columns: the names of the chunk's columns, the time first.
        chunk: (M, C) the rows that hold the fault.
        before: rows before the chunk.
        last: the time before the chunk.

    Raises:
        BadRow: always.
    """
    bad = ~np.isfinite(chunk)
    late = ~(np.diff(chunk[:, 0], prepend=last) > 0)
    row = int(np.argmax(bad.any(axis=1) | late))
    where = f"{path}, row {before + row + 2} (the header counted as row 1)"
    if bad[row].any():
        place = int(np.argmax(bad[row]))
        found = "the cell is empty or NaN" if np.isnan(chunk[row, place]) else f"{chunk[row, place]}"
        raise BadRow(f"{where}, column {columns[place]}: {found}; a finite number is needed")
    previous = chunk[row - 1, 0] if row else last
    now = float(chunk[row, 0])
    raise BadRow(f"{where}, column {columns[0]}: {now!r} follows {float(previous)!r}; the time must increase from row to row")


def _numbering(schema: pa.Schema) -> dict[str, tuple[float, float]]:
    """Start and step of a named range that pandas numbers the rows by, which is no column: only the file's metadata tell it."""
    told = json.loads((schema.metadata or {}).get(b"pandas", b"{}")).get("index_columns", [])
    ranges = [one for one in told if isinstance(one, dict) and one.get("kind") == "range" and one.get("name")]
    return {one["name"]: (one["start"], one["step"]) for one in ranges if one["name"] not in schema.names}


def _opened(path: Path) -> pa.parquet.ParquetFile:
    try:
        if path.stat().st_size == 0:
            raise InputError(f"{path}: the file is empty (0 bytes)")
        # Buffered: a file written as one row group would otherwise be held whole.
        return pa.parquet.ParquetFile(path, buffer_size=1 << 20)
    except (pa.ArrowException, OSError) as error:
        raise InputError(f"{path}: is no readable parquet file ({str(error).splitlines()[0]})") from error


def _check_types(path: Path, schema: pa.Schema, columns: Sequence[str]) -> None:
    for column in columns:
        kind = schema.field(column).type
        if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
            raise InputError(f"{path}, column {column}: holds {kind}; numbers are needed")
