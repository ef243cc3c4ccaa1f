"""Every bad file gets a message of one or two lines that says where and what, and no traceback."""

from __future__ import annotations

import gzip
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from zoo.errors import InputError
from zoo.measurements.read import read_runs
from zoo.measurements.table import chunks

HEADER = "time_s,temperature_c,rate_dph"
DEEP = 320_000  # rows: several chunks of the csv reader


def lines(rows: int = 20) -> list[str]:
    return [HEADER, *(f"{row}.5,{20 + row % 7},{row % 3 - 1.25}" for row in range(rows))]


def complaint(path: Path | list[Path], **given: object) -> str:
    with pytest.raises(InputError) as caught:
        read_runs(path, **given)  # type: ignore[arg-type]
    message = str(caught.value)
    assert 1 <= len(message.splitlines()) <= 2
    return message


def bad_csv(path: Path, text: str | bytes, gz: bool = False) -> Path:
    data = text if isinstance(text, bytes) else text.encode()
    path.write_bytes(gzip.compress(data) if gz else data)
    return path


@pytest.mark.parametrize(
    ("cell", "found"),
    [
        ("abc", "'abc' is not a finite number"),
        ("1_0", "'1_0' is not"),
        ("#REF!", "'#REF!'"),
        ("nan", "'nan'"),
        ("NA", "'NA'"),
        ("inf", "'inf'"),
        ("-Infinity", "'-Infinity'"),
        ("", "the cell is empty"),
        ("  ", "the cell is empty"),
        ("1e999", "1e999 is too large"),
        ("0x1F", "'0x1F'"),
        ("12:30:01", "'12:30:01'"),
    ],
)
def test_a_cell_that_is_no_number(tmp_path: Path, cell: str, found: str) -> None:
    text = lines()
    text[7] = f"6.5,{cell},1.0"
    assert complaint(bad_csv(tmp_path / "a.csv", "\n".join(text))).startswith(f"{tmp_path / 'a.csv'}, row 8, column temperature_c: {found}")


@pytest.mark.parametrize("gz", [False, True])
@pytest.mark.parametrize("cell", ["oops", "", "inf"])
def test_a_bad_cell_deep_in_a_file_is_found(tmp_path: Path, cell: str, gz: bool) -> None:
    text = lines(DEEP)
    text[DEEP - 10] = f"{DEEP - 11}.5,20,{cell}"
    path = bad_csv(tmp_path / ("a.csv.gz" if gz else "a.csv"), "\n".join(text), gz)
    assert f"row {DEEP - 9}, column rate_dph: " in complaint(path)


def test_lines_are_counted_as_an_editor_counts_them(tmp_path: Path) -> None:
    text = lines()
    text[5:6] = ["", "", "4.5,20,x"]
    assert "row 8, column rate_dph: 'x'" in complaint(bad_csv(tmp_path / "a.csv", "\r\n".join(text)))


def test_a_stray_quote_is_named_where_it_opens(tmp_path: Path) -> None:
    text = lines()
    text[7] = '6.5,"20,1.0'
    assert "row 8: has 2 cells, the header 3" in complaint(bad_csv(tmp_path / "a.csv", "\n".join(text)))
    text[9] = '8.5,20",1.0'
    message = complaint(bad_csv(tmp_path / "a.csv", "\n".join(text)))
    assert r"row 8, column temperature_c: '20,1.0\n7.5," in message


def test_a_bad_cell_in_a_column_that_is_not_used_does_no_harm(tmp_path: Path) -> None:
    text = [f"{line},{'operator' if place == 0 else 'Müller'}" for place, line in enumerate(lines())]
    assert read_runs(bad_csv(tmp_path / "a.csv", "\n".join(text).encode("latin-1")), average_s=None)[0].rows == 20


@pytest.mark.parametrize(("now", "last"), [("3.5", "4.5"), ("4.5", "4.5")])
@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_a_time_that_does_not_increase(tmp_path: Path, now: str, last: str, kind: str) -> None:
    text = lines()
    text[6] = f"{now},20,1.0"
    path = bad_csv(tmp_path / "a.csv", "\n".join(text))
    if kind == "parquet":
        pd.read_csv(path).to_parquet(tmp_path / "a.parquet")
        path = tmp_path / "a.parquet"
    assert re.search(rf"row 7.*, column time_s: {now} follows {last}; the time must increase", complaint(path))


