"""Wrong recordings and settings, typed as a user types them: exit code 2, a line or two that help, and nothing half-written."""

from __future__ import annotations

import gzip
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from zoo.cli.application import run

ROWS, STEP_S = 720, 20.0
RESULTS = {"diagnosis.json", "refinement.json", "report.html", "tensorboard", "model.yaml", "weights.pt", "metrics.json"}


def table(rows: int = ROWS, swing: float = 40.0, unit: str = "dph") -> pd.DataFrame:
    """Four hours of a gyro: a hold, a ramp, a hold, the ramp back."""
    time = STEP_S * np.arange(rows) + STEP_S / 2
    ramp = np.clip(time / 3600 - 1, 0, 1) - np.clip(time / 3600 - 3, 0, 1)
    noise = np.random.default_rng(1).normal(size=rows)
    return pd.DataFrame({"time_s": time, "temperature_c": 20 + swing * ramp, f"rate_{unit}": (0.02 * ramp + 0.01 * noise).round(6)})


def written(path: Path, frame: pd.DataFrame, *changes: tuple[int, str, str]) -> Path:
    """A CSV with some cells (row as an editor counts, column, text) replaced."""
    lines = [list(frame.columns), *frame.astype(str).to_numpy().tolist()]
    for row, column, text in changes:
        lines[row - 1][list(frame.columns).index(column)] = text
    path.write_text("\n".join(",".join(line) for line in lines) + "\n")
    return path


@pytest.fixture
def told(tmp_path, capsys) -> Callable[..., str]:
    """Runs a verb that must refuse its input; gives what it said."""

    def refuse(*arguments: str, verb: str = "diagnose") -> str:
        out = tmp_path / "out"
        assert run(verb, [*arguments, f"hydra.run.dir={out}"]) == 2
        captured = capsys.readouterr()
        assert 1 <= len(captured.err.strip().splitlines()) <= 2, captured.err
        assert captured.err.startswith("error: ")
        assert "Traceback" not in captured.err + captured.out
        assert not out.exists(), "nor the folder for it"
        left = {path.name for path in tmp_path.rglob("*")}
        assert not left & RESULTS, left & RESULTS
        assert not any(name.endswith(".part") for name in left)
        return captured.err

    return refuse


@pytest.fixture
def refused(told) -> Callable[..., str]:
    """The same for one recording, which the message must name."""

    def refuse(path: Path, *more: str, verb: str = "diagnose") -> str:
        message = told(f"data.files=[{path}]", *more, verb=verb)
        assert path.name in message or path.name.partition(".")[0] in message
        return message

    return refuse


