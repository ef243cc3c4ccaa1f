"""Sweeps: what is finished is not done again, what fails costs the others nothing, one table at the end."""

from __future__ import annotations

import csv
import json
import os
import shlex
import threading
from pathlib import Path

import numpy as np
import pytest

import zoo
from zoo.cli import alone, application
from zoo.cli.jobs import objective
from zoo.cli.outcomes import FAILED, Outcome, read_outcomes
from zoo.cli.sweep_tables import sweep_table
from zoo.errors import WorkError

SETTINGS = ["data.files=[a.csv]", "data.check_files=[b.csv]", "data.average_s=100", "epochs=5"]
SWEEP = ["-m", *SETTINGS, "hydra.sweep.dir=sweep"]


@pytest.fixture(autouse=True)
def _recordings() -> None:
    """Two runs of an error that bends with the temperature."""
    time = np.arange(0, 4 * 3600, 20.0)
    for name, seed in (("a", 1), ("b", 2)):
        temperature = 40 + 20 * np.sin(time / 2000 + seed)
        error = 0.2 * np.tanh((temperature - 35) / 8) + 0.01 * np.random.default_rng(seed).normal(size=len(time))
        columns = np.column_stack([time, temperature, error])
        np.savetxt(f"{name}.csv", columns, "%.6f", ",", header="time_s,temperature_c,rate_dph", comments="")


def train(*more: str) -> int:
    return application.run("train", [*SWEEP, *more])


def rms(job: str) -> float:
    return float(json.loads(Path("sweep", job, "metrics.json").read_text())["rms"])


def stamps() -> dict[str, int]:
    return {path.parent.name: path.stat().st_mtime_ns for path in Path("sweep").glob("*/metrics.json")}


def rows() -> list[dict[str, str]]:
    with Path("sweep/sweep.csv").open() as file:
        return list(csv.DictReader(file))


def test_what_is_finished_is_not_done_again(capsys) -> None:
    """As typed in the README: seed=range(2) is 0 and 1."""
    typed = ["model=polynomial,bp", "seed=range(2)"]
    assert train(*typed) == 0
    assert [json.loads(Path("sweep", job, "metrics.json").read_text())["seed"] for job in "0123"] == [0, 1, 0, 1]
    before, lost = stamps(), rms("3")
    Path("sweep/3/metrics.json").unlink()
    capsys.readouterr()
    assert train(*typed) == 0
    printed = capsys.readouterr().out
    assert {job for job, stamp in stamps().items() if stamp != before[job]} == {"3"}
    assert rms("3") == lost
    assert printed.count("finished by an earlier sweep") == 3
    assert "(3 done before)" in printed
    assert printed.splitlines()[-1] == str(Path("sweep/sweep.csv").absolute())


@pytest.mark.parametrize("changed", ["settings", "files", "version", "killed"])
def test_what_another_result_may_come_of_is_done_again(changed, monkeypatch) -> None:
    assert train("model=polynomial", "seed=1,2") == 0
    before = stamps()
    if changed == "files":
        Path("a.csv").write_text(Path("a.csv").read_text() + "14400.0,40.0,0.1\n")
    if changed == "version":
        monkeypatch.setattr(zoo, "__version__", "0.0.0")
    if changed == "killed":  # while it did it once more, by other settings
        for folder, found in read_outcomes(Path("sweep"), json.loads(Path("sweep/0/.hydra/outcome.json").read_text())["sweep"]).items():
            Outcome(found.sweep, found.overrides, found.made_from).write(folder)
    assert train("model=polynomial", "seed=1,2", *(["model.order=2"] if changed == "settings" else [])) == 0
    assert all(stamp != before[job] for job, stamp in stamps().items())


def test_what_another_sweep_has_left_in_the_folder_is_told(capsys) -> None:
    assert train("model=polynomial", "model.order=1,2,3") == 0
    assert "earlier sweep" not in capsys.readouterr().err
    assert train("model=polynomial", "model.order=1,3") == 0  # 1 again, 3 in the place of 2, and what is left of the three
    told = " ".join(capsys.readouterr().err.split())
    assert "1 job of an earlier sweep in this folder was replaced, such as 1 (data.files=[a.csv]" in told
    assert "model.order=2)" in told
    assert "1 job of an earlier sweep was left in this folder, such as 2: compare takes them as well" in told
    assert train("model=polynomial", "model.order=1,3") == 0
    assert "replaced" not in capsys.readouterr().err


