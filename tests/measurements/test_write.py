"""What is written reads back exactly, and a failed write leaves nothing behind."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from zoo.errors import InputError
from zoo.measurements.write import write_measurements

KINDS = ["csv", "csv.gz", "parquet"]


def frame(rows: int = 50) -> pd.DataFrame:
    random = np.random.default_rng(1)
    return pd.DataFrame({"time_s": np.arange(rows) / 3, "temperature_c": random.normal(20, 5, rows), "rate_dph": random.normal(size=rows) * 1e-7})


def read(path: Path, kind: str) -> pd.DataFrame:
    """Without pandas' own csv reader, which is exact in some versions only."""
    if kind == "parquet":
        return pd.read_parquet(path)
    return pd.DataFrame(np.loadtxt(path, delimiter=",", skiprows=1), columns=list(frame(1)))


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_come_back_exactly(tmp_path: Path, kind: str) -> None:
    data = frame()
    path = write_measurements(tmp_path / f"new/a.{kind}", data)
    pd.testing.assert_frame_equal(read(path, kind), data, check_exact=True)
    again = write_measurements(tmp_path / f"b.{kind}", {name: torch.from_numpy(data[name].to_numpy().copy()) for name in data})
    assert again.read_bytes() == path.read_bytes()


@pytest.mark.parametrize("kind", KINDS)
def test_parts_make_the_same_table_as_the_whole(tmp_path: Path, kind: str) -> None:
    data = frame()
    path = write_measurements(tmp_path / f"a.{kind}", (data[start : start + 7] for start in range(0, 50, 7)))
    pd.testing.assert_frame_equal(read(path, kind), data, check_exact=True)


@pytest.mark.parametrize("kind", KINDS)
def test_a_failed_write_keeps_the_old_file(tmp_path: Path, kind: str) -> None:
    path = write_measurements(tmp_path / f"a.{kind}", frame())
    old = path.read_bytes()

    def failing() -> Iterator[pd.DataFrame]:
        yield frame(10)
        raise RuntimeError("the model failed")

    with pytest.raises(RuntimeError, match="the model failed"):
        write_measurements(path, failing())
    assert path.read_bytes() == old
    assert list(tmp_path.iterdir()) == [path]


def test_a_place_or_an_ending_that_is_not_possible(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be written"):
        write_measurements(tmp_path / "file" / "a.csv", frame())
    with pytest.raises(InputError, match=r"possible: \.csv, \.csv\.gz, \.parquet"):
        write_measurements(tmp_path / "a.xlsx", frame())
