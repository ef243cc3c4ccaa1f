"""Comma-separated text, plain or gzipped: a fast reader, and a slow one that finds the line at fault when the fast one stumbles."""

from __future__ import annotations

import csv
import gzip
import math
import re
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO, NoReturn

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv

from zoo.errors import BadRow, InputError
from zoo.measurements.arrow import numbers
from zoo.measurements.rows import Rows

_NUMBER = re.compile(r"[ \t]*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?[ \t]*")

_DATE = re.compile(r"\s*[0-9]+[-/.:][0-9]+[-/.:]")

_MISSING = {*pa.csv.ConvertOptions().null_values, "inf", "-inf"}

_BINARY = re.compile(r"[\0-\x08\x0e-\x1f]")


def column_names(path: Path) -> tuple[str, ...]:
    """The names in the first line.

    Raises:
        InputError: the file is empty, no text, or its first line is no header.
    """
    try:
        with _text(path) as file:
            line = file.readline(1 << 20)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: cannot be read ({error})") from error
    if not line:
        raise InputError(f"{path}: the file is empty; a header and one row a sample are needed")
    if _BINARY.search(line) or line.startswith("PAR1"):
        raise InputError(f"{path}: is no text in UTF-8 but a binary file; other formats need their own ending (.csv.gz, .parquet)")
    if not line.strip():
        raise InputError(f"{path}: row 1 is blank; the header must be the first line")
    names = tuple(name.strip() for name in next(csv.reader([line]), []))
    if len(names) < 2 and (found := next((mark for mark in ";\t" if mark in line), None)):
        raise InputError(f"{path}: columns are separated by {found!r}; commas are needed (and a point in decimals)")
    if all(_NUMBER.fullmatch(name) for name in names):
        raise InputError(f"{path}, row 1: holds numbers ({line.strip()[:60]}) where a header with the columns' names is needed")
    return names


def rows(path: Path, columns: Sequence[str], chunk_bytes: int, keep: bool = False, filled: int | None = None) -> Iterator[Rows]:
    """Some columns as float64, with their lines where they are to be kept.

    Args:
        path: the file.
        columns: names from the header, the time first.
        chunk_bytes: about how much text to hold at a time.
        keep: whether the lines are asked for as well.
        filled: how many of the columns need a number in every row; None for all.

    Raises:
        InputError: a line that cannot be read as numbers.
    """
    names = column_names(path)
    # By position: the header's own text may hold blanks, foreign letters or empty names.
    wanted = [str(names.index(column)) for column in columns]
    every = [str(place) for place in range(len(names))]
    convert = pa.csv.ConvertOptions(include_columns=wanted, column_types=dict.fromkeys(wanted, pa.float64()))
    try:
        for block, share in _blocks(path, chunk_bytes):
            if not block.strip(b"\r\n"):
                continue
            options = pa.csv.ReadOptions(block_size=len(block) + 1, column_names=every)
            table = pa.csv.read_csv(pa.BufferReader(block), options, convert_options=convert).combine_chunks()
            if table.num_rows:
                parsed = np.column_stack([numbers(column.chunk(0)) for column in table.columns])
                yield Rows(parsed, (block,) if keep else (), share)
    except (pa.ArrowException, OSError, EOFError) as error:
        if _has_rows(path):
            _find_fault(path, columns, str(error), filled)


def explain(path: Path, columns: Sequence[str], chunk: np.ndarray, before: int, last: float) -> NoReturn:
    """Says which cell of a chunk is wrong, by its line in the file.

    Raises:
        InputError: always.
    """
    del chunk, before, last  # found again from the text, where the lines are counted
    _find_fault(path, columns, "its numbers cannot be read")


def header(path: Path) -> tuple[bytes, bytes]:
    """The first line as it stands, and what ends it."""
    with pa.OSFile(str(path)) as file, _unpacked(path, file) as stream:
        return _first_line(stream, 1 << 16)[:2]


def extended(lines: bytes, added: np.ndarray, path: Path) -> pa.BinaryArray:
    """(M,) lines with more cells at their ends, an empty one for NaN; all other text as it was.

    Args:
        lines: text of M rows; blank lines between them are left out.
        added: (M, K).
        path: the file, for the message.

    Raises:
        InputError: a cell goes over several lines.
    """
    plain = lines.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in lines else lines
    every = pc.split_pattern(pa.scalar(plain, pa.large_binary()), b"\n").values
    kept = every.filter(pc.greater(pc.binary_length(every), 0))
    if len(kept) != len(added):
        raise InputError(f"{path}: {len(added)} rows stand in {len(kept)} lines; one line a row is needed, without line breaks inside quotes")
    cells = [pa.array(column, mask=~np.isfinite(column)).cast(pa.large_string()).cast(pa.large_binary()) for column in added.T]
    return pc.binary_join_element_wise(kept, *cells, pa.scalar(b",", pa.large_binary()), null_handling="replace", null_replacement=b"")


