"""`compensate` as a user types it: files, columns, units, messages."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import torch

from zoo.catalog import load_model
from zoo.cli.application import run
from zoo.units import convert

STEP_S = 20.0


def recording(high: float = 60.0, seed: int = 1) -> pd.DataFrame:
    """Four hours of a gyro with a bias that follows the temperature and its rate [°/h]."""
    time = np.arange(STEP_S / 2, 4 * 3600, STEP_S)
    temperature = 20 + (high - 20) * (np.clip(time / 3600 - 1, 0, 1) - np.clip(time / 3600 - 3, 0, 1))
    error = 0.2 * np.tanh((temperature - 35) / 8) - 0.1 * np.gradient(temperature, time / 60)
    noise = 0.01 * np.random.default_rng(seed).normal(size=len(time))
    return pd.DataFrame({"time_s": time, "temperature_c": temperature.round(4), "rate_dph": (error + noise).round(6)})


@pytest.fixture(scope="module")
def trained(tmp_path_factory) -> dict[str, Path]:
    """Output folders of a polynomial and of a grey box with hysteresis."""
    folder = tmp_path_factory.mktemp("trained")
    recording().to_csv(folder / "a.csv", index=False)
    files = [f"data.files=[{folder / 'a.csv'}]", "data.average_s=100"]
    models = {"polynomial": ["model=polynomial", "model.order=3"], "graybox": ["model=graybox", "effects=[static_bias,mohr,hysteresis]"]}
    for name, settings in models.items():
        assert run("train", [*settings, *files, f"hydra.run.dir={folder / name}"]) == 0
    return {name: folder / name for name in models}


def compensate(model: Path, *arguments: str) -> int:
    return run("compensate", [f"run={model}", "hydra.run.dir=out", *arguments])


def facts() -> list[dict[str, Any]]:
    files: list[dict[str, Any]] = json.loads(Path("out/compensation.json").read_text())["files"]
    return files


@pytest.mark.parametrize("name", ["polynomial", "graybox"])
def test_a_file_comes_back_with_two_columns_more(trained, name, capsys) -> None:
    frame = recording(50.0, seed=2)
    frame.to_csv("flight.csv", index=False)
    assert compensate(trained[name], "data.files=[flight.csv]") == 0
    assert capsys.readouterr().out.splitlines()[-1].endswith("out/flight.csv")
    found = pd.read_csv("out/flight.csv", engine="pyarrow")
    assert list(found) == [*frame, "predicted_error_dph", "rate_dph_compensated"]
    assert np.array_equal(found[list(frame)], frame)
    model = load_model(trained[name])
    columns = {"reference_dph": np.zeros(len(frame))} | {one: frame[one].to_numpy() for one in frame}
    with torch.no_grad():
        whole = model(torch.from_numpy(np.stack([columns[one] for one in model.inputs], axis=1))).numpy()
    np.testing.assert_allclose(found["predicted_error_dph"], whole, rtol=0, atol=1e-9 * np.abs(whole).max())
    assert np.array_equal(found["rate_dph_compensated"], found["rate_dph"] - found["predicted_error_dph"])
    assert found["rate_dph_compensated"].std() < 0.5 * frame["rate_dph"].std()
    assert Path("out/flight.png").stat().st_size > 10_000
    (one,) = facts()
    assert (one["rows"], one["rows_without_prediction"], one["rows_outside"], one["average_s"]) == (len(frame), 0, {}, 100)
    assert one["after"]["std"] < 0.5 * one["before"]["std"]


def test_another_unit_other_names_and_other_kinds_of_file(trained) -> None:
    """The same gyro in rad/s, in milliseconds and kelvins, as Parquet; what is predicted is in the file's unit."""
    frame = recording(50.0, seed=2)
    frame.to_csv("plain.csv.gz", index=False)
    other = pd.DataFrame(
        {"t_ms": 1000 * frame["time_s"], "imu_k": frame["temperature_c"] + 273.15, "gz": convert(frame["rate_dph"], "dph", "rad_per_s")}
    )
    other.to_parquet("other.parquet")
    names = ["data.columns.time=t_ms", "data.columns.temperature=imu_k", "data.columns.output=gz", "data.output_unit=rad/s"]
    assert compensate(trained["graybox"], "data.files=[other.parquet]", *names) == 0
    found = pd.read_parquet("out/other.parquet")
    assert compensate(trained["graybox"], "data.files=[plain.csv.gz]") == 0
    plain = pd.read_csv("out/plain.csv.gz")
    assert list(found)[3:] == ["predicted_error_rad_per_s", "gz_compensated"]
    expected = convert(plain["predicted_error_dph"].to_numpy(), "dph", "rad_per_s")
    np.testing.assert_allclose(found["predicted_error_rad_per_s"], expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_two_files_of_one_name_and_the_folder_as_result(trained, capsys) -> None:
    for day in ("monday", "tuesday"):
        Path(day).mkdir()
        recording().to_csv(f"{day}/run.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[monday/run.csv,tuesday/run.csv]") == 0
    assert capsys.readouterr().out.splitlines()[-1].endswith("/out")
    assert {"monday_run.csv", "tuesday_run.csv"} < {path.name for path in Path("out").iterdir()}


def test_no_file_takes_the_place_of_another(trained) -> None:
    """Whatever the folders are called, and with two kinds of file of one name."""
    paths = [Path("x/a_b/c.csv"), Path("y/z/c.csv"), Path("q/a_b_c.csv"), Path("y/z/c.csv.gz")]
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        recording().to_csv(path, index=False)
    assert compensate(trained["polynomial"], f"data.files=[{','.join(map(str, paths))}]") == 0
    written = [one["written"] for one in facts()]
    assert len(set(written)) == len(paths)
    for path, one in zip(paths, facts(), strict=True):
        assert one["file"] == str(path)
        assert Path(one["written"]).name.count(".csv") == 1
        assert len(pd.read_csv(one["written"])) == len(recording())


def test_every_file_has_a_picture_of_its_own(trained) -> None:
    recording().to_csv("run.csv", index=False)
    recording(50.0, seed=2).to_parquet("run.parquet")
    recording(40.0, seed=3).to_csv("other.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[run.csv,run.parquet,other.csv]") == 0
    pictures = sorted(Path("out").glob("*.png"))
    assert [one.name for one in pictures] == ["other.csv.png", "run.csv.png", "run.parquet.png"]
    assert len({one.read_bytes() for one in pictures}) == 3


@pytest.mark.parametrize("first", [0, 1, 300])
def test_rows_that_come_late_are_left_empty_where_that_is_asked_for(trained, first) -> None:
    """Stamps that were written twice, one that went back, one that is missing."""
    frame = recording()
    late = pd.concat([frame[: first + 1], frame[first : first + 1], frame[first + 1 : 400], frame[350:351].assign(time_s=np.nan), frame[400:]])
    late.to_csv("late.csv", index=False)
    frame.to_csv("good.csv", index=False)
    assert compensate(trained["graybox"], "data.files=[late.csv,good.csv]", "data.bad_rows=skip") == 0
    written, good = pd.read_csv("out/late.csv"), pd.read_csv("out/good.csv")
    added = ["predicted_error_dph", "rate_dph_compensated"]
    assert len(written) == len(frame) + 2
    assert written.index[written[added].isna().any(axis=1)].tolist() == [first + 1, 401]
    pd.testing.assert_frame_equal(written[added].dropna().reset_index(drop=True), good[added], rtol=1e-9)
    assert facts()[0]["rows_without_prediction"] == 2


@pytest.mark.parametrize("mark", [np.nan, -999.0])
def test_rows_without_a_temperature_are_left_empty_and_forgotten(trained, capsys, mark) -> None:
    """Or with one below absolute zero, by which some recorders say so."""
    frame = recording()
    without = frame.drop(index=range(100, 110))
    frame.loc[100:109, "temperature_c"] = mark
    frame.to_csv("holes.csv", index=False)
    without.to_csv("without.csv", index=False)
    assert compensate(trained["graybox"], "data.files=[holes.csv,without.csv]") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "10 of 720 rows lack a number" in printed
    assert "(the first: row 102, temperature_c)" in printed, "the header is row 1"
    holes, rest = pd.read_csv("out/holes.csv"), pd.read_csv("out/without.csv")
    added = ["predicted_error_dph", "rate_dph_compensated"]
    assert holes.loc[100:109, added].isna().all(axis=None)
    pd.testing.assert_frame_equal(holes[added].dropna().reset_index(drop=True), rest[added], rtol=1e-9)


def test_a_model_of_time_alone_forgets_a_row_that_cannot_be_used() -> None:
    """It uses no column but the time, which such a row does not have either."""
    frame = recording()
    frame.to_csv("a.csv", index=False)
    assert run("train", ["model=graybox", "effects=[aging,bias_step]", "data.files=[a.csv]", "hydra.run.dir=timed"]) == 0
    frame.loc[100, "time_s"] = np.nan
    frame.to_csv("hole.csv", index=False)
    frame.drop(index=100).to_csv("without.csv", index=False)
    assert compensate(Path("timed"), "data.files=[hole.csv,without.csv]", "data.bad_rows=skip") == 0
    hole, rest = pd.read_csv("out/hole.csv")["predicted_error_dph"], pd.read_csv("out/without.csv")["predicted_error_dph"]
    assert hole.index[hole.isna()].tolist() == [100]
    np.testing.assert_allclose(hole.dropna(), rest, rtol=1e-9, atol=1e-12)


def more(frame: pd.DataFrame) -> pd.DataFrame:
    """The recording with the supply and the field, as simulated runs have them."""
    hours = frame["time_s"] / 3600
    return frame.assign(supply_v=5 + 0.05 * np.sin(hours), field_ut=20 + 4 * np.cos(3 * hours))


@pytest.fixture(scope="module")
def more_than_used(tmp_path_factory) -> dict[str, Path]:
    """Output folders of grey boxes that were given the supply and the field: one uses neither, one the supply."""
    folder = tmp_path_factory.mktemp("more")
    more(recording()).to_csv(folder / "a.csv", index=False)
    given = ["model=graybox", f"data.files=[{folder / 'a.csv'}]", "data.average_s=100"]
    for name, effect in (("neither", "hysteresis"), ("supply", "supply_voltage")):
        assert run("train", [*given, f"effects=[static_bias,mohr,{effect}]", f"hydra.run.dir={folder / name}"]) == 0
    return {name: folder / name for name in ("neither", "supply")}


def test_only_columns_that_the_model_uses_are_asked_for(more_than_used, capsys) -> None:
    whole = more(recording(50.0, seed=2))
    whole.to_csv("whole.csv", index=False)
    whole.drop(columns=["supply_v", "field_ut"]).to_csv("bare.csv", index=False)
    assert compensate(more_than_used["neither"], "data.files=[whole.csv,bare.csv]") == 0
    predicted = [pd.read_csv(f"out/{name}.csv")["predicted_error_dph"] for name in ("whole", "bare")]
    assert np.array_equal(*predicted)
    model = load_model(more_than_used["neither"])
    x = torch.from_numpy(whole.assign(reference_dph=0.0)[model.inputs].to_numpy())
    with torch.no_grad():
        np.testing.assert_allclose(predicted[0], model(x).numpy(), rtol=0, atol=1e-9)
    capsys.readouterr()
    assert compensate(more_than_used["supply"], "data.files=[bare.csv]") == 2
    assert "the model GrayBox needs the column supply_v; the file has time_s, temperature_c" in capsys.readouterr().err


def test_only_columns_that_the_models_use_are_asked_for_in_a_comparison(more_than_used, capsys) -> None:
    whole = more(recording(50.0, seed=2))
    whole.to_csv("whole.csv", index=False)
    whole.drop(columns=["supply_v", "field_ut"]).to_csv("bare.csv", index=False)
    neither, supply = more_than_used["neither"], more_than_used["supply"]
    for files in (["data.files=[bare.csv]"], ["data.files=[whole.csv]", "data.check_files=[bare.csv]"]):
        assert run("compare", [f"runs=[{neither}]", *files, "data.average_s=100", "hydra.run.dir=table"]) == 0
        found = json.loads(Path("table/comparison.json").read_text())
        left = {row["graybox"] for row in found["rows"] if row["stage"] == "whole"}
        assert len(left) == 1, "the same of the same record"
        capsys.readouterr()
        assert run("compare", [f"runs=[{neither},{supply}]", *files, "hydra.run.dir=no"]) == 2
        told = capsys.readouterr().err
        assert f"{supply}: bare: the model needs the column supply_v; the file has time_s, temperature_c" in told


def test_what_was_never_fitted_is_told(trained, capsys) -> None:
    recording(80.0).to_csv("hot.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[hot.csv]") == 0
    assert "temperature_c is outside of what was fitted (20 … 60)" in capsys.readouterr().out.replace("\n", " ")
    assert facts()[0]["rows_outside"]["temperature_c"]["to"] == 80.0


def test_bias_and_rms_are_told_where_the_true_input_is_known(trained, capsys) -> None:
    frame = recording()
    frame["rate_dph"] += 5
    frame.to_csv("a.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[a.csv]") == 0
    assert "data.reference" in capsys.readouterr().out
    assert compensate(trained["polynomial"], "data.files=[a.csv]", "data.reference=5") == 0
    assert "data.reference" not in capsys.readouterr().out
    assert facts()[0]["before"]["rms"] > 0.1
    assert facts()[0]["before"]["mean"] == pytest.approx(recording()["rate_dph"].mean(), abs=0.01)


def test_a_recording_that_lies_where_the_result_would_is_kept(trained, capsys) -> None:
    for folder, seed in (("in", 1), ("out", 2)):
        Path(folder).mkdir()
        recording(seed=seed).to_csv(f"{folder}/a.csv", index=False)
    before = Path("out/a.csv").read_bytes()
    assert compensate(trained["polynomial"], "data.files=[in/a.csv]") == 2
    assert "out/a.csv: is there, and nothing that was compensated" in capsys.readouterr().err
    assert Path("out/a.csv").read_bytes() == before
    Path("out/a.csv").unlink()
    for _ in range(2):  # what it has written itself it writes again
        assert compensate(trained["polynomial"], "data.files=[in/a.csv]") == 0


@pytest.mark.parametrize(
    ("change", "arguments", "found"),
    [
        ({"predicted_error_dph": 0.0}, [], "compensated already, it has the column predicted_error_dph"),
        ({"rate_dph_compensated": 0.0}, [], "compensated already"),
        ({"temperature_c": np.nan}, [], "no row has a number"),
        ({"rate_dph": "x"}, [], "column rate_dph: 'x' is not a finite number"),
        ({}, ["data.columns.output=rate_dph", "data.output_unit=dps"], "is in °/h by its name"),
        ({}, ["hydra.run.dir=."], "would be overwritten"),
        ({}, ["data.average_s=-1"], "data.average_s=-1"),
        ({}, ["data.bad_rows=drop"], "data.bad_rows=drop: possible are error, skip"),
        ({"time_s": 1.0}, [], "the time must increase from row to row; with data.bad_rows=skip such rows get empty cells"),
        ({}, ["run=nowhere"], "run: nowhere: no model.yaml"),
    ],
)
def test_what_cannot_be_compensated_is_told_and_nothing_is_written(trained, capsys, change, arguments, found) -> None:
    recording().assign(**change).to_csv("a.csv", index=False)
    assert run("compensate", [f"run={trained['polynomial']}", "data.files=[a.csv]", "hydra.run.dir=out", *arguments]) == 2
    told = capsys.readouterr().err
    assert found in told
    assert 1 <= len(told.strip().splitlines()) <= 2
    assert not list(Path().glob("out/*.csv"))


def test_a_file_that_cannot_be_compensated_leaves_what_was_written_before(trained, capsys) -> None:
    recording().to_csv("a.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[a.csv]") == 0
    before = {path: path.read_bytes() for path in Path("out").iterdir() if path.is_file()}
    recording().assign(temperature_c=np.nan).to_csv("a.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[a.csv]") == 2
    assert "no row has a number" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in before} == before


