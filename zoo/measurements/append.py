"""A measurement file written again with more columns, everything else as it was, in bounded memory."""

from __future__ import annotations

import csv
import gzip
import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from functools import reduce
from operator import add
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from zoo.artifacts import replacing
from zoo.errors import InputError
from zoo.measurements import csv_table
from zoo.measurements.files import suffix
from zoo.measurements.rows import Rows
from zoo.measurements.schema import Source, in_run_units, without_temperature
from zoo.measurements.table import column_names, rows

Compute = Callable[[np.ndarray, float], np.ndarray]
CHUNK_BYTES = 8 << 20
LEVEL = 3
"""Of gzip: the digits of what was computed hardly shrink, however long one tries."""


def append_columns(
    source: Path,
    target: Path,
    columns: Sequence[Source],
    names: Sequence[str],
    compute: Compute,
    *,
    filled: int | None = None,
    skip: bool = False,
    first_s: float = 0.0,
    chunk_bytes: int = CHUNK_BYTES,
    check: Callable[[], None] = lambda: None,
) -> Path:
    """Copies a file and appends columns; in CSV the text of the others stays as it is, in Parquet their types.

    Args:
        source: .csv, .csv.gz or .parquet.
        target: of the same kind; written whole or not at all.
        columns: what is needed to compute them, the time first.
        names: of the new columns.
        compute: (M, C) the next rows of those columns in the run's units, NaN where a cell is missing, and the share of the file that has been
            read with them -> (M, K) new columns; NaN becomes an empty cell.
        filled: how many of `columns`, from the first, need a finite number in every row; None for all.
        skip: whether a row without these, or whose time does not increase, comes with nothing but NaN; else it is an error.
        first_s: time that the first chunk spans at least, where the file does [s].
        chunk_bytes: about how much of the file to hold at a time.
        check: called when all is computed; what it raises leaves the target as it was.

    Returns:
        The target.

    Raises:
        InputError: as in `zoo.measurements.table.rows`; a name that the file has already; the target is the source.
    """
    _check_new(source, target, names)
    stream = rows(source, [one.column for one in columns], chunk_bytes, keep=True, filled=filled, skip=skip)
    parts = ((part, compute(part.numbers, part.share)) for part in _long_enough(first_s, (_in_run_units(part, columns) for part in stream)))
    with replacing(target) as temporary:
        if suffix(source) == ".parquet":
            _write_parquet(source, temporary, names, parts)
        else:
            _write_csv(source, temporary, names, parts)
        check()
    return target


def _in_run_units(part: Rows, columns: Sequence[Source]) -> Rows:
    """The next rows in the run's units; marks for no temperature are NaN, as missing cells are."""
    numbers = in_run_units(part.numbers, columns)
    numbers[without_temperature(numbers, columns)] = np.nan
    return Rows(numbers, part.kept, part.share)


def _check_new(source: Path, target: Path, names: Sequence[str]) -> None:
    there = [name for name in names if name in column_names(source)]
    if there:
        raise InputError(f"{source}: has a column {there[0]} already")
    if target.resolve() == source.resolve():
        raise InputError(f"{source}: would be overwritten; choose another folder with hydra.run.dir=…")


def _long_enough(first_s: float, stream: Iterator[Rows]) -> Iterator[Rows]:
    """The stream, its first chunks in one."""
    begun: list[Rows] = []
    for part in stream:
        begun.append(part)
        time = np.concatenate([one.numbers[:, 0] for one in begun])
        if np.nanmax(time, initial=-np.inf) - np.nanmin(time, initial=np.inf) > first_s:
            break
    if begun:
        yield reduce(add, begun)
    yield from stream


def _write_csv(source: Path, path: Path, names: Sequence[str], parts: Iterator[tuple[Rows, np.ndarray]]) -> None:
    (line, end), style = csv_table.header(source), csv_table.Style.of(source)
    with path.open("wb") as raw, ExitStack() as stack:
        # Without a name and a time inside, equal data give equal files.
        binary = stack.enter_context(gzip.GzipFile("", "wb", LEVEL, raw, mtime=0)) if suffix(source) == ".csv.gz" else raw
        binary.write(line + style.mark.encode() + _header_cells(names, style.mark) + end)
        for part, added in parts:
            lines = csv_table.extended(b"".join(one for one in part.kept if isinstance(one, bytes)), added, source, style)
            binary.write(_joined(lines, end))


def _header_cells(names: Sequence[str], mark: str) -> bytes:
    text = io.StringIO()
    csv.writer(text, delimiter=mark, lineterminator="").writerow(names)
    return text.getvalue().encode()


def _joined(lines: pa.LargeBinaryArray, end: bytes) -> memoryview:
    """The text of lines, each with its end: the memory that Arrow holds them in."""
    ended = pa.compute.binary_join_element_wise(lines, pa.scalar(end, pa.large_binary()), pa.scalar(b"", pa.large_binary()))
    _, offsets, data = ended.buffers()
    return memoryview(data)[: np.frombuffer(offsets, np.int64)[len(ended)]]


def _write_parquet(source: Path, path: Path, names: Sequence[str], parts: Iterator[tuple[Rows, np.ndarray]]) -> None:
    with pa.parquet.ParquetFile(source) as file:
        schema = file.schema_arrow
        packed = file.metadata.row_group(0).column(0).compression if file.metadata.num_row_groups else "SNAPPY"
    for name in names:
        schema = schema.append(pa.field(name, pa.float64()))
    with pa.parquet.ParquetWriter(path, schema, compression="NONE" if packed == "UNCOMPRESSED" else packed) as writer:
        for part, added in parts:
            whole = pa.Table.from_batches([one for one in part.kept if isinstance(one, pa.RecordBatch)])
            for name, column in zip(names, added.T, strict=True):
                whole = whole.append_column(name, pa.array(column, mask=~np.isfinite(column)))
            writer.write_table(whole.cast(schema))