def test_the_recording_that_the_others_are_spoilt_from_is_good(tmp_path, capsys) -> None:
    path = written(tmp_path / "a.csv", table())
    assert run("diagnose", [f"data.files=[{path}]", "candidates=[warm_up]", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    captured = capsys.readouterr()
    assert captured.out.splitlines()[-1] == str(tmp_path / "out" / "diagnosis.json")
    assert {"diagnosis.json", "report.html", "tensorboard"} <= {one.name for one in (tmp_path / "out").iterdir()}
    assert not list(tmp_path.rglob("*.part"))


# Columns and units


@pytest.mark.parametrize("column", ["time_s", "temperature_c", "rate_dph"])
def test_a_missing_column(refused, tmp_path, column) -> None:
    message = refused(written(tmp_path / "a.csv", table().rename(columns={column: "foo"})))
    assert "foo" in message, "what is there"
    role = {"time_s": "time", "temperature_c": "temperature", "rate_dph": "output"}[column]
    assert f"data.columns.{role}=" in message, "and how to say which it is"


def test_a_mapped_column_that_is_not_there(refused, tmp_path) -> None:
    message = refused(written(tmp_path / "a.csv", table()), "data.columns.output=gz")
    assert "no column 'gz'" in message
    assert "rate_dph" in message


def test_an_unknown_unit(refused, told, tmp_path) -> None:
    path = written(tmp_path / "a.csv", table().rename(columns={"rate_dph": "gz"}))
    assert "dph|dps|rad_per_s" in refused(path, "data.columns.output=gz")
    message = told(f"data.files=[{path}]", "data.columns.output=gz", "data.output_unit=deg/fortnight")
    assert "unknown unit 'deg/fortnight'" in message
    assert "dph (°/h)" in message


def test_two_runs_in_different_units(refused, tmp_path) -> None:
    other = written(tmp_path / "b.csv", table(unit="dps"))
    message = refused(written(tmp_path / "a.csv", table()), f"data.files=[{tmp_path / 'a.csv'},{other}]")
    assert "b.csv" in message
    assert "°/h" in message
    assert "°/s" in message


def test_a_check_run_in_another_unit_or_without_a_column(told, tmp_path) -> None:
    files = f"data.files=[{written(tmp_path / 'a.csv', table().assign(supply_v=5.0))}]"
    other = written(tmp_path / "b.csv", table(unit="dps").assign(supply_v=5.0))
    assert "one unit is needed" in told(files, f"data.check_files=[{other}]", "add=warm_up", verb="refine")
    bare = f"data.check_files=[{written(tmp_path / 'c.csv', table())}]"
    for verb, more in (
        ("refine", ["add=supply_voltage"]),
        ("refine", ["effects=[static_bias,supply_voltage]", "add=warm_up"]),
        ("train", ["model.features=[temperature,supply_v]"]),
        ("train", ["model=hybrid", "effects=[mohr,supply_voltage]"]),
        ("train", ["model=hybrid", "effects=[mohr]", "model.network.features=[supply_v]"]),
        ("train", ["model=graybox", "effects=[mohr]", "model.inputs=[time_s,temperature_c,supply_v,reference_dph]"]),
    ):
        assert "c lacks the column supply_v" in told(files, bare, *more, verb=verb)
    for verb in ("diagnose", "refine"):
        assert "c lacks the column supply_v that the fitted runs have; candidates=[…]" in told(files, bare, verb=verb), "it may be what is missing"


@pytest.mark.parametrize(
    ("verb", "settings"),
    [
        ("refine", ["add=aging", "candidates=all"]),
        ("diagnose", ["candidates=[aging]"]),
        ("train", ["model=polynomial"]),
        ("train", ["model=graybox", "effects=[static_bias,mohr]"]),
    ],
)
def test_a_check_run_needs_no_column_that_nothing_asked_for_takes(tmp_path, verb, settings) -> None:
    fitted, check = written(tmp_path / "a.csv", table().assign(supply_v=5.0)), written(tmp_path / "c.csv", table())
    files = [f"data.files=[{fitted}]", f"data.check_files=[{check}]"]
    assert run(verb, [*settings, *files, f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    if verb != "diagnose":
        assert "supply_v" not in (tmp_path / "out" / "model.yaml").read_text()


@pytest.mark.parametrize("verb", ["diagnose", "refine", "train"])
def test_a_true_input_that_only_some_runs_record_is_not_taken_as_0_in_the_others(told, tmp_path, verb) -> None:
    known, bare = written(tmp_path / "a.csv", table().assign(reference_dph=9.66)), written(tmp_path / "b.csv", table())
    for files in (
        [f"data.files=[{known},{bare}]"],
        [f"data.files=[{bare},{known}]"],
        [f"data.files=[{known}]", f"data.check_files=[{bare}]"],
        [f"data.files=[{bare}]", f"data.check_files=[{known}]"],
    ):
        lacking, asked = told(*files, verb=verb).splitlines()
        assert re.search(r"\bb(\.csv| \(data\.\w+\)): does not record the true input, .*\ba(\.csv| \(data\.\w+\)) does \(reference_dph\)", lacking)
        assert "add the column" in asked
        assert "data.reference=… (°/h)" in asked


def test_a_true_input_that_was_given_is_meant_even_if_it_is_0(tmp_path, capsys) -> None:
    known = written(tmp_path / "a.csv", table().assign(reference_dph=0.001))
    bare = written(tmp_path / "b.csv", table().assign(rate_dph=1.1 * table()["rate_dph"]))
    short = ["model=polynomial", f"hydra.run.dir={tmp_path / 'out'}"]
    assert run("train", [f"data.files=[{known},{bare}]", *short, "data.reference=0"]) == 0
    assert run("train", [f"data.files=[{known}]", f"data.check_files=[{bare}]", *short, "data.reference=0.001"]) == 0
    assert run("train", [f"data.files=[{bare}]", *short]) == 0, "nor is it asked for where none records it"
    assert run("compare", [f"runs=[{tmp_path / 'out'}]", f"data.files=[{known},{bare}]", f"hydra.run.dir={tmp_path / 'compared'}"]) == 2
    assert "b.csv: does not record the true input" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("spoilt", "words"),
    [
        ({"time_s": "Time_S"}, "did you mean Time_S? then say data.columns.time=Time_S"),
        ({"temperature_c": "temp"}, "did you mean temp? then say data.columns.temperature=temp"),
        ({"rate_dph": "Rate_DPH"}, "say which one it is: data.columns.output=Rate_DPH"),
        ({"temperature_c": "temperature_outer_c"}, "if another one holds the temperature: data.columns.temperature=NAME"),
        ({"time_s": "# time_s"}, "row 1 begins with #"),
    ],
)
def test_a_name_that_is_nearly_that_of_a_column(refused, tmp_path, spoilt, words) -> None:
    assert words in refused(written(tmp_path / "a.csv", table().rename(columns=spoilt)))


@pytest.mark.parametrize("mapped", [[], ["data.columns.time=t"]])
def test_a_comment_before_the_header(refused, tmp_path, mapped) -> None:
    path = written(tmp_path / "a.csv", table())
    path.write_text(f"# our laboratory, 2026\n{path.read_text()}")
    assert "row 1 begins with #: the header with the columns' names must be the first line" in refused(path, *mapped)


def test_a_feature_that_is_nearly_a_column(refused, tmp_path) -> None:
    path = written(tmp_path / "a.csv", table())
    told = refused(path, "model.features=[temprature]", verb="train")
    assert "needs the column temprature; did you mean temperature_c? The file has time_s, temperature_c" in told
    assert "reference_dph" not in told, "which it has not"
    assert "did you mean" not in refused(path, "model.features=[supply_v]", verb="train")
    known = written(tmp_path / "b.csv", table().assign(reference_dph=0.0))
    assert "reference_dph" in refused(known, "model.features=[supply_v]", verb="train")
    assert run("train", [f"data.files=[{path}]", "model=polynomial", "model.features=[temperature_c]", f"hydra.run.dir={tmp_path / 'out'}"]) == 0


@pytest.mark.parametrize(
    ("flag", "words"),
    [
        (["--files", "x"], "settings are given without dashes: data.files=… (files as [a.csv,b.csv])"),
        (["--data.check_files=x"], "settings are given without dashes: data.check_files=…"),
        (["--torch-device=cuda"], "settings are given without dashes: torch_device=…"),
        (["--verison"], "did you mean --version"),
    ],
)
def test_a_setting_with_dashes(told, flag, words) -> None:
    assert words in told(*flag)


def test_nothing_hidden_is_a_number(told) -> None:
    assert "hidden=0 hides nothing" in told("hidden=none", verb="simulate")


def test_a_folder_with_runs_and_a_check(told, tmp_path) -> None:
    (tmp_path / "lab").mkdir()
    written(tmp_path / "lab" / "a.csv", table())
    assert told(f"data.files=[{tmp_path / 'lab'}]").endswith("/lab/*.csv]\n")
    for name in ("run_1", "check", "truth_1"):
        written(tmp_path / "lab" / f"{name}.csv", table())
    assert "/lab/run_*.csv]; what is called check… belongs into data.check_files" in told(f"data.files=[{tmp_path / 'lab'}]")


# Cells


@pytest.mark.parametrize("verb", ["diagnose", "refine", "train"])
@pytest.mark.parametrize("cell", ["n/a", "nan", "inf", "-inf", ""])
def test_a_cell_that_is_no_finite_number(refused, tmp_path, cell, verb) -> None:
    message = refused(written(tmp_path / "a.csv", table(), (412, "rate_dph", cell)), verb=verb)
    assert "row 412, column rate_dph" in message
    assert cell in message


@pytest.mark.parametrize("value", ["110.0", "90.0", "-5"])
def test_a_time_that_does_not_increase(refused, tmp_path, value) -> None:
    message = refused(written(tmp_path / "a.csv", table(), (8, "time_s", value)))
    assert "row 8, column time_s" in message
    assert "must increase" in message


def test_an_output_that_never_changes(refused, tmp_path) -> None:
    message = refused(written(tmp_path / "a.csv", table().assign(rate_dph=0.25)))
    assert "rate_dph: is 0.25 in all 720 rows" in message


# Files


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.csv", b"", "empty"),
        ("a.csv", b"time_s,temperature_c,rate_dph\n", "a header and no rows"),
        ("a.csv", b"time_s,temperature_c,rate_dph\n1,20,3\n", "one row"),
        ("a.csv", bytes(range(256)) * 40, "binary"),
        ("a.csv", gzip.compress(b"time_s,temperature_c,rate_dph\n1,20,3\n", mtime=0), "binary"),
        ("a.csv.gz", b"time_s,temperature_c,rate_dph\n1,20,3\n", "cannot be read"),
        ("a.parquet", b"", "0 bytes"),
        ("a.parquet", b"PAR1 and then nothing", "parquet"),
        ("a.xlsx", b"PK", "possible: .csv, .csv.gz, .parquet"),
    ],
)
def test_a_file_that_is_no_recording(refused, tmp_path, name, content, words) -> None:
    (tmp_path / name).write_bytes(content)
    assert words in refused(tmp_path / name)


def test_files_that_are_not_there(told, tmp_path) -> None:
    written(tmp_path / "run_1.csv", table())
    assert "run_1.csv" in told(f"data.files=[{tmp_path / 'run_2.csv'}]"), "what is there instead"
    assert "no file matches" in told(f"data.files=[{tmp_path / 'chamber_*.csv'}]")
    assert "data.files" in told(), "nothing was asked for"
    assert "data.files is not set" in told("run=anywhere", verb="compensate")


def test_a_run_is_read_once_and_no_fitted_one_checks(told, tmp_path) -> None:
    path = written(tmp_path / "a.csv", table())
    again = tmp_path / "nowhere" / ".." / "a.csv"
    again.parent.parent.mkdir()
    for files in (f"{path},{path}", f"{path},{again}", f"{path},{tmp_path}/*.csv"):
        assert "a.csv: is named twice" in told(f"data.files=[{files}]")
    for checks in (path, again, tmp_path / "*.csv"):
        assert "a.csv is in data.files too" in told(f"data.files=[{path}]", f"data.check_files=[{checks}]")


@pytest.mark.parametrize("check", [False, True])
def test_a_recording_under_two_names_is_told(tmp_path, capsys, check) -> None:
    paths = [written(tmp_path / f"{name}.csv", table()) for name in ("a", "copy")]
    files = [f"data.files=[{paths[0]}]", f"data.check_files=[{paths[1]}]"] if check else [f"data.files=[{paths[0]},{paths[1]}]"]
    for copied in (True, False):
        assert run("train", ["model=polynomial", *files, f"hydra.run.dir={tmp_path / 'out'}"]) == 2 * copied
        assert ("copy: the same recording as a; leave one of them out" in capsys.readouterr().err) is copied
        for path, sign in zip(paths, (1, -1), strict=True):  # of a gyro without noise, at another supply
            written(path, table().assign(supply_v=5.0 + sign * table()["rate_dph"]))


# What runs cannot tell


def test_a_constant_temperature_names_what_it_leaves_undetermined(refused, tmp_path) -> None:
    message = refused(written(tmp_path / "a.csv", table(swing=0.0)))
    assert "temperature_c is constant" in message
    assert all(name in message for name in ("shupe", "mohr")), "the effects of the rate"
    assert "ramps by 5 K" in message, "what to record instead"


def test_a_swing_too_small_to_fit(refused, tmp_path) -> None:
    message = refused(written(tmp_path / "a.csv", table(swing=3.0)))
    assert "moves by 3.00 K only" in message
    assert "at least 5 K" in message


def test_a_run_too_short_to_fit(refused, tmp_path) -> None:
    frame = table(rows=50).assign(temperature_c=np.linspace(20, 40, 50))
    message = refused(written(tmp_path / "a.csv", frame), "data.average_s=20")
    assert "at least 60" in message
    assert "data.average_s" in message


def test_a_run_too_short_to_keep_pieces_apart(refused, tmp_path) -> None:
    """Of ten pieces of three means one in the middle holds none of them."""
    message = refused(written(tmp_path / "a.csv", table(rows=540)), "data.average_s=3600", "data.holdout=0.1")
    assert "data.holdout=0.1: 3 means a run are too few" in message


def test_a_name_of_a_file_may_refer_to_the_environment(told, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("HERE", str(tmp_path))
    written(tmp_path / "a.csv", table())
    asked = "${oc.env:HERE}/a.csv"
    assert "a.csv is in data.files too" in told(f"data.files=['{asked}']", f"data.check_files=['{asked}']")


# Settings


@pytest.mark.parametrize(
    ("verb", "more", "near"),
    [
        ("diagnose", ["effects=[static_bias,shuppe]"], "shupe"),
        ("diagnose", ["candidates=[histeresis]"], "hysteresis"),
        ("refine", ["add=polarisation"], "polarization"),
        ("refine", ["add=[warm_up,agein]"], "aging"),
    ],
)
def test_an_unknown_effect_gets_the_nearest(told, tmp_path, verb, more, near) -> None:
    message = told(f"data.files=[{written(tmp_path / 'a.csv', table())}]", *more, verb=verb)
    assert f"did you mean {near}" in message
    assert "static_bias" in message, "all that is known"


def test_an_effect_that_is_there_already_or_lacks_its_column(told, tmp_path) -> None:
    files = f"data.files=[{written(tmp_path / 'a.csv', table())}]"
    assert "'mohr' is in the model already" in told(files, "add=mohr", verb="refine")
    assert "'magnetic' needs the column field_ut" in told(files, "add=magnetic", verb="refine")
    assert "'scale_factor' needs a reference that changes" in told(files, "add=[mohr,scale_factor]", "effects=[static_bias]", verb="refine")
    assert "needs the column supply_v" in told(files, "effects=[static_bias,supply_voltage]")
    assert "effects=[]" in told(files, "effects=[]")
    for model in ("hybrid", "graybox"):
        assert "effects=[]" in told(files, f"model={model}", "effects=[]", verb="train")


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("data.average_s=-5", "data.average_s"),
        ("data.average_s=soon", "auto"),
        ("data.average_s=1e6", "its 720 rows span 14380 s); choose a shorter data.average_s"),
        ("data.reference=north", "data.reference"),
        ("data.holdout=1.5", "data.holdout"),
        ("data.holdout=half", "data.holdout"),
        ("data.holdout=0.01", "from 0.05 to 0.95"),
        ("data.holdout=0.99", "from 0.05 to 0.95"),
        ("data.points=5", "data.points=5: null is possible"),
        ("data.points.where=reference_dhp>0", "data.points.where=reference_dhp>0"),
        ("data.points.checked=9999", "data.points.checked=9999: the runs have"),
        ("data.points.nearest=3", "data.points.nearest"),
        ("data.output_unit=rad/s", "'rate_dph' is in °/h by its name"),
        ("effects=[mohr,static_bias,mohr]", "mohr is there twice"),
        ("effects=null", "effects=null: possible: aging"),
        ("data=[files,qiu2023]", "-m data=files,qiu2023"),
        ("hydra.searchpath=[nowhere]", "hydra.searchpath: nowhere: no such folder"),
        ("data.gap_s=0", "data.gap_s"),
        ("data.columns.foo=rate_dph", "foo"),
    ],
)
@pytest.mark.filterwarnings("ignore:provider=hydra.searchpath")  # Hydra's own, before this project's error
def test_a_setting_that_makes_no_sense(told, tmp_path, setting, words) -> None:
    key = f"+{setting}" if "columns.foo" in setting else setting
    assert words in told(f"data.files=[{written(tmp_path / 'a.csv', table())}]", key)