@pytest.mark.parametrize("row", range(30, 42))
@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_a_time_that_steps_back_where_a_chunk_may_begin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, row: int) -> None:
    monkeypatch.setattr("zoo.measurements.table.chunks.__defaults__", (120,))  # bytes: five rows of parquet, about nine of csv
    text = lines(60)
    text[10:row] = [f"{1000 + place}.5,20,{place % 5}" for place in range(10, row)]
    path = bad_csv(tmp_path / "a.csv", "\n".join(text))
    if kind == "parquet":
        pd.read_csv(path).to_parquet(tmp_path / "a.parquet")
        path = tmp_path / "a.parquet"
    assert re.search(rf"row {row + 1}\b.*, column time_s: {row - 1}\.5 follows {1000 + row - 1}\.5", complaint(path))


@pytest.mark.parametrize("kind", ["csv", "parquet"])
@pytest.mark.parametrize("chunk", [120, 4 << 20])
def test_rows_that_are_skipped_might_as_well_not_be_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, chunk: int) -> None:
    monkeypatch.setattr("zoo.measurements.table.chunks.__defaults__", (chunk,))  # bytes: five rows of parquet, about nine of csv
    good = lines(200)
    text, bad = list(good), {5: "4.5,,1", 6: "5.5,NaN,1", 40: "39.5,20,inf", 41: ",20,1", 90: "30.5,20,1", 91: "31.5,20,1", 150: "148.5,20,1"}
    for place, line in bad.items():
        text[place] = line
    path = bad_csv(tmp_path / "run.csv", "\n".join(text))
    (tmp_path / "without").mkdir()
    without = bad_csv(tmp_path / "without" / "run.csv", "\n".join(line for place, line in enumerate(good) if place not in bad))
    if kind == "parquet":
        pd.read_csv(path).to_parquet(tmp_path / "run.parquet")
        path = tmp_path / "run.parquet"
    assert complaint(path, average_s=5.0).endswith("; data.bad_rows=skip leaves such rows out")
    run, same = read_runs(path, average_s=5.0, bad_rows="skip")[0], read_runs(without, average_s=5.0)[0]
    assert torch.equal(run.table, same.table)
    assert torch.equal(run.error, same.error)
    assert run.rows == same.rows == 193
    told = f"{path.name}: 7 row(s) without a number in every cell, or whose time does not increase, are left out"
    assert set(run.notes) - set(same.notes) == {told}


@pytest.mark.parametrize("mark", [",", ";"])
def test_blanks_around_what_says_that_a_number_is_missing(tmp_path: Path, mark: str) -> None:
    rows = [line.replace(",", mark).replace(".", "," if mark == ";" else ".") for line in lines(400)]
    (tmp_path / "good.csv").write_text("\n".join([*rows[:3], *rows[6:]]))
    rows[3:6] = [mark.join((time, blank, "1")) for time, blank in (("2", "  "), ("3", " NA"), ("4", "NaN "))]
    (tmp_path / "bad.csv").write_text("\n".join(rows))
    found, good = (read_runs(tmp_path / name, bad_rows="skip", average_s=10)[0] for name in ("bad.csv", "good.csv"))
    assert torch.equal(found.error, good.error)
    assert any("3 row(s) without a number" in note for note in found.notes)


def test_a_file_whose_header_alone_has_another_end_of_line_is_read_in_pieces(tmp_path: Path) -> None:
    """As editors leave it behind: taken whole, it would have to fit into memory."""
    text = "\r\n".join(lines(1)[:1]) + "\r\n" + "\n".join(lines(20_000)[1:]) + "\n"
    (tmp_path / "a.csv").write_bytes(text.encode())
    parts = list(chunks(tmp_path / "a.csv", HEADER.split(","), 1 << 14))
    assert len(parts) > 10
    assert sum(map(len, parts)) == 20_000


def test_a_file_of_which_little_would_be_left_is_refused(tmp_path: Path) -> None:
    """One time far in the future makes every row after it late."""
    text = lines(100)
    text[30] = "1e6,20,1"
    assert "would leave out 70 of 100 rows" in complaint(bad_csv(tmp_path / "a.csv", "\n".join(text)), bad_rows="skip")
    for line in range(1, 101):
        text[line] = f"{line},,"
    assert "no row whose cells all hold a number" in complaint(bad_csv(tmp_path / "b.csv", "\n".join(text)), bad_rows="skip")


