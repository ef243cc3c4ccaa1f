"""Text with commas, semicolons or tabs between cells, plain or gzipped: a fast reader, and one that finds the line at fault when it stumbles."""

from __future__ import annotations

import csv
import gzip
import math
import re
import zlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
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

_MARKS, _LOOKED_AT = ",;\t", 200
"""What may stand between cells, and rows by which it is told how decimals are written."""


@dataclass(frozen=True)
class Style:
    """How a file writes its table.

    Attributes:
        mark: between the cells.
        point: of decimals.
    """

    mark: str = ","
    point: str = "."

    @classmethod
    def of(cls, path: Path) -> Style:
        """By the mark that divides the second row into most numbers, the header into most names; by what more numbers have, a comma or a point."""
        lines: list[str] = []
        with suppress(EOFError, zlib.error), _text(path) as file:  # a damaged file is told of by who reads on
            lines += islice(iter(lambda: file.readline(1 << 20), ""), _LOOKED_AT)
        mark = max(_MARKS, key=lambda mark: (sum(map(_is_number, _cells("".join(lines[1:2]), mark))), len(_cells("".join(lines[:1]), mark))))
        cells = [cell for line in lines[1:] for cell in _cells(line, mark)] if mark != "," else []
        commas, points = (sum(mark in cell and _is_number(cell) for cell in cells) for mark in ",.")
        return cls(mark, "," if commas > points else ".")

    def plain(self, cell: str) -> str:
        """A cell with its number as Python writes it."""
        return cell if self.point == "." else cell.replace(".", "?").replace(",", ".")


def _cells(line: str, mark: str) -> list[str]:
    """What stands between marks of one kind in a line; nothing where that is more than csv reads."""
    with suppress(csv.Error):
        return next(csv.reader([line], delimiter=mark), [])
    return []


def _is_number(cell: str) -> bool:
    """With a point or a comma."""
    return _NUMBER.fullmatch(cell.replace(",", ".", 1)) is not None


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
    names = tuple(name.strip() for name in _cells(line, Style.of(path).mark))
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
    names, style = column_names(path), Style.of(path)
    # By position: the header's own text may hold blanks, foreign letters or empty names.
    wanted = [str(names.index(column)) for column in columns]
    every = [str(place) for place in range(len(names))]
    convert = pa.csv.ConvertOptions(include_columns=wanted, column_types=dict.fromkeys(wanted, pa.float64()), decimal_point=style.point)
    as_text = pa.csv.ConvertOptions(include_columns=wanted, column_types=dict.fromkeys(wanted, pa.string()), strings_can_be_null=True)
    parse = pa.csv.ParseOptions(delimiter=style.mark)
    try:
        for block, share in _blocks(path, chunk_bytes):
            if not block.strip(b"\r\n"):
                continue
            options = pa.csv.ReadOptions(block_size=len(block) + 1, column_names=every)
            try:
                table = pa.csv.read_csv(pa.BufferReader(block), options, parse, convert)
            except pa.ArrowInvalid:
                table = _trimmed(pa.csv.read_csv(pa.BufferReader(block), options, parse, as_text), style)
            if table.num_rows:
                parsed = np.column_stack([numbers(column.chunk(0)) for column in table.combine_chunks().columns])
                yield Rows(parsed, (block,) if keep else (), share)
    except (pa.ArrowException, OSError, EOFError) as error:
        if _has_rows(path):
            _find_fault(path, columns, str(error), filled)


def _trimmed(table: pa.Table, style: Style) -> pa.Table:
    """Columns of text as numbers: Arrow's reader knows a missing cell only where no blanks stand around what says so."""
    for place, column in enumerate(table.columns):
        text = pc.utf8_trim_whitespace(column)
        text = pc.if_else(pc.is_in(text, pa.array(pa.csv.ConvertOptions().null_values)), None, text)
        text = text if style.point == "." else pc.replace_substring(pc.replace_substring(text, ".", "?"), style.point, ".")
        table = table.set_column(place, table.column_names[place], text.cast(pa.float64()))
    return table


def explain(path: Path, columns: Sequence[str], chunk: np.ndarray, before: int, last: float) -> NoReturn:
    """Says which cell of a chunk is wrong, by its line in the file.

    Raises:
        InputError: always.
    """
    del chunk, before, last  # found again from the text, where the lines are counted
    _find_fault(path, columns, "its numbers cannot be read")


