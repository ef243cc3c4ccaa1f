"""Parquet files, read batch by batch."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from zoo.errors import InputError
from zoo.measurements.arrow import numbers


def column_names(path: Path) -> tuple[str, ...]:
    """The names in the file's schema.

    Raises:
        InputError: the file is empty or no parquet.
    """
    with _opened(path) as file:
        return tuple(file.schema_arrow.names)


def chunks(path: Path, columns: Sequence[str], chunk_bytes: int) -> Iterator[np.ndarray]:
    """(M, C) float64 chunks of some columns; missing cells are NaN.

    Raises:
        InputError: a column that holds no numbers, or a damaged file.
    """
    with _opened(path) as file:
        _check_types(path, file.schema_arrow, columns)
        rows = max(1, chunk_bytes // (8 * len(columns)))
        try:
            for batch in file.iter_batches(batch_size=rows, columns=list(columns)):
                if batch.num_rows:
                    yield np.column_stack([numbers(batch.column(column)) for column in columns])
        except (pa.ArrowException, OSError) as error:
            raise InputError(f"{path}: cannot be read to its end ({str(error).splitlines()[0]})") from error


def explain(path: Path, columns: Sequence[str], chunk: np.ndarray, rows: int, last: float) -> NoReturn:
    """Says which cell of a chunk is wrong, by its place in the file.

    Args:
        path: the file.
        columns: the names of the chunk's columns, the time first.
        chunk: (M, C) the rows that hold the fault.
        rows: rows before the chunk.
        last: the time before the chunk.

    Raises:
        InputError: always.
    """
    bad = ~np.isfinite(chunk)
    late = ~(np.diff(chunk[:, 0], prepend=last) > 0)
    row = int(np.argmax(bad.any(axis=1) | late))
    where = f"{path}, row {rows + row + 2} (the header counted as row 1)"
    if bad[row].any():
        place = int(np.argmax(bad[row]))
        found = "the cell is empty or NaN" if np.isnan(chunk[row, place]) else f"{chunk[row, place]}"
        raise InputError(f"{where}, column {columns[place]}: {found}; a finite number is needed")
    before = chunk[row - 1, 0] if row else last
    now = float(chunk[row, 0])
    raise InputError(f"{where}, column {columns[0]}: {now!r} follows {float(before)!r}; the time must increase from row to row")


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