def test_a_command_alone_is_done_as_often_as_it_is_typed() -> None:
    for _ in range(2):
        before = stamps()
        assert application.run("train", [*SETTINGS, "model=polynomial", "hydra.run.dir=sweep/0"]) == 0
        assert stamps() != before


def test_jobs_of_one_process_end_as_they_would_alone() -> None:
    assert train("model=bp,wavelet", "init=random,pso", "init.seed=1,2") == 0
    assert application.run("train", [*SETTINGS, "model=wavelet", "init=pso", "init.seed=2", "hydra.run.dir=alone"]) == 0
    assert json.loads(Path("alone/metrics.json").read_text())["rms"] == rms("7")


def test_a_failed_job_is_told_noted_and_left_out_of_the_comparison(capsys) -> None:
    """The wrong one goes first; the command that is printed compares the others on the check runs."""
    assert train("model=polynomial", "model.order=-1,1,2") == 2
    told = capsys.readouterr()
    assert "1 of 3 jobs failed" in told.err
    assert "order" in Path("sweep/0", FAILED).read_text()
    assert [row["model.order"] for row in rows()] == ["2", "1"]  # the best first
    line = next(line for line in told.out.splitlines() if line.strip().startswith("fogzoo compare"))
    assert application.run("compare", [*shlex.split(line)[2:], "hydra.run.dir=compared"]) == 0
    document = json.loads(Path("compared/comparison.json").read_text())
    assert (len(document["models"]), [run["run"] for run in document["runs"]]) == (2, ["b"])
    assert document["skipped"] == ["sweep/0"]


def test_a_job_that_fails_where_another_had_succeeded_has_no_model_to_compare() -> None:
    assert train("model=polynomial", "model.order=1,2") == 0
    assert train("model=polynomial", "model.order=1,-1") == 2
    assert application.run("compare", ["runs=sweep", "data.files=[b.csv]", "hydra.run.dir=compared"]) == 0
    document = json.loads(Path("compared/comparison.json").read_text())
    assert document["skipped"] == ["sweep/1"]
    assert len(document["models"]) == 1
    assert train("model=polynomial", "model.order=1,2") == 0
    assert not Path("sweep/1", FAILED).exists()


def test_failures_that_nobody_foresaw_leave_a_trace_in_the_note_only(monkeypatch, capsys) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr("zoo.cli.train.read_data", broken)
    Path("sweep/0").mkdir(parents=True)
    Path("sweep/0/mine").touch()
    assert train("model=polynomial", "seed=1,2") == 1
    assert "Traceback" in Path("sweep/0", FAILED).read_text()
    message = capsys.readouterr().err
    assert "Traceback" not in message
    assert "the same command" in message


def metrics(values: list[float], check: list[float] | None, seconds: float, seed: int = 1) -> dict:
    """Of a training alone, or of an ensemble where there are several values."""
    members = {"seeds": [*range(seed, seed + len(values))], "rms": values, "rms_check": check, "rms_quantiles": {"median": float(np.median(values))}}
    members |= {"rms_check_quantiles": None if check is None else {"median": float(np.median(check))}}
    best = {"rms": min(values), "rms_check": None if check is None else check[0], "wall_time_s": seconds, "unit": "dph", "seed": seed}
    return best | ({"members": members} if len(values) > 1 else {})


def test_a_start_that_a_closed_form_has_no_use_for_is_not_compared() -> None:
    assert train("model=polynomial,bp", "init=random,pso", "init.seed=1") == 0
    assert [(row["model"], row["init"], row["n"]) for row in sorted(rows(), key=lambda row: (row["model"], row["init"]))] == [
        ("bp", "pso", "1"),
        ("bp", "random", "1"),
        ("polynomial", "–", "1"),
    ]
    assert application.run("compare", ["runs=[sweep]", "data.files=[b.csv]", "hydra.run.dir=compared"]) == 0
    compared = json.loads(Path("compared/comparison.json").read_text())
    assert {one["name"] for one in compared["methods"]} == {"bp_random", "bp_pso", "polynomial"}