def test_text_and_broken_lines_are_not_skipped(tmp_path: Path) -> None:
    for line in ("6.5,warm,1", "6.5,20"):
        text = lines()
        text[7] = line
        assert "row 8" in complaint(bad_csv(tmp_path / "a.csv", "\n".join(text)), bad_rows="skip")


@pytest.mark.parametrize("cells", ["6.5,20", "6.5,20,1,5", "6,5;20;1"])
def test_a_row_with_too_few_or_too_many_cells(tmp_path: Path, cells: str) -> None:
    text = lines()
    text[7] = cells
    assert f"row 8: has {cells.count(',') + 1} cells, the header 3" in complaint(bad_csv(tmp_path / "a.csv", "\n".join(text)))


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (b"", "the file is empty"),
        (HEADER.encode(), "has a header and no rows"),
        (f"{HEADER}\n\n\n".encode(), "has a header and no rows"),
        (f"{HEADER}\n1,20,3\n".encode(), "has one row; a run needs at least two"),
        (bytes(range(256)) * 50, "is no text in UTF-8 but a binary file"),
        (gzip.compress("\n".join(lines()).encode(), mtime=0), "is no text in UTF-8 but a binary file"),
        (b"PAR1" + bytes(100), "is no text in UTF-8 but a binary file"),
        ("\n".join(lines()).encode("utf-16"), "is no text in UTF-8 but a binary file"),
        (HEADER.replace(",", ";").encode() + b"\n1,5;20;3\n2,5;20;3.5\n", "row 3, column rate_dph: '3.5' is not a finite number"),
        (HEADER.replace(",", "\t").encode() + b"\n1.5\t20\t3\n2.5\t20\n", "row 3: has 2 cells, the header 3"),
        (HEADER.encode() + b"\ns,degC,dph\n1,20,3\n", "row 2, column time_s: 's' is not a finite number; if this row holds units, delete it"),
        (HEADER.encode() + b"\n2026-11-27 10:00,20,3\n", "seconds are needed, no dates (in pandas: (t - t.iloc[0]).dt.total_seconds())"),
        (b"0.5,20,1\n1.5,20,2\n", "row 1: holds numbers (0.5,20,1) where a header"),
        (f"{HEADER},rate_dph\n1,2,3,4\n".encode(), "the header has rate_dph more than once"),
        ("\n".join(f"{row},20,3" if row else HEADER for row in range(9)).encode(), "column rate_dph: is 3 in all 8 rows"),
        (b"\n" + HEADER.encode() + b"\n1,2,3\n2,3,4\n", "row 1 is blank"),
    ],
)
def test_a_file_that_is_no_recording(tmp_path: Path, content: bytes, found: str) -> None:
    message = complaint(bad_csv(tmp_path / "a.csv", content))
    assert message.startswith(str(tmp_path / "a.csv"))
    assert found in message


