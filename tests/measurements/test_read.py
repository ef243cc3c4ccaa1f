"""Laws of reading: what a run is must not depend on the format, the chunks or the way it was asked for."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import torch

from zoo.errors import InputError
from zoo.measurements import read, table
from zoo.measurements.csv_table import Style
from zoo.measurements.read import read_runs
from zoo.measurements.run import Run
from zoo.measurements.write import write_measurements

Columns = dict[str, np.ndarray]


def recording(rows: int, step: float, jitter: float = 0.0, gaps: tuple[int, ...] = (), seed: int = 0) -> Columns:
    """A run with white noise; `jitter` in steps, a gap of 40 steps after each of the rows `gaps`."""
    random = np.random.default_rng(seed)
    steps = step * (1 + jitter * random.uniform(-1, 1, rows))
    steps[[gap + 1 for gap in gaps]] += 40 * step
    time = np.cumsum(steps).round(6)
    temperature = 20 + 10 * np.sin(time / 300)
    return {
        "time_s": time,
        "temperature_c": temperature.round(4),
        "rate_dph": (9.66 + 0.01 * temperature + random.normal(0, 0.1, rows)).round(6),
    }


def assert_equal(one: Run, other: Run) -> None:
    for name in ("table", "error", "count", "block"):
        assert torch.equal(getattr(one, name), getattr(other, name)), name
    assert (one.unit, one.columns, one.average_s, one.rows, one.notes) == (
        other.unit,
        other.columns,
        other.average_s,
        other.rows,
        other.notes,
    )


def test_csv_gz_and_parquet_give_identical_runs(tmp_path: Path) -> None:
    data = recording(30_000, 0.01, jitter=0.3, gaps=(7_000,))
    runs = [read_runs(write_measurements(tmp_path / f"run.{kind}", data))[0] for kind in ("csv", "csv.gz", "parquet")]
    assert runs[0].name == runs[1].name == "run"
    for other in runs[1:]:
        assert_equal(runs[0], other)


@pytest.mark.parametrize(("rows", "step", "average"), [(3_000, 1.0, 10.0), (3_000, 1.0, None), (801, 10.0, 100.0), (20_003, 0.04, 37.0)])
def test_when_a_run_begins_and_ends_is_told_by_its_rows(tmp_path: Path, rows: int, step: float, average: float | None) -> None:
    data = recording(rows, step)
    run = read_runs(write_measurements(tmp_path / "run.csv", data), average_s=average)[0]
    assert run.span_s == pytest.approx((data["time_s"][0], data["time_s"][-1]), abs=1e-5)


@pytest.mark.parametrize("turn", [1, -1])
def test_when_it_begins_and_ends_is_told_where_rows_become_rarer_as_well(tmp_path: Path, turn: int) -> None:
    data = recording(13_000, 0.1)
    data["time_s"] = np.cumsum(np.where(np.arange(13_000) < 9_000, 0.1, 1.0)[::turn]).round(6)
    run = read_runs(write_measurements(tmp_path / "run.csv", data), average_s=50.0)[0]
    assert run.span_s == pytest.approx((data["time_s"][0], data["time_s"][-1]), abs=1.0)


@pytest.mark.parametrize("average", ["auto", 5.0, 37.0, None])
@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_the_chunks_size_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, average: float | str | None) -> None:
    path = write_measurements(tmp_path / f"run.{kind}", recording(20_000, 0.04, jitter=0.4, gaps=(5_000, 5_003, 12_345)))
    whole = read_runs(path, average_s=average)[0]  # type: ignore[arg-type]
    plain = table.chunks
    sizes: list[int] = []

    def small(path: Path, columns: list[str], **given: Any) -> Iterator[np.ndarray]:
        for chunk in plain(path, columns, chunk_bytes=3_001, **given):
            sizes.append(len(chunk))
            yield chunk

    monkeypatch.setattr(read, "chunks", small)
    assert_equal(whole, read_runs(path, average_s=average)[0])  # type: ignore[arg-type]
    assert len(sizes) > 50


@pytest.mark.parametrize("average", ["auto", 1.0, 10.0, 37.0, None])
@pytest.mark.parametrize("step", [0.005, 0.3, 1.0, 7.0])
def test_every_row_is_counted_once_and_times_increase(tmp_path: Path, step: float, average: float | str | None) -> None:
    rows = max(3_000, int(100 / step))
    path = write_measurements(tmp_path / "a.csv", recording(rows, step, jitter=0.2, gaps=(1_000,)))
    run = read_runs(path, average_s=average)[0]  # type: ignore[arg-type]
    assert run.rows == int(run.count.sum()) == rows
    assert (torch.diff(run.time) > 0).all()
    judged = run.block[run.block >= 0]
    assert (torch.diff(judged) >= 0).all()
    assert torch.equal(judged.unique(), torch.arange(run.blocks))


@pytest.mark.parametrize(("step", "average"), [(0.01, 1.0), (0.5, 10.0), (0.505, 20.0), (3.0, 100.0)])
def test_grids_are_those_of_the_definition(tmp_path: Path, step: float, average: float) -> None:
    """Against a plain loop over the rows: bins [k·a/10, (k+1)·a/10) and blocks [k·a, (k+1)·a) from each segment's start."""
    data = recording(4_000, step, jitter=0.2, gaps=(900, 2_500))
    data["temperature_c"] = data["time_s"] / 1000  # a ramp that goes straight on in the gaps: else blocks after them were not judged
    run = read_runs(write_measurements(tmp_path / "a.csv", data), average_s=average)[0]
    binned = average / 5 >= 2 * step
    bins: dict[tuple[int, ...], list[int]] = {}
    blocks: dict[tuple[int, int], list[int]] = {}
    segment, start = 0, data["time_s"][0]
    for row, time in enumerate(data["time_s"]):
        if row and time - data["time_s"][row - 1] > 5 * step:
            segment, start = segment + 1, time
        since = time - start + 1e-4 * step  # up to rounding
        bins.setdefault((segment, int(since / (average / 5))) if binned else (row,), []).append(row)
        blocks.setdefault((segment, int(since / average)), []).append(row)
    for name, column in (("time_s", data["time_s"]), ("temperature_c", data["temperature_c"])):
        assert np.allclose(run.column(name), [column[rows].mean() for rows in bins.values()], rtol=1e-13)
    assert np.allclose(run.error, [data["rate_dph"][rows].mean() for rows in bins.values()], rtol=1e-12)
    full = [rows for rows in blocks.values() if len(rows) >= average / step / 2]
    assert len(full) < len(blocks)
    assert np.allclose(run.block_mean(run.error), [data["rate_dph"][rows].mean() for rows in full], rtol=1e-12)