def test_the_table_has_quantiles_over_all_seeds_of_equal_settings() -> None:
    values = np.random.default_rng(3).uniform(1, 2, (2, 40))
    alone_ = [({"model": "bp"}, metrics([a], [b], 2.0, seed)) for seed, (a, b) in enumerate(values[:, :20].T)]
    ensemble = ({"model": "bp"}, metrics(list(values[0, 20:]), list(values[1, 20:]), 5.0, seed=20))
    better = ({"model": "wavelet"}, metrics([3.0], [0.5], 7.0))
    table = sweep_table(*zip(*[*alone_, ensemble, better], strict=True))
    assert list(table["model"]) == ["wavelet", "bp"], "by the check runs"
    assert list(table["n"]) == [1, 40]
    for key, row in zip(("rms", "rms_check"), values, strict=True):
        low, middle, high = np.quantile(row, [0.05, 0.5, 0.95])
        assert (table[f"{key}_low"][1], table[f"{key}_median"][1], table[f"{key}_high"][1]) == pytest.approx((low, middle, high))
    assert table["wall_time_s"][1] == 2.0


def test_a_seed_that_two_ensembles_have_counts_once() -> None:
    some, others = metrics([1.0, 2.0, 3.0], None, 1.0, seed=1), metrics([2.0, 3.0, 4.0, 5.0], None, 1.0, seed=2)
    table = sweep_table([{"model": "bp"}] * 2, [some, others])
    assert list(table["n"]) == [5]
    assert list(table["rms_median"]) == [3.0]


def test_ensembles_that_share_seeds_are_one_method_with_each_seed_once() -> None:
    assert train("model=bp", "init=random", "seed=1,2", "seeds=3", "epochs=20") == 0
    assert [row["n"] for row in rows()] == ["4"]
    assert application.run("compare", ["runs=[sweep]", "data.files=[b.csv]", "hydra.run.dir=compared"]) == 0
    methods = json.loads(Path("compared/comparison.json").read_text())["methods"]
    assert [(one["name"], one["seeds"]) for one in methods] == [("bp", [1, 2, 3, 4])]


def test_without_check_runs_the_table_goes_by_the_fit() -> None:
    table = sweep_table([{"k": "1"}, {"k": "2"}], [metrics([2.0], None, 1.0), metrics([1.0], None, 1.0)])
    assert list(table["k"]) == ["2", "1"]
    assert "rms_check_median" not in table


def test_a_sweeper_gets_the_check_runs_where_there_are_any_and_the_median_of_several_seeds() -> None:
    assert objective(metrics([2.0], [3.0], 0), "auto") == 3
    assert objective(metrics([2.0], [3.0], 0), "rms") == 2
    assert objective(metrics([2.0], None, 0), "auto") == 2
    assert objective(metrics([2.0], None, 0), "rms_check") is None
    assert objective(metrics([1.0, 2.0, 9.0], [5.0, 7.0, 6.0], 0), "auto") == 6


def test_an_unknown_objective_is_refused_before_the_work(capsys) -> None:
    assert train("model=polynomial", "objective=loss") == 2
    assert "objective=loss: possible: auto, rms, rms_check" in capsys.readouterr().err


def test_a_folder_is_one_jobs_at_a_time(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(alone, "PATIENCE_S", 0.2)
    inside, over = threading.Event(), threading.Event()

    def other() -> None:
        with alone.alone_in(tmp_path):
            inside.set()
            over.wait(30)

    holder = threading.Thread(target=other)
    holder.start()
    inside.wait(30)
    with pytest.raises(WorkError, match="still at work"), alone.alone_in(tmp_path):
        pass
    over.set()
    holder.join()
    with alone.alone_in(tmp_path):
        assert os.listdir(tmp_path)  # noqa: PTH208


def test_only_what_a_sweep_names_is_its_own(tmp_path) -> None:
    for job, sweep in ((10, "new"), (9, "new"), (8, "old")):
        Outcome(sweep, ["seed=1"], "", code=0).write(tmp_path / str(job))
    (tmp_path / "7" / ".hydra").mkdir(parents=True)
    (tmp_path / "7" / ".hydra" / "outcome.json").write_text('{"sweep": "new", "over')
    assert [folder.name for folder in read_outcomes(tmp_path, "new")] == ["9", "10"]
