"""Where results go: a folder for every command, and none for a command without a result."""

from __future__ import annotations

import logging
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from zoo.cli import application

SMALL = ["runs=1", "profile=legs", "profile.legs=[[20,20,600],[20,30,600]]", "sample_s=30"]


def taken(top: str) -> None:
    """Folders of another process for every second of the next minutes."""
    for second in range(300):
        Path(top, (datetime.now() + timedelta(seconds=second)).strftime("%Y-%m-%d/%H-%M-%S")).mkdir(parents=True)


def results() -> list[str]:
    return sorted(path.parent.as_posix() for path in Path().rglob("truth.json"))


def test_two_commands_of_one_second_have_two_folders() -> None:
    taken("outputs/simulate")
    assert application.run("simulate", SMALL) == 0
    (found,) = results()
    assert found.endswith("-2")
    assert len(Path(found).name) == len("10-02-57-2")


def test_two_sweeps_of_one_second_have_two_folders() -> None:
    taken("outputs/simulate/multirun")
    assert application.run("simulate", ["-m", *SMALL, "seed=1,2"]) == 0
    assert [Path(path).name for path in results()] == ["0", "1"]
    (sweep,) = {Path(path).parent for path in results()}
    assert sweep.name.endswith("-2")
    assert (sweep / "multirun.yaml").is_file()


def test_a_folder_that_the_user_names_is_used_again() -> None:
    for seed in (1, 2):
        assert application.run("simulate", [*SMALL, f"seed={seed}", "hydra.run.dir=mine"]) == 0
    assert results() == ["mine"]
    assert application.run("simulate", ["-m", *SMALL, "seed=1,2", "hydra.sweep.dir=mine"]) == 0
    assert results() == ["mine", "mine/0", "mine/1"]


def test_no_log_where_there_is_nothing_to_say() -> None:
    assert application.run("simulate", [*SMALL, "hydra.run.dir=mine"]) == 0
    assert not list(Path("mine").rglob("*.log"))
    logging.getLogger("somebody").warning("after it all")
    assert not list(Path("mine").rglob("*.log"))


@pytest.mark.parametrize(
    ("verb", "arguments"),
    [
        ("simulate", ["seed=-1"]),
        ("simulate", ["seed=-1", "hydra.run.dir=deep/below"]),
        ("simulate", ["-m", "seed=-1,-2"]),
        ("simulate", ["-m", "seed=-1,-2", "hydra.sweep.dir=deep/below"]),
        ("simulate", ["-m", "sed=1,2"]),
        ("simulate", ["effects=[mohr,mohr]"]),
        ("diagnose", []),
        ("export", []),
    ],
)
def test_a_command_without_a_result_leaves_no_folder(verb, arguments) -> None:
    assert application.run(verb, arguments) != 0
    assert not list(Path.cwd().iterdir())


def test_what_was_there_before_stays() -> None:
    Path("outputs/simulate/notes").mkdir(parents=True)
    Path("mine").mkdir()
    assert application.run("simulate", ["seed=-1"]) == 2
    assert application.run("simulate", ["seed=-1", "hydra.run.dir=mine"]) == 2
    assert sorted(path.as_posix() for path in Path().rglob("*") if ".hydra" not in path.parts) == [
        "mine",
        "outputs",
        "outputs/simulate",
        "outputs/simulate/notes",
    ]


def test_a_job_that_fails_leaves_a_note_where_others_have_results() -> None:
    assert application.run("simulate", ["-m", *SMALL, "seed=-1,2", "hydra.sweep.dir=sweep"]) == 2
    assert sorted(path.name for path in Path("sweep").iterdir()) == ["0", "1", "multirun.yaml"]
    assert "seed=-1" in Path("sweep/0/failed.txt").read_text()
    assert not Path("sweep/1/failed.txt").exists()


def test_a_sweep_of_failures_leaves_no_folder() -> None:
    assert application.run("simulate", ["-m", *SMALL, "seed=-1,-2", "hydra.sweep.dir=deep/sweep"]) == 2
    assert not list(Path.cwd().iterdir())