def test_a_model_of_another_quantity_is_refused(trained, capsys) -> None:
    recording().rename(columns={"rate_dph": "accel_ug"}).to_csv("a.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[a.csv]") == 2
    assert "trained on errors in °/h" in capsys.readouterr().err


def test_a_users_effect_with_a_memory_of_its_own_is_refused(tmp_path, monkeypatch, capsys) -> None:
    (tmp_path / "conf" / "effects").mkdir(parents=True)
    (tmp_path / "conf" / "effects" / "hottest.yaml").write_text("hottest:\n  _target_: hottest_of_mine.Hottest\n")
    (tmp_path / "hottest_of_mine.py").write_text(
        "from zoo.effects.base import Effect, Parameter\n\n"
        "class Hottest(Effect):\n"
        "    name = 'hottest'\n"
        "    amplitudes = (Parameter('a', 0.0, 'unit', -1.0, 1.0),)\n"
        "    def columns(self, history, shape):\n"
        "        return history.temperature.cummax(-1).values.unsqueeze(-1) + 0 * shape.sum(-1, keepdim=True).unsqueeze(-1)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    recording().to_csv("a.csv", index=False)
    effects = ["model=graybox", "effects=[mohr,hottest]", f"hydra.searchpath=[file://{tmp_path}/conf]"]
    assert run("train", [*effects, "data.files=[a.csv]", "hydra.run.dir=model"]) == 0
    assert compensate(Path("model"), "data.files=[a.csv]") == 1
    told = capsys.readouterr().err
    assert "effect 'hottest' (hottest_of_mine.Hottest) has a memory of its own" in told
    assert not Path("out/a.csv").exists()


@pytest.mark.parametrize("name", ["polynomial", "graybox"])
def test_a_row_alone_is_compensated_as_a_longer_files_first(trained, name) -> None:
    frame = recording()
    frame.to_csv("long.csv", index=False)
    frame.head(1).to_csv("one.csv", index=False)
    assert compensate(trained[name], "data.files=[one.csv,long.csv]") == 0
    one, whole = (pd.read_csv(f"out/{file}.csv") for file in ("one", "long"))
    assert one["rate_dph_compensated"][0] == pytest.approx(whole["rate_dph_compensated"][0], rel=1e-9)  # products of few rows round otherwise
    assert [file["rows"] for file in facts()] == [1, len(frame)]


def test_a_time_that_pandas_keeps_as_a_range_is_read_and_kept(trained) -> None:
    frame = recording()
    frame.to_parquet("plain.parquet")
    numbered = frame.drop(columns="time_s").set_index(pd.RangeIndex(10, 10 + 20 * len(frame), 20, name="time_s"))
    numbered.to_parquet("numbered.parquet")
    assert compensate(trained["polynomial"], "data.files=[numbered.parquet,plain.parquet]") == 0
    back, plain = (pd.read_parquet(f"out/{file}.parquet") for file in ("numbered", "plain"))
    assert back.index.equals(numbered.index)
    assert np.array_equal(back["rate_dph_compensated"], plain["rate_dph_compensated"])


def test_an_output_in_another_unit_than_the_true_input_tells_is_told(trained, capsys) -> None:
    right = recording().assign(reference_dph=9.66)
    right["rate_dph"] += 9.66
    right.to_csv("a.csv", index=False)
    right.rename(columns={"rate_dph": "rate_dps"}).to_csv("b.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[a.csv,b.csv]") == 0
    (told,) = (line for line in capsys.readouterr().out.splitlines() if "×" in line and "about" in line)
    assert told.startswith("b.csv: rate_dps is about 3600 × reference_dph: is rate_dps in °/h")


def test_of_files_with_and_without_a_true_input_those_without_are_named(trained, capsys) -> None:
    recording().assign(reference_dph=0.0).to_csv("a.csv", index=False)
    recording().to_csv("b.csv", index=False)
    files = "data.files=[a.csv,b.csv]"
    assert compensate(trained["polynomial"], files) == 0
    assert "the true input of b.csv is neither recorded nor given" in " ".join(capsys.readouterr().out.split())
    assert [one["reference_known"] for one in facts()] == [True, False]
    of_input = ["model=polynomial", "model.order=1", "model.features=[temperature,reference_dph]", "data.files=[c.csv]", "hydra.run.dir=of_input"]
    turned = recording()
    turned.assign(reference_dph=np.sin(turned["time_s"] / 1000)).to_csv("c.csv", index=False)
    assert run("train", of_input) == 0
    assert compensate(Path("of_input"), files) == 2, "its prediction needs it"
    assert "b.csv: does not record the true input, a.csv does" in capsys.readouterr().err
    assert compensate(Path("of_input"), files, "data.reference=0") == 0


def test_columns_are_called_as_in_the_training_unless_something_else_is_said(trained) -> None:
    frame = recording()
    other = frame.assign(t=frame["time_s"] * 1000, imu=frame["temperature_c"] + 273.15).rename(columns={"rate_dph": "gz"})[["t", "imu", "gz"]]
    other.to_csv("other.csv", index=False)
    mapping = ["data.columns.time=t", "data.time_unit=ms", "data.columns.temperature=imu", "data.temperature_unit=k"]
    mapping += ["data.columns.output=gz", "data.output_unit=dph"]
    assert run("train", ["model=polynomial", "data.files=[other.csv]", *mapping, "hydra.run.dir=mapped"]) == 0
    frame.to_csv("a.csv", index=False)
    for name, more in (("other", []), ("other", mapping), ("a", [])):
        assert compensate(Path("mapped"), f"data.files=[{name}.csv]", *more) == 0
        left = pd.read_csv(f"out/{name}.csv")
        assert left.filter(like="_compensated").std().iloc[0] < 0.06
        assert run("compare", ["runs=[mapped]", f"data.files=[{name}.csv]", "hydra.run.dir=compared", *more]) == 0
    assert compensate(Path("mapped"), "data.files=[other.csv]", "data.columns.time=t") == 2
    frame.assign(time_ms=1000 * frame.pop("time_s")).to_csv("ms.csv", index=False)
    assert compensate(Path("mapped"), "data.files=[ms.csv]") == 0, "a unit goes with the column that had it"


def test_what_only_the_training_had_need_not_be_there(capsys) -> None:
    """The true input, say, which flies nowhere."""
    frame = recording().rename(columns={"time_s": "t"})
    frame.assign(truth=1.0, rate_dph=frame["rate_dph"] + 1.0).to_csv("trained.csv", index=False)
    frame.to_csv("flown.csv", index=False)
    mapping = ["data.columns.time=t", "data.columns.reference=truth"]
    assert run("train", ["model=polynomial", "data.files=[trained.csv]", *mapping, "hydra.run.dir=mapped"]) == 0
    assert compensate(Path("mapped"), "data.files=[flown.csv]") == 0
    assert "columns as in the training: time=t" in capsys.readouterr().err


def test_a_file_of_a_gyro_that_was_off_is_told(trained, capsys) -> None:
    recording().assign(rate_dph=0.0).to_csv("a.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[a.csv]") == 0
    assert "the output never changes: is it a recording of a gyro that was on?" in " ".join(capsys.readouterr().out.split())


def test_a_file_in_other_units_than_it_is_taken_for_is_told(trained, capsys) -> None:
    frame = recording()
    frame.assign(t=1000 * frame["time_s"], imu=frame["temperature_c"] + 273.15).drop(columns="time_s").to_csv("a.csv", index=False)
    short = ["data.files=[a.csv]", "data.columns.time=t"]
    frame.assign(t=1000 * frame["time_s"]).iloc[:, 1:].to_csv("long.csv", index=False)
    assert compensate(trained["polynomial"], "data.files=[long.csv]", "data.columns.time=t") == 2
    assert "column t is taken as s, and the run would last 166 days or longer" in capsys.readouterr().err
    assert not Path("out/long.csv").exists()
    assert compensate(trained["polynomial"], *short, "data.time_unit=ms", "data.columns.temperature=imu", "data.reference=0") == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "imu reaches 333; it is taken as °C" in told
    assert "× the RMS of no model at all; for this file it is of no use" in told
    assert compensate(trained["polynomial"], *short, "data.time_unit=ms", "data.columns.temperature=imu", "data.temperature_unit=k") == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "taken as °C" not in told
    assert "no model at all" not in told
    assert facts()[0]["after"]["rms"] < facts()[0]["before"]["rms"]


def test_a_time_beyond_the_trained_range_is_told_where_it_is_a_feature(capsys) -> None:
    frame = recording()
    frame.to_csv("a.csv", index=False)
    assert run("train", ["model=polynomial", "model.features=[temperature,time_s]", "data.files=[a.csv]", "hydra.run.dir=timed"]) == 0
    frame.assign(time_s=frame["time_s"] + 1e6).to_csv("late.csv", index=False)
    capsys.readouterr()
    assert compensate(Path("timed"), "data.files=[late.csv]") == 0
    assert "time_s is outside of what was fitted" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["polynomial", "ls_svm"])