@pytest.mark.parametrize(
    ("verb", "setting"),
    [
        ("diagnose", "candidates=5"),
        ("diagnose", "candidates=null"),
        ("refine", "add=5"),
        ("refine", "add=null"),
        ("diagnose", "data.holdout=null"),
        ("diagnose", "seed=-1"),
        ("refine", "seed=1.5"),
        ("diagnose", "data.files=5"),
        ("diagnose", "data.files=null"),
        ("diagnose", "data.check_files=5"),
        ("diagnose", "torch_device=null"),
        ("diagnose", "data.points.seed=99999999999999999999"),
        ("train", "model=null"),
        ("train", "init=null"),
        ("train", "optimizer=null"),
        ("train", "data=null"),
        ("train", "init.seed=x"),
        ("train", "seed=-1"),
        ("train", "seed=4294967296"),
        ("train", "model.smoothing_s=x"),
        ("train", "model.features=temperature"),
        ("train", "model.features=null"),
        ("simulate", "noise=null"),
        ("simulate", "gyro=null"),
        ("simulate", "profile=null"),
        ("compare", "seed=x"),
        ("compare", "seed=1.5"),
        ("compare", "predictions=5"),
        ("train", "resume=3"),
    ],
)
def test_a_setting_of_the_wrong_kind_is_named_and_no_type_error(told, tmp_path, verb, setting) -> None:
    files = [] if verb == "simulate" else [f"data.files=[{written(tmp_path / 'a.csv', table())}]"]
    message = told(*files, setting, verb=verb)
    assert message.removeprefix("error: ").startswith(setting.partition("=")[0])
    assert "TypeError" not in message