def _blocks(path: Path, chunk_bytes: int) -> Iterator[tuple[bytes, float]]:
    """Whole lines after the header, and how much of the file has been read."""
    size = max(path.stat().st_size, 1)
    with pa.OSFile(str(path)) as file, _unpacked(path, file) as stream:
        _, end, rest = _first_line(stream, chunk_bytes)
        while data := stream.read(chunk_bytes):
            rest += data
            cut = rest.rfind(end) + len(end)
            if cut >= len(end):
                yield rest[:cut], min(file.tell() / size, 1.0)
                rest = rest[cut:]
        yield rest, 1.0


def _first_line(stream: pa.NativeFile, chunk_bytes: int) -> tuple[bytes, bytes, bytes]:
    """The first line, what ends it, and what has been read beyond."""
    text = b""
    while data := stream.read(chunk_bytes):
        text += data
        found = re.search(rb"\r\n|\n|\r(?=.)", text, re.DOTALL)
        if found:
            return text[: found.start()], found[0], text[found.end() :]
    return text.rstrip(b"\r"), b"\n", b""


def _unpacked(path: Path, file: pa.NativeFile) -> pa.NativeFile:
    return pa.CompressedInputStream(file, "gzip") if path.name.lower().endswith(".gz") else file


def _text(path: Path) -> IO[str]:
    # Bytes that are no UTF-8 may stand in columns that nobody asked for: they are kept, not refused.
    if path.name.lower().endswith(".gz"):
        return gzip.open(path, "rt", encoding="utf-8-sig", errors="replace", newline="")
    return path.open(encoding="utf-8-sig", errors="replace", newline="")


def _has_rows(path: Path) -> bool:
    """Whether anything follows the header; Arrow calls a header without a newline an error."""
    try:
        with _text(path) as file:
            file.readline()
            return any(line.strip() for line in file)
    except (OSError, EOFError, zlib.error):
        return True


def _find_fault(path: Path, columns: Sequence[str], otherwise: str, filled: int | None = None) -> NoReturn:
    """Walks through the text until the first line that cannot be used.

    Raises:
        InputError: always; `otherwise` is what it says where the walk finds nothing.
    """
    try:
        with _text(path) as file:
            reader = csv.reader(file)
            names = [name.strip() for name in next(reader)]
            places = [(column, names.index(column)) for column in columns]
            last, row = -math.inf, 2
            for cells in reader:
                if cells:
                    last = _check_line(
                        f"{path}, row {row}", cells, len(names), [*places[:filled], *_written(places[filled or len(places) :], cells)], last
                    )
                row = reader.line_num + 1
    except (OSError, EOFError, zlib.error, csv.Error) as error:
        raise InputError(f"{path}: cannot be read to its end ({error})") from error
    raise InputError(f"{path}: {otherwise.splitlines()[0]}")


def _written(places: list[tuple[str, int]], cells: list[str]) -> list[tuple[str, int]]:
    """Of columns whose cells may be missing, those where something else stands."""
    return [(column, place) for column, place in places if place >= len(cells) or cells[place].strip() not in _MISSING]


def _check_line(where: str, cells: list[str], width: int, places: list[tuple[str, int]], last: float) -> float:
    """One line's time, once all its cells are known to be good.

    Raises:
        InputError: it is not.
    """
    if len(cells) != width:
        raise InputError(f"{where}: has {len(cells)} cells, the header {width} (decimals need a point, columns a comma)")
    for column, place in places:
        cell = cells[place]
        if not cell.strip():
            raise BadRow(f"{where}, column {column}: the cell is empty; every row needs a number here")
        if not _NUMBER.fullmatch(cell):
            kind = BadRow if cell.strip() in _MISSING else InputError
            a_date = "; seconds are needed, no dates" if place == places[0][1] and _DATE.match(cell) else ""
            raise kind(f"{where}, column {column}: {cell.strip()[:40]!r} is not a finite number{a_date}")
        if math.isinf(float(cell)):
            raise BadRow(f"{where}, column {column}: {cell.strip()[:40]} is too large a number")
    time = float(cells[places[0][1]])
    if time <= last:
        raise BadRow(f"{where}, column {places[0][0]}: {time!r} follows {last!r}; the time must increase from row to row")
    return time