def test_a_gz_that_is_none_or_is_cut_off(tmp_path: Path) -> None:
    assert "cannot be read" in complaint(bad_csv(tmp_path / "a.csv.gz", "\n".join(lines())))
    whole = gzip.compress("\n".join(lines(DEEP)).encode())
    assert "cannot be read to its end" in complaint(bad_csv(tmp_path / "b.csv.gz", whole[: len(whole) // 2]))


def test_a_parquet_that_is_empty_or_damaged(tmp_path: Path) -> None:
    assert "0 bytes" in complaint(bad_csv(tmp_path / "a.parquet", b""))
    assert "no readable parquet" in complaint(bad_csv(tmp_path / "b.parquet", "\n".join(lines())))
    frame = pd.DataFrame({"time_s": np.arange(50_000.0), "temperature_c": 20.0, "rate_dph": np.random.default_rng(1).normal(size=50_000)})
    frame.to_parquet(tmp_path / "c.parquet")
    data = bytearray((tmp_path / "c.parquet").read_bytes())
    data[4:400] = b"\xff" * 396
    assert "c.parquet: " in complaint(bad_csv(tmp_path / "c.parquet", bytes(data)))


@pytest.mark.parametrize(("value", "found"), [(np.nan, "empty or NaN"), (None, "empty or NaN"), (np.inf, "inf; a finite number")])
def test_a_bad_cell_in_a_parquet(tmp_path: Path, value: float | None, found: str) -> None:
    rows = 150_000
    frame = pd.DataFrame({"time_s": np.arange(float(rows)), "temperature_c": 20.0, "rate_dph": np.arange(float(rows))})
    frame["rate_dph"] = frame["rate_dph"].astype(object)
    frame.loc[140_000, "rate_dph"] = value
    frame.astype({"rate_dph": "float64"}).to_parquet(tmp_path / "a.parquet")
    message = complaint(tmp_path / "a.parquet")
    assert "row 140002 (the header counted as row 1), column rate_dph" in message
    assert found in message


def test_text_and_dates_in_a_parquet(tmp_path: Path) -> None:
    frame = pd.DataFrame({"time_s": pd.date_range("2024-01-01", periods=3), "temperature_c": 20.0, "rate_dph": ["1", "2", "3"]})
    frame.to_parquet(tmp_path / "a.parquet")
    assert re.search(r"column time_s: holds timestamp.*numbers are needed", complaint(tmp_path / "a.parquet"))
    frame.assign(time_s=[1, 2, 3]).to_parquet(tmp_path / "a.parquet")
    assert re.search(r"column rate_dph: holds .*string; numbers are needed", complaint(tmp_path / "a.parquet"))


def test_files_that_are_not_there(tmp_path: Path) -> None:
    bad_csv(tmp_path / "run_1.csv", "\n".join(lines()))
    assert re.search(r"run_2\.csv: no such file; .* has run_1\.csv$", complaint(tmp_path / "run_2.csv"))
    assert "no file matches" in complaint(tmp_path / "x*.csv")
    assert "does not exist" in complaint(tmp_path / "nowhere" / "*.csv")
    assert "is a folder; name the files in it" in complaint(tmp_path)
    assert "data.files is empty" in complaint([])
    assert "possible: .csv, .csv.gz, .parquet" in complaint(bad_csv(tmp_path / "a.xlsx", "x"))


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ({"average_s": "fast"}, "data.average_s=fast: possible are a positive number of seconds, auto and null"),
        ({"average_s": -1.0}, "data.average_s=-1.0"),
        ({"average_s": float("nan")}, "data.average_s=nan"),
        ({"gap_s": 0}, "data.gap_s=0"),
        ({"gap_s": 0.5}, "data.gap_s=0.5 is shorter than the time between rows, 1 s"),
        ({"reference": "north"}, "data.reference=north"),
        ({"bad_rows": "drop"}, "data.bad_rows=drop: possible are error, skip"),
        ({"average_s": 1000.0}, "no block of 1000 s has half of its rows (its 20 rows span"),
    ],
)
def test_settings_that_make_no_sense(tmp_path: Path, given: dict[str, object], found: str) -> None:
    assert found in complaint(bad_csv(tmp_path / "a.csv", "\n".join(lines())), **given)


def test_a_file_that_may_not_be_read_or_is_a_link_to_nowhere(tmp_path: Path) -> None:
    (tmp_path / "a.csv").symlink_to(tmp_path / "gone.csv")
    assert "no such file" in complaint(tmp_path / "a.csv")


@pytest.mark.parametrize("mark", ["-999", "-9999.0", "-273.2"])
def test_a_temperature_below_absolute_zero_is_none(tmp_path: Path, mark: str) -> None:
    spoilt = lines(500)
    spoilt[301] = f"300.5,{mark},0.5"
    path = bad_csv(tmp_path / "run.csv", "\n".join(spoilt) + "\n")
    found = complaint(path)
    for word in ("run.csv", "column temperature_c", f"{float(mark):g} °C", "at 300.5 s", "data.bad_rows=skip"):
        assert word in found
    run = read_runs(path, bad_rows="skip")[0]
    assert run.rows == 499
    assert float(run.temperature.min()) >= 20
    assert any("1 row(s)" in note for note in run.notes)


def test_dates_are_refused_with_what_is_needed(tmp_path: Path) -> None:
    for date in ("2025-03-01 12:00:04.5", "12:00:04", "1.3.2025 12:00", "01/03/25"):
        path = bad_csv(tmp_path / "run.csv", f"{HEADER}\n{date},20.0,1.0\n")
        assert "seconds are needed, no dates" in complaint(path)