@pytest.mark.parametrize("start", [0.0, 1.7e9])
def test_rows_on_an_edge_fall_into_the_bin_that_begins_there(tmp_path: Path, start: float) -> None:
    """Although 0.3 / 0.1 is a little less than 3, also where the time is that of a computer's clock."""
    data = recording(10_000, 0.02)
    data["time_s"] = start + np.arange(10_000) / 50
    run = read_runs(write_measurements(tmp_path / "a.csv", data), average_s=2.0)[0]
    assert run.count.unique().tolist() == [20]
    assert run.blocks == 100


@pytest.mark.parametrize("average", ["auto", 10.0])
def test_means_of_a_constant_are_that_constant(tmp_path: Path, average: float | str) -> None:
    data = recording(20_000, 0.013, jitter=0.4)
    data["temperature_c"] = np.full(20_000, 20.1)
    run = read_runs(write_measurements(tmp_path / "a.csv", data), reference=9.66, average_s=average)[0]  # type: ignore[arg-type]
    assert run.temperature.unique().tolist() == [20.1]
    assert run.column("reference_dph").unique().tolist() == [9.66]
    assert torch.allclose(run.block_mean(run.temperature), torch.tensor(20.1, dtype=torch.float64), rtol=1e-14)


def test_no_mean_straddles_a_gap(tmp_path: Path) -> None:
    """The output is the number of the segment: a mean over two of them would be no whole number."""
    data = recording(6_000, 0.1, jitter=0.3, gaps=(1_003, 1_777, 4_321))
    data["rate_dph"] = np.searchsorted(np.array([1_003, 1_777, 4_321]), np.arange(6_000)).astype(float)
    for average in (2.0, 5.0, 30.0):
        run = read_runs(write_measurements(tmp_path / "a.csv", data), average_s=average)[0]
        assert set(run.error.tolist()) == {0.0, 1.0, 2.0, 3.0}
        mean = run.block_mean(run.error)
        assert torch.allclose(mean, mean.round(), rtol=0, atol=1e-12)
        assert any(note.startswith("3 gap(s) in time, the longest 4.") for note in run.notes)