def header(path: Path) -> tuple[bytes, bytes]:
    """The first line as it stands, and what ends it.

    Raises:
        InputError: the file is damaged.
    """
    try:
        with pa.OSFile(str(path)) as file, _unpacked(path, file) as stream:
            return _first_line(stream, 1 << 16)[:2]
    except OSError as error:
        raise InputError(f"{path}: cannot be read to its end ({error})") from error


def extended(lines: bytes, added: np.ndarray, path: Path, style: Style) -> pa.BinaryArray:
    """(M,) lines with more cells at their ends, an empty one for NaN; all other text as it was.

    Args:
        lines: text of M rows; blank lines between them are left out.
        added: (M, K).
        path: the file, for the message.
        style: how it writes its cells.

    Raises:
        InputError: a cell goes over several lines.
    """
    plain = lines.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in lines else lines
    every = pc.split_pattern(pa.scalar(plain, pa.large_binary()), b"\n").values
    kept = every.filter(pc.greater(pc.binary_length(every), 0))
    if len(kept) != len(added):
        raise InputError(f"{path}: {len(added)} rows stand in {len(kept)} lines; one line a row is needed, without line breaks inside quotes")
    cells = [pa.array(column, mask=~np.isfinite(column)).cast(pa.large_string()) for column in added.T]
    cells = [(pc.replace_substring(one, ".", style.point) if style.point != "." else one).cast(pa.large_binary()) for one in cells]
    mark = pa.scalar(style.mark.encode(), pa.large_binary())
    return pc.binary_join_element_wise(kept, *cells, mark, null_handling="replace", null_replacement=b"")


def _blocks(path: Path, chunk_bytes: int) -> Iterator[tuple[bytes, float]]:
    """Whole lines after the header, and how much of the file has been read."""
    size = max(path.stat().st_size, 1)
    with pa.OSFile(str(path)) as file, _unpacked(path, file) as stream:
        _, first, rest = _first_line(stream, chunk_bytes)
        end = first[-1:]  # whatever editors did to the header: what ends a line ends in this
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
        style = Style.of(path)
        with _text(path) as file:
            reader = csv.reader(file, delimiter=style.mark)
            names = [name.strip() for name in next(reader)]
            places = [(column, names.index(column)) for column in columns]
            last, row = -math.inf, 2
            for cells in reader:
                if cells:
                    asked = [*places[:filled], *_written(places[filled or len(places) :], cells)]
                    last = _check_line(f"{path}, row {row}", cells, len(names), asked, last, style)
                row = reader.line_num + 1
    except (OSError, EOFError, zlib.error, csv.Error) as error:
        raise InputError(f"{path}: cannot be read to its end ({error})") from error
    raise InputError(f"{path}: {otherwise.splitlines()[0]}")


def _written(places: list[tuple[str, int]], cells: list[str]) -> list[tuple[str, int]]:
    """Of columns whose cells may be missing, those where something else stands."""
    return [(column, place) for column, place in places if place >= len(cells) or cells[place].strip() not in _MISSING]


def _advice(where: str, cell: str, is_time: bool, style: Style) -> str:
    """What to do about a cell that holds no number, where that can be guessed."""
    if is_time and _DATE.match(cell):
        return "; seconds are needed, no dates (in pandas: (t - t.iloc[0]).dt.total_seconds())"
    if _is_number(cell):
        return f"; decimals are taken to have a {'comma' if style.point == ',' else 'point'}, as in most of the first {_LOOKED_AT} rows"
    return "; if this row holds units, delete it" if where.endswith(", row 2") and cell.strip()[:1].isalpha() else ""


def _check_line(where: str, cells: list[str], width: int, places: list[tuple[str, int]], last: float, style: Style) -> float:
    """One line's time, once all its cells are known to be good.

    Raises:
        InputError: it is not.
    """
    if len(cells) != width:
        raise InputError(f"{where}: has {len(cells)} cells, the header {width} (where commas stand between columns, decimals need a point)")
    for column, place in places:
        cell = cells[place]
        if not cell.strip():
            raise BadRow(f"{where}, column {column}: the cell is empty; every row needs a number here")
        if not _NUMBER.fullmatch(style.plain(cell)):
            kind = BadRow if cell.strip() in _MISSING else InputError
            raise kind(f"{where}, column {column}: {cell.strip()[:40]!r} is not a finite number{_advice(where, cell, place == places[0][1], style)}")
        if math.isinf(float(style.plain(cell))):
            raise BadRow(f"{where}, column {column}: {cell.strip()[:40]} is too large a number")
    time = float(style.plain(cells[places[0][1]]))
    if time <= last:
        raise BadRow(f"{where}, column {places[0][0]}: {time!r} follows {last!r}; the time must increase from row to row")
    return time
