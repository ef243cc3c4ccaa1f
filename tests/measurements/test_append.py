"""A file with more columns is the file, and nothing else in it changes."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet
import pytest

from zoo.errors import InputError
from zoo.measurements.append import append_columns
from zoo.measurements.schema import Source

COLUMNS = (Source("time_s", "t_ms", "ms", "s"), Source("temperature_c", "temp", "c", "c"))
TEXT = "t_ms,note,temp\n1000,first,+20.50\n2000,  ,021\n\n3000,ü,\n4000,last,NaN\n5000,e,2.05e1"


def doubled(numbers: np.ndarray, share: float) -> np.ndarray:
    """Time [s] and twice the temperature."""
    assert 0 < share <= 1
    return np.stack([numbers[:, 0], 2 * numbers[:, 1]], axis=1)


def written(source: Path, target: Path, **keywords: object) -> Path:
    return append_columns(source, target, COLUMNS, ["seconds", "twice"], doubled, filled=1, **keywords)  # type: ignore[arg-type]


def test_what_is_added_is_written_as_the_file_writes_it(tmp_path) -> None:
    """Semicolons and decimal commas, which spreadsheets of half of the world write."""
    source, target = tmp_path / "a.csv", tmp_path / "out" / "a.csv"
    source.write_text("t_ms;note, if any;temp\n1000;first;20,5\n2000;;21\n3000;1.5 V;\n")
    written(source, target)
    assert target.read_text() == "t_ms;note, if any;temp;seconds;twice\n1000;first;20,5;1;41\n2000;;21;2;42\n3000;1.5 V;;3;\n"
    frame = pd.read_csv(target, sep=";", decimal=",")
    assert frame["twice"].iloc[:2].tolist() == [41.0, 42.0]


@pytest.mark.parametrize("chunk_bytes", [7, 1 << 20])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("kind", ["csv", "csv.gz"])
def test_text_stays_as_it_is(tmp_path, kind, end, chunk_bytes) -> None:
    opened = gzip.open if kind == "csv.gz" else open
    source, target = tmp_path / f"a.{kind}", tmp_path / "out" / f"a.{kind}"
    with opened(source, "wb") as file:
        file.write(b"\xef\xbb\xbf" + TEXT.replace("\n", end).encode())
    written(source, target, chunk_bytes=chunk_bytes)
    with opened(target, "rb") as file:
        lines = file.read().decode("utf-8-sig").split(end)
    old = [line for line in TEXT.split("\n") if line]
    added = ["seconds,twice", "1.0,41.0", "2.0,42.0", "3.0,", "4.0,", "5.0,41.0"]
    expected = [f"{line},{cells}" for line, cells in zip(old, added, strict=True)]
    assert [line.replace(".0,", ",").removesuffix(".0") for line in lines[:-1]] == [line.replace(".0,", ",").removesuffix(".0") for line in expected]
    assert lines[-1] == ""


def test_numbers_read_back_exactly_whatever_the_chunks(tmp_path) -> None:
    chance = np.random.default_rng(1)
    frame = pd.DataFrame({"t_ms": np.arange(5000.0), "temp": np.abs(chance.normal(size=5000)) * 10.0 ** chance.integers(-12, 12, 5000)})
    frame.to_csv(tmp_path / "a.csv", index=False)
    made = [written(tmp_path / "a.csv", tmp_path / f"{size}.csv", chunk_bytes=size) for size in (1 << 9, 1 << 14, 1 << 24)]
    assert len({path.read_bytes() for path in made}) == 1
    back = pd.read_csv(made[0], engine="pyarrow")
    assert np.array_equal(back["twice"], 2 * frame["temp"])
    assert made[0].read_text().splitlines()[1].startswith((tmp_path / "a.csv").read_text().splitlines()[1] + ",")


def test_parquet_keeps_types_missing_cells_and_packing(tmp_path) -> None:
    table = pa.table(
        {
            "t_ms": pa.array([1000, 2000, 3000], pa.int32()),
            "temp": pa.array([20.5, None, 21.0], pa.float32()),
            "note": pa.array(["a", None, "c"]).dictionary_encode(),
        },
        metadata={"lab": "ours"},
    )
    pa.parquet.write_table(table, tmp_path / "a.parquet", compression="zstd")
    found = pa.parquet.ParquetFile(written(tmp_path / "a.parquet", tmp_path / "b.parquet", chunk_bytes=32))
    assert found.metadata.row_group(0).column(0).compression == "ZSTD"
    whole = found.read()
    assert whole.select(["t_ms", "temp", "note"]).equals(table)
    assert whole.schema.metadata[b"lab"] == b"ours"
    assert whole["twice"].to_pylist() == [41.0, None, 42.0]


def test_the_first_chunk_is_as_long_as_asked(tmp_path) -> None:
    frame = pd.DataFrame({"t_ms": 1000.0 * np.arange(200), "temp": 20.0})
    frame.to_csv(tmp_path / "a.csv", index=False)
    sizes: list[int] = []

    def noting(numbers: np.ndarray, share: float) -> np.ndarray:
        sizes.append(len(numbers))
        return doubled(numbers, share)

    append_columns(tmp_path / "a.csv", tmp_path / "b.csv", COLUMNS, ["x", "y"], noting, first_s=60.0, chunk_bytes=100)
    assert sizes[0] > 60
    assert max(sizes[1:]) < 20
    assert sum(sizes) == 200


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("t_ms,temp\n1,20\n3,20\n2,20\n", r"row 4, column t_ms: 2\.0 follows 3\.0"),
        ("t_ms,temp\n1,20\n,20\n", "row 3, column t_ms: the cell is empty"),
        ("t_ms,temp\n1,\n2,warm\n", "row 3, column temp: 'warm' is not"),
        ("t_ms,temp\n1,20\n2\n", "row 3: has 1 cells, the header 2"),
        ('t_ms,temp,note\n1,20,"a\nb"\n', "rows stand in|CSV parse error"),
        ("t_ms,temp\n", "no rows"),
        ("t_ms,temp,twice\n1,2,3\n", "has a column twice already"),
    ],
)
def test_a_wrong_file_leaves_nothing(tmp_path, text, found) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError, match=found):
        written(tmp_path / "a.csv", tmp_path / "b.csv", chunk_bytes=8)
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]