@pytest.mark.parametrize(
    ("optimizer", "setting", "words"),
    [
        ("auto", "optimizer.lr=-1", "optimizer.lr=-1: Adam refuses"),
        ("adam", "optimizer.lr=abc", "optimizer.lr=abc: Adam refuses"),
        ("sgd", "optimizer.lr=nan", "optimizer.lr=nan"),
        ("sgd", "optimizer.momentum=null", "optimizer.momentum=None"),
        ("lbfgs", "optimizer.lr=null", "optimizer.lr=None"),
        ("lbfgs", "optimizer.history_size=x", "optimizer.history_size=x"),
        ("lbfgs", "optimizer.line_search_fn=x", "only 'strong_wolfe' is supported"),
        ("adam", "+optimizer.nix=3", "unexpected keyword argument 'nix'"),
        ("adam", "+optimizer.capturable=true", "capturable=True"),
    ],
)
def test_what_torchs_optimizer_does_not_take_is_said_before_the_training(told, tmp_path, optimizer, setting, words) -> None:
    assert words in told(f"data.files=[{written(tmp_path / 'a.csv', table())}]", f"optimizer={optimizer}", setting, verb="train")


@pytest.mark.filterwarnings("ignore:provider=hydra.searchpath")
def test_a_name_from_a_search_path_that_is_not_there_is_not_called_unknown(told, tmp_path) -> None:
    files, path = f"data.files=[{written(tmp_path / 'a.csv', table())}]", "hydra.searchpath=[file:///nope/conf]"
    for setting in ("effects=[static_bias,mine]", "model=mine"):
        assert "hydra.searchpath: /nope/conf: no such folder" in told(files, setting, path, verb="train")