def test_a_longer_gap_can_be_allowed(tmp_path: Path) -> None:
    path = write_measurements(tmp_path / "a.csv", recording(2_000, 1.0, gaps=(1_000,)))
    assert any("gap" in note for note in read_runs(path)[0].notes)
    assert not any("gap" in note for note in read_runs(path, gap_s=60)[0].notes)


def test_another_unit_than_the_one_expected_is_pointed_at(tmp_path: Path) -> None:
    data = recording(2_000, 1.0)
    assert not any("taken as" in note for note in read_runs(write_measurements(tmp_path / "a.csv", data))[0].notes)
    kelvin = data | {"temperature_c": data["temperature_c"] + 273.15}
    assert any(
        "temperature_c reaches" in note and "taken as °C" in note for note in read_runs(write_measurements(tmp_path / "b.csv", kelvin))[0].notes
    )
    milliseconds = data | {"time_s": data["time_s"] * 10_000}
    path = write_measurements(tmp_path / "c.csv", milliseconds)
    with pytest.raises(InputError, match=r"would last 231 days or longer; say data\.time_unit=ms.* if it is another unit, and data\.time_unit=s if"):
        read_runs(path)
    assert float(read_runs(path, time_unit="s")[0].time[-1]) == pytest.approx(2e7, rel=0.01)


def test_a_times_unit_that_no_name_tells_can_be_said(tmp_path: Path) -> None:
    data = recording(2_000, 1.0)
    plain = read_runs(write_measurements(tmp_path / "a.csv", data))[0]
    renamed = {"t": (data["time_s"] * 1000).round(), "temperature_c": data["temperature_c"], "rate_dph": data["rate_dph"]}
    path = write_measurements(tmp_path / "b.csv", renamed)
    said = read_runs(path, columns={"time": "t"}, time_unit="ms")[0]
    torch.testing.assert_close(said.time, plain.time, rtol=0, atol=1e-3)
    assert "t is converted from ms to s" in said.notes
    assert any(note.startswith("t is taken as seconds, a row every 1000 s") for note in read_runs(path, columns={"time": "t"})[0].notes)
    assert not any("is taken as seconds" in note for note in read_runs(path, columns={"time": "t"}, time_unit="s")[0].notes)
    with pytest.raises(InputError, match=r"data\.time_unit=msec"):
        read_runs(path, columns={"time": "t"}, time_unit="msec")
    with pytest.raises(InputError, match=r"'time_s' is in s by its name, but data\.time_unit=ms"):
        read_runs(tmp_path / "a.csv", time_unit="ms")


def test_a_thin_block_stays_in_the_history_and_is_not_judged(tmp_path: Path) -> None:
    data = recording(1_000, 1.0)
    keep = np.r_[0:501, 530:1000]  # the block 500–599 s loses 29 rows at its start, which is a gap; then 4 blocks and 70 s remain
    path = write_measurements(tmp_path / "a.csv", {name: column[keep] for name, column in data.items()})
    run = read_runs(path, average_s=100.0)[0]
    assert run.blocks == 5 + 5
    assert run.count[run.block < 0].sum() == 1
    assert int(run.count.sum()) == len(keep)
    assert any(note.startswith("1 block(s) of 100 s with less than half") for note in run.notes)
    path = write_measurements(tmp_path / "a.csv", {name: column[:920] for name, column in data.items()})
    ended = read_runs(path, average_s=100.0)[0]
    assert (ended.blocks, int((ended.block < 0).sum()), ended.notes) == (9, 1, ()), "a recording may end where it likes"


