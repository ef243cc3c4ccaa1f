"""`fogzoo … | head`: who reads leaves early; nothing is said, the exit code is the shell's, and the results are whole."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from zoo.cli import application
from zoo.cli.closed_pipe import CLOSED_PIPE

SMALL = ["runs=1", "profile=cycle", "profile.hold_s=1800", "sample_s=30", "hydra.run.dir=runs"]


def unread(folder: Path, *arguments: str) -> tuple[int, str]:
    """Exit code and standard error of a command whose output nobody reads, from before its first line."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-c", "from zoo.cli import main; main()", *arguments]
    buffered = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"}
    try:
        done = subprocess.run(command, cwd=folder, env=buffered, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    finally:
        os.close(writer)
    return done.returncode, done.stderr


def test_the_code_is_that_of_the_signal() -> None:
    signal = pytest.importorskip("signal")
    assert 128 + signal.SIGPIPE == CLOSED_PIPE


def test_a_table_that_nobody_reads(tmp_path) -> None:
    assert unread(tmp_path, "simulate", *SMALL) == (CLOSED_PIPE, "")
    assert {"run_1.csv", "check.csv", "truth.json"} <= {path.name for path in (tmp_path / "runs").iterdir()}


@pytest.mark.parametrize("flags", [["--help"], ["--cfg", "job", "-p", "noise"]], ids=" ".join)
def test_help_that_nobody_reads(tmp_path, flags) -> None:
    assert unread(tmp_path, "simulate", *flags) == (CLOSED_PIPE, "")


def test_a_sweep_goes_on_unread(tmp_path) -> None:
    assert unread(tmp_path, "simulate", "-m", *SMALL[:-1], "seed=1,2", "hydra.sweep.dir=sweep") == (CLOSED_PIPE, "")
    assert (tmp_path / "sweep" / "1" / "truth.json").is_file()


def test_a_comparison_that_nobody_reads_is_written_all_the_same(tmp_path) -> None:
    assert application.run("simulate", SMALL) == 0
    files = "data.files=[runs/run_1.csv]"
    assert application.run("train", ["model=polynomial", files, "hydra.run.dir=model"]) == 0
    assert unread(tmp_path, "compare", "runs=[model]", files, "hydra.run.dir=out") == (CLOSED_PIPE, "")
    assert (tmp_path / "out" / "comparison.csv").is_file()