def test_a_list_of_models_is_no_model_and_one_in_brackets_is(told, tmp_path) -> None:
    files = f"data.files=[{written(tmp_path / 'a.csv', table())}]"
    assert "for a command with each: -m model=polynomial,wavelet" in told(files, "model=[polynomial,wavelet]", verb="train")
    assert "model=[]" in told(files, "model=[]", verb="train")
    assert run("train", [files, "model=[polynomial]", f"hydra.run.dir={tmp_path / 'one'}"]) == 0


def test_values_with_commas_between_them_are_a_list_or_a_sweep(told) -> None:
    assert "runs=a,b: one list is 'runs=[a,b]'; a job for each is -m runs=a,b" in told("runs=a,b", "data.files=[c.csv]", verb="compare")


@pytest.mark.parametrize("files", ["[a.csv,b.csv", "[a.csv]]"])
def test_a_bracket_too_few_or_too_many_is_said(told, files) -> None:
    assert f"data.files={files}: a bracket is open, or one too many closed" in told(f"data.files={files}")


def test_one_candidate_needs_no_brackets(tmp_path) -> None:
    path = written(tmp_path / "a.csv", table())
    assert run("diagnose", [f"data.files=[{path}]", "candidates=warm_up", f"hydra.run.dir={tmp_path / 'out'}"]) == 0