@pytest.mark.parametrize(
    ("rows", "step", "expected"),
    [
        (41_000, 1.0, 100.0),
        (39_000, 1.0, 50.0),
        (4_100, 1.0, 10.0),
        (3_900, 0.1, 1.0),  # 390 s: too few even so, then the finest
        (100, 7.0, 10.0),
        (500, 200.0, 200.0),
        (410_000, 0.01, 10.0),
    ],
)
def test_auto_takes_the_longest_block_that_leaves_400(tmp_path: Path, rows: int, step: float, expected: float) -> None:
    run = read_runs(write_measurements(tmp_path / "a.parquet", recording(rows, step)))[0]
    assert run.average_s == expected
    assert run.blocks >= 400 or run.average_s == min(length for length in (1, 10, 200) if length >= step)


@pytest.mark.parametrize(("step", "rows"), [(0.02, 400_000), (0.4, 20_000), (2.0, 9_000)])
def test_auto_and_the_same_length_asked_for_agree(tmp_path: Path, step: float, rows: int) -> None:
    path = write_measurements(tmp_path / "a.parquet", recording(rows, step, jitter=0.2, gaps=(rows // 3,)))
    auto = read_runs(path)[0]
    asked = read_runs(path, average_s=auto.average_s)[0]
    assert torch.equal(auto.block, asked.block)
    assert torch.equal(auto.count, asked.count)
    assert torch.allclose(auto.table, asked.table, rtol=1e-13)
    assert torch.allclose(auto.error, asked.error, rtol=1e-11)


def test_auto_is_decided_once_for_all_runs(tmp_path: Path) -> None:
    for name, rows in (("a", 3_000), ("b", 1_500)):
        write_measurements(tmp_path / f"{name}.csv", recording(rows, 1.0, seed=rows))
    runs = read_runs([tmp_path / "*.csv"])
    assert [run.average_s for run in runs] == [10.0, 10.0]
    assert sum(run.blocks for run in runs) == 450
    assert read_runs(tmp_path / "b.csv")[0].average_s == 2.0


def test_memory_holds_bins_and_not_rows(tmp_path: Path) -> None:
    """Half an hour at 100 Hz: what is kept are tenths of seconds at most, whatever `average_s`."""
    path = write_measurements(tmp_path / "a.parquet", recording(180_000, 0.01))
    for average in ("auto", 1.0, 100.0):
        run = read_runs(path, average_s=average)[0]  # type: ignore[arg-type]
        assert len(run.time) <= 18_000
        assert run.count.min() >= 9


def test_null_is_as_recorded(tmp_path: Path) -> None:
    data = recording(500, 0.5, jitter=0.1)
    run = read_runs(write_measurements(tmp_path / "a.csv", data), reference=1.5, average_s=None)[0]
    assert np.array_equal(run.time, data["time_s"])
    assert np.array_equal(run.error, data["rate_dph"] - 1.5)
    assert torch.equal(run.block, torch.arange(500))
    assert run.average_s == pytest.approx(0.5, rel=0.02)


def test_blocks_shorter_than_the_sampling_are_as_recorded_and_said(tmp_path: Path) -> None:
    run = read_runs(write_measurements(tmp_path / "a.csv", recording(500, 10.0)), average_s=1.0)[0]
    assert (run.blocks, run.average_s) == (500, 10.0)
    assert any("as recorded, every 10 s" in note for note in run.notes)


def test_the_recorded_reference_is_subtracted_in_the_outputs_unit(tmp_path: Path) -> None:
    data = recording(600, 1.0)
    truth = 9.66 + np.linspace(0, 1, 600)
    expected = data["rate_dph"] - truth
    for column, values in (("reference_dph", truth), ("reference_dps", truth / 3600)):
        run = read_runs(write_measurements(tmp_path / "a.parquet", {**data, column: values}), reference=5.0, average_s=None)[0]
        assert np.allclose(run.error, expected, atol=1e-12)
        assert run.columns[-1] == "reference_dph"
        assert f"data.reference=5 is not used, as {column} is recorded" in run.notes
        assert np.allclose(run.column("reference_dph"), truth, rtol=1e-14)


def test_a_reference_that_one_run_records_is_not_0_in_the_others(tmp_path: Path) -> None:
    rows = np.arange(100.0)
    data = {"time_s": rows, "temperature_c": rows, "rate_dph": 9.66 + np.sin(rows)}
    known = write_measurements(tmp_path / "known.csv", data | {"reference_dph": np.full(100, 9.66)})
    files = [known, *(write_measurements(tmp_path / f"bare_{place}.csv", data) for place in (1, 2))]
    with pytest.raises(InputError, match=r"bare_1\.csv: does not record the true input \(nor do 1 more\), .*known\.csv does \(reference_dph\)"):
        read_runs(files)
    for run in read_runs(files, reference=9.66):
        assert torch.allclose(run.error, torch.sin(run.time), rtol=0, atol=1e-12), run.name


def test_a_start_up_row_is_noticed_and_kept(tmp_path: Path) -> None:
    data = recording(600, 1.0)
    quiet = read_runs(write_measurements(tmp_path / "a.csv", data))[0]
    data["rate_dph"][0] += 50
    run = read_runs(write_measurements(tmp_path / "a.csv", data))[0]
    assert not quiet.notes
    assert any("jumps after the first row" in note for note in run.notes)
    assert run.rows == 600


def test_run_names_are_unique(tmp_path: Path) -> None:
    for name in ("x/run.csv", "y/run.csv", "y/run.csv.gz", "y/other.csv"):
        write_measurements(tmp_path / name, recording(100, 1.0))
    names = [run.name for run in read_runs([tmp_path / "*/*.csv", tmp_path / "y/run.csv.gz"])]
    assert names == ["x/run", "other", str(tmp_path / "y/run.csv"), str(tmp_path / "y/run.csv.gz")]


@pytest.mark.parametrize(
    ("header", "row", "style"),
    [
        ("time_s;temperature_c, main;rate_dph, raw", "0,5;20,5;1,5", (";", ",")),
        ('time_s,temperature_c,"rate;x;y;z"', "0.5,20,1", (",", ".")),
        ("time_s\ttemperature_c\tnote", "0.5\t20.5\t1,5", ("\t", ".")),
        ("time_s\ttemperature_c\tpulses", "0.5\t20.5\t12,345", ("\t", ".")),
        ("time_s;temperature_c;rate_dph", "1;20;3", (";", ".")),
        (",".join(f"a_column_of_many_{i}" for i in range(10_000)), "1,2", (",", ".")),
        ("time_s,temperature_c,rate_dph", "", (",", ".")),
    ],
)
def test_how_a_table_is_written_is_told_by_its_numbers(tmp_path: Path, header: str, row: str, style: tuple[str, str]) -> None:
    (tmp_path / "a.csv").write_text(f"{header}\n{row}\n")
    assert Style.of(tmp_path / "a.csv") == Style(*style)


@pytest.mark.parametrize(("mark", "point"), [(";", ","), (";", "."), ("\t", ","), ("\t", ".")])
@pytest.mark.parametrize("kind", ["csv", "csv.gz"])
def test_semicolons_tabs_and_decimal_commas_are_read_alike(tmp_path: Path, mark: str, point: str, kind: str) -> None:
    data = pd.DataFrame(recording(3_000, 1.0)).round(6)
    plain = read_runs(write_measurements(tmp_path / "a.csv", {name: data[name].to_numpy() for name in data}))[0]
    data.to_csv(tmp_path / f"b.{kind}", sep=mark, decimal=point, index=False)
    other = read_runs(tmp_path / f"b.{kind}")[0]
    assert torch.equal(other.table, plain.table)
    assert torch.equal(other.error, plain.error)


def test_a_run_counts_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_measurements(tmp_path / "a.csv", recording(100, 1.0))
    (tmp_path / "link.csv").symlink_to(tmp_path / "a.csv")
    monkeypatch.chdir(tmp_path)
    for files in (["a.csv", "a.csv"], ["a.csv", tmp_path / "a.csv"], ["a.csv", "./*.csv"], ["*.csv"]):
        with pytest.raises(InputError, match=r"(a|link)\.csv: is named twice"):
            read_runs(files)


@pytest.mark.parametrize("name", ["a.csv", "a.parquet"])
def test_reading_imports_no_pandas(tmp_path: Path, name: str) -> None:
    """Arrow would, half-way through, and an interrupt in the meantime would be lost."""
    path = write_measurements(tmp_path / name, recording(100, 1.0))
    code = "import sys; from zoo.measurements.read import read_runs; read_runs(sys.argv[1]); sys.exit('pandas' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code, str(path)], check=False).returncode == 0


REAL = Path(__file__).parents[3] / "shared" / "data" / "real" / "imu_chamber.csv"


@pytest.mark.skipif(not REAL.exists(), reason="the real recording lies beside the project, in ../shared/data")
def test_a_real_recording_with_jitter_and_foreign_names() -> None:
    with pytest.raises(InputError, match=r"data\.columns\.output=gyro_x_rad_per_s\|gyro_y_rad_per_s"):
        read_runs(REAL)
    run = read_runs(REAL, columns={"output": "gyro_y_rad_per_s"})[0]
    assert (run.unit, run.average_s, run.rows, int(run.count.sum())) == ("rad_per_s", 10.0, 8400, 8400)
    assert run.columns == ("time_s", "temperature_c", "reference_rad_per_s")
    assert run.blocks == 425
    first = read_runs(REAL, columns={"output": "gyro_x_rad_per_s"})[0]
    assert any("jumps after the first row" in note for note in first.notes)


def test_a_named_range_of_pandas_is_a_column(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pandas writes no numbers for it, only where it starts, and with which step."""
    frame = pd.DataFrame(recording(500, 10.0))
    frame.to_parquet(tmp_path / "plain.parquet")
    start = int(frame["time_s"][0])
    frame.drop(columns="time_s").set_index(pd.RangeIndex(start, start + 5000, 10, name="time_s")).to_parquet(tmp_path / "range.parquet")
    monkeypatch.setattr("zoo.measurements.table.chunks.__defaults__", (1200,))  # bytes: many chunks
    plain, ranged = (read_runs(tmp_path / f"{name}.parquet", average_s=None)[0] for name in ("plain", "range"))
    assert np.allclose(plain.time - ranged.time, plain.time[0] - ranged.time[0])
    assert np.array_equal(plain.error, ranged.error)
    assert ranged.columns == plain.columns
    frame.set_index(pd.RangeIndex(len(frame), name="time_s")).to_parquet(tmp_path / "both.parquet")
    assert np.array_equal(read_runs(tmp_path / "both.parquet", average_s=None)[0].time, plain.time), "a column goes before a range of its name"


def test_thermometers_whose_names_tell_no_unit_can_be_said_to_be_in_kelvin(tmp_path: Path) -> None:
    data = recording(2_000, 1.0)
    plain = read_runs(write_measurements(tmp_path / "a.csv", data))[0]
    kelvin = {"imu": data["temperature_c"] + 273.15, "case": data["temperature_c"] + 274.15}
    path = write_measurements(tmp_path / "b.csv", {"time_s": data["time_s"], **kelvin, "rate_dph": data["rate_dph"]})
    columns = {"temperature": "imu", "temperature_case": "case"}
    said = read_runs(path, columns=columns, temperature_unit="k")[0]
    torch.testing.assert_close(said.temperature, plain.temperature, rtol=0, atol=1e-9)
    torch.testing.assert_close(said.column("temperature_case_c"), plain.temperature + 1.0, rtol=0, atol=1e-9)
    assert not any("taken as °C" in note for note in said.notes)
    with pytest.raises(InputError, match=r"data\.temperature_unit=kelvins"):
        read_runs(path, columns=columns, temperature_unit="kelvins")
    with pytest.raises(InputError, match=r"'temperature_c' is in c by its name, but data\.temperature_unit=k"):
        read_runs(tmp_path / "a.csv", temperature_unit="k")


def test_time_and_temperature_are_known_by_any_unit_in_their_names(tmp_path: Path) -> None:
    data = recording(2_000, 1.0)
    plain = read_runs(write_measurements(tmp_path / "a.csv", data))[0]
    other = {"time_min": data["time_s"] / 60, "temperature_f": 1.8 * data["temperature_c"] + 32, "rate_dph": data["rate_dph"]}
    found = read_runs(write_measurements(tmp_path / "b.csv", other))[0]
    assert found.columns == plain.columns
    torch.testing.assert_close(found.table[:, :2], plain.table[:, :2], rtol=0, atol=1e-6)
    both = read_runs(write_measurements(tmp_path / "c.csv", data | {"temperature_k": 0 * data["time_s"] + 300}))[0]
    torch.testing.assert_close(both.temperature, plain.temperature)