def test_a_ramp_steeper_than_any_in_training_is_told(capsys, name) -> None:
    frame = recording()
    frame.to_csv("a.csv", index=False)
    features = "model.features=[temperature,temperature_rate]"
    assert run("train", [f"model={name}", features, "data.files=[a.csv]", "hydra.run.dir=slow"]) == 0
    steep = frame.assign(temperature_c=20 + 35 * np.clip(frame["time_s"] / 900 - 8, 0, 1))  # 2.3 K/min where 0.67 was fitted, inside the temperatures
    pd.concat([steep, steep.assign(time_s=steep["time_s"] + 4 * 3600)]).to_csv("steep.csv", index=False)
    capsys.readouterr()
    assert compensate(Path("slow"), "data.files=[steep.csv]") == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "temperature_rate is outside of what was fitted (-0.66" in told
    assert "temperature_c is outside" not in told
    found = facts()[0]["rows_outside"]["temperature_rate"]
    assert 2 * 40 <= found["rows"] <= 3 * 50
    assert found["to"] == pytest.approx(35 / 15, rel=0.02)
    assert compensate(Path("slow"), "data.files=[a.csv]") == 0
    assert "outside of what was fitted" not in capsys.readouterr().out
    assert run("export", ["run=slow", "hydra.run.dir=out", "program=false"]) == 0
    assert "feature temperature_rate trained from -0.66" in " ".join(capsys.readouterr().out.split())


def test_the_rate_of_what_stood_still_in_training_is_nothing_and_is_not_fitted_to(capsys) -> None:
    """What rounding leaves of it would be blown up to unit variance, and a model of it would not even go on from chunk to chunk."""
    frame = recording().assign(temperature_outer_c=25.1)
    frame.to_csv("a.csv", index=False)
    features = "model.features=[temperature,temperature_outer_rate]"
    assert run("train", ["model=polynomial", features, "data.files=[a.csv]", "hydra.run.dir=still"]) == 0
    assert load_model(Path("still")).formula()["coefficients"]["temperature_outer_rate"] == 0.0
    assert json.loads(Path("still/ranges.json").read_text())["temperature_outer_rate"] == [0.0, 0.0]
    frame.assign(temperature_outer_c=25.1 + 40 * np.clip(frame["time_s"] / 900 - 8, 0, 1)).to_csv("moving.csv", index=False)
    capsys.readouterr()
    assert compensate(Path("still"), "data.files=[moving.csv]") == 0
    assert "temperature_outer_rate is outside of what was fitted (0 … 0)" in " ".join(capsys.readouterr().out.split())