@pytest.mark.parametrize("verb", ["diagnose", "refine"])
@pytest.mark.parametrize("folder", ["file", "file/below", "/proc/nobody/writes/here"])
def test_an_output_folder_that_cannot_be_written(tmp_path, capsys, verb, folder) -> None:
    (tmp_path / "file").write_text("kept")
    path = written(tmp_path / "a.csv", table())
    assert run(verb, [f"data.files=[{path}]", f"hydra.run.dir={folder}"]) == 2
    error = capsys.readouterr().err
    assert 1 <= len(error.strip().splitlines()) <= 2
    assert ("/proc/nobody" if folder.startswith("/proc") else folder) in error
    assert "another folder" in error
    assert "Traceback" not in error
    assert (tmp_path / "file").read_text() == "kept"
    assert sorted(one.name for one in tmp_path.iterdir()) == ["a.csv", "file"]


# As the shell sees it


@pytest.mark.parametrize("door", [["-c", "from zoo.cli import main; main()"], [str(Path(__file__).resolve().parents[2] / "scripts" / "diagnose.py")]])
def test_the_shell_gets_the_code_and_the_message_on_the_standard_error(tmp_path, door) -> None:
    path = written(tmp_path / "a.csv", table(), (9, "temperature_c", "warm"))
    if not door[0].startswith("-") and not Path(door[0]).is_file():
        pytest.skip("no scripts folder: this is no checkout")
    verb = ["diagnose"] if door[0] == "-c" else []
    environment = {key: value for key, value in os.environ.items() if key != "HYDRA_FULL_ERROR"}
    command = [sys.executable, *door, *verb, f"data.files=[{path}]", f"hydra.run.dir={tmp_path / 'out'}"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    assert done.returncode == 2
    assert done.stderr.strip() == f"error: {path}, row 9, column temperature_c: 'warm' is not a finite number"
    assert done.stdout == ""


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["+parameter.mohr.coefficient=0.12"], "there is no setting 'parameter'; did you mean parameters"),
        (["+foo=1"], "there is no setting 'foo'"),
        (["+gyro.effects.mor=1"], "gyro.effects.mor: did you mean mohr"),
        (["gyro.layres=12"], "gyro.layres"),
        (["gyro.conductivity=-1"], "gyro.conductivity=-1: a number from 0"),
        (["gyro.layers=0"], "gyro.layers=0"),
        (["gyro.pattern=spiral"], "gyro.pattern=spiral"),
        (["gyro.diameter_m=1e300"], "gyro.diameter_m=1e+300"),
        (["gyro.diameter_m=0.005"], "diameter"),
        (["noise.rate_ramp=1e308"], "would not be finite"),
        (["pictures=perhaps"], "pictures=perhaps"),
        (["devices=0"], "devices=0"),
        (["devices=2", "seed=4294967295"], "the last of 2 devices would have one above 4294967295"),
        (["heat=3d"], "heat=3d"),
        (["sample_s=1e6"], "longer than a run"),
        (["thermometers=[roof]"], "thermometers"),
        (["latitude_deg=100"], "latitude_deg=100"),
        (["chamber.lag_s=-1"], "chamber.lag_s=-1"),
        (["profile=legs", "profile.legs=[[20,-300,100]]"], "absolute zero"),
        (["profile=cycle", "profile.k_per_min=abc"], "profile.k_per_min=abc"),
        (["profile=cycle", "profile.cycles=1.5"], "profile.cycles=1.5"),
        (["profile=multirate", "profile.stops=[[50,fast,100]]"], "fast"),
    ],
)
def test_what_no_gyro_or_chamber_can_be(told, settings, words) -> None:
    assert words in told(*settings, verb="simulate")


@pytest.mark.parametrize(
    ("verb", "setting", "words"),
    [
        ("diagnose", "files=a.csv", "did you mean data.files?"),
        ("compare", "run=outputs", "did you mean runs?"),
        ("train", "sweep.dir=outputs", "did you mean hydra.sweep?"),
        ("diagnose", "data.fils=a.csv", "data has no fils; did you mean files"),
        ("train", "model.hiden=3", "model has no hiden; did you mean hidden"),
        ("train", "optmizer.lr=3", "did you mean optimizer"),
        ("export", "model=a", "nown: hydra, program, refuse_outside, run"),
        ("simulate", "seed.first=3", "seed is a value and has no keys"),
    ],
)
def test_a_key_that_is_not_there_is_answered_with_those_that_are(told, verb, setting, words) -> None:
    answer = told(setting, verb=verb)
    assert f"unknown key '{setting.partition('=')[0]}'" in answer
    assert words in answer
