"""Ctrl-C at any time: one line, exit code 130, nothing left behind."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from zoo.cli import application
from zoo.cli.interrupts import INTERRUPTED, MESSAGE
from zoo.training.module import Training

EAGER = """
import os, signal, sys

class Interrupted:
    def find_spec(self, name, *rest):
        if name == sys.argv[1]:
            try:
                os.kill(os.getpid(), signal.SIGINT)
                sum(range(1000))  # the handler runs here
            except KeyboardInterrupt:
                if sys.argv[2] == "lost":
                    return None  # as in an extension that asks for another module
                raise

sys.meta_path.insert(0, Interrupted())
from zoo.cli import run

sys.exit(run("simulate", ["runs=1"]))
"""


@pytest.fixture
def files() -> str:
    time = np.arange(0, 4 * 3600, 20.0)
    columns = np.column_stack([time, 20 + 20 * np.sin(time / 2000), np.random.default_rng(1).normal(size=len(time))])
    np.savetxt("a.csv", columns, "%.6f", ",", header="time_s,temperature_c,rate_dph", comments="")
    return "data.files=[a.csv]"


@pytest.fixture
def interrupted(monkeypatch) -> list[int]:
    """Training steps, the third of which is interrupted."""
    steps: list[int] = []
    usual = Training.training_step

    def step(self, batch, index):
        steps.append(index)
        if len(steps) == 3:
            raise KeyboardInterrupt
        return usual(self, batch, index)

    monkeypatch.setattr(Training, "training_step", step)
    return steps


@pytest.mark.parametrize("how", ["raised", "lost"])
@pytest.mark.parametrize("module", ["zoo.cli.application", "torch", "hydra"])
def test_while_the_program_is_still_imported(tmp_path, module, how) -> None:
    done = subprocess.run([sys.executable, "-c", EAGER, module, how], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.strip(), done.stdout) == (INTERRUPTED, MESSAGE, "")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("where", [[], ["hydra.run.dir=out"]])
def test_in_a_training(files, interrupted, capsys, where) -> None:
    """Lightning would make it an exit with code 1, and has the process ignore further ones meanwhile."""
    before = signal.getsignal(signal.SIGINT)
    assert application.run("train", [files, "model=bp", *where]) == INTERRUPTED
    assert capsys.readouterr().err.strip() == MESSAGE
    assert len(interrupted) == 3
    assert signal.getsignal(signal.SIGINT) is before
    assert [path.name for path in Path.cwd().iterdir()] == ["a.csv"]


def test_in_a_sweep_that_then_stops(files, interrupted, capsys) -> None:
    assert application.run("train", ["-m", files, "model=bp,polynomial"]) == INTERRUPTED
    assert capsys.readouterr().err.strip() == MESSAGE
    assert [path.name for path in Path.cwd().iterdir()] == ["a.csv"]


def test_in_a_sweep_whose_first_job_is_done(files, interrupted, capsys) -> None:
    assert application.run("train", ["-m", files, "model=polynomial,bp", "hydra.sweep.dir=sweep"]) == INTERRUPTED
    assert capsys.readouterr().err.splitlines() == ["the same command runs what is missing and nothing twice", MESSAGE]
    assert (Path("sweep") / "0" / "metrics.json").is_file()
    assert not (Path("sweep") / "1").exists()
