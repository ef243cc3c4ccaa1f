"""A training that is killed, as by a power cut, goes on where it was."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch

from zoo.catalog import load_model

pytestmark = pytest.mark.slow

PROGRAM = """
import sys
import zoo.training.checkpoints, zoo.training.stepwise
zoo.training.checkpoints.EVERY_S = zoo.training.stepwise.EVERY_S = 0.0
from zoo.cli.application import run
sys.exit(run("train", sys.argv[1:]))
"""
"""The command, with a checkpoint at every point of the curve."""


def begin(out: Path, recording: Path, more: list[str]) -> subprocess.Popen[str]:
    arguments = [*more, f"data.files=[{recording}]", "data.average_s=100", f"hydra.run.dir={out}"]
    command = [sys.executable, "-c", PROGRAM, *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | {"OMP_NUM_THREADS": "1"})


def end_after_a_checkpoint(process: subprocess.Popen[str], out: Path, by: signal.Signals) -> None:
    while not (out / "last.ckpt").is_file():
        assert process.poll() is None, process.communicate()
        time.sleep(0.005)
    os.kill(process.pid, by)


def record(folder: Path) -> Path:
    rows = [f"{20 * k},{20 + 30 * (k % 600) / 600:.4f},{0.2 * ((k % 600) / 300 - 1) ** 2:.6f}" for k in range(900)]
    recording = folder / "a.csv"
    recording.write_text("\n".join(["time_s,temperature_c,rate_dph", *rows]) + "\n")
    return recording


@pytest.mark.parametrize(
    "more",
    [["epochs=200"], ["epochs=40", "seeds=3", "batch_size=40", "init=pso", "init.steps=5"]],
    ids=["alone", "ensemble in batches"],
)
def test_the_same_command_ends_where_it_would_have(tmp_path, more) -> None:
    recording = record(tmp_path)
    for name in ("whole", "killed"):
        process = begin(tmp_path / name, recording, more)
        if name == "killed":
            end_after_a_checkpoint(process, tmp_path / name, signal.SIGKILL)
            process.wait()
            left = {path.name for path in (tmp_path / name).iterdir()}
            assert not left & {"metrics.json", "weights.pt", "members.pt", "model.yaml"}
            assert torch.load(tmp_path / name / "last.ckpt", weights_only=True)["finished"] is False
            process = begin(tmp_path / name, recording, more)
        printed, errors = process.communicate(timeout=120)
        assert process.returncode == 0, errors
        assert ("going on from" in printed) == (name == "killed")
    whole, killed = (json.loads((tmp_path / name / "metrics.json").read_text()) for name in ("whole", "killed"))
    for key in ("rms", "epochs", "evaluations", "loss", "members"):
        assert killed.get(key) == whole.get(key)
    one, other = (load_model(tmp_path / name).state_dict() for name in ("whole", "killed"))
    assert all(torch.equal(one[key], other[key]) for key in one)
    assert not list((tmp_path / "killed").glob(".*.part"))


STEADY = ["optimizer=levenberg_marquardt", "optimizer.settled=0", "seeds=20", "model.hidden=12"]


@pytest.mark.parametrize("more", [[], STEADY], ids=["adam", "levenberg_marquardt"])
def test_an_end_at_a_time_limit_is_told_and_leaves_a_checkpoint(tmp_path, more) -> None:
    recording, out = record(tmp_path), tmp_path / "out"
    process = begin(out, recording, ["epochs=100000", *more])
    end_after_a_checkpoint(process, out, signal.SIGTERM)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "time limit" in errors
    assert "Traceback" not in errors
    assert not (out / "metrics.json").exists()
    assert torch.load(out / "last.ckpt", weights_only=True)["finished"] is False


ONE_BY_ONE = ["optimizer=lbfgs", "seeds=3"]
"""Seeds whose steps depend on all weights of one: they are trained one after another."""


def test_seeds_that_are_trained_one_after_another_begin_again_after_a_kill(tmp_path) -> None:
    """The checkpoint is that of one of them, from which the command cannot go on."""
    recording, out = record(tmp_path), tmp_path / "out"
    command = [*ONE_BY_ONE, "epochs=150"]
    process = begin(out, recording, command)
    end_after_a_checkpoint(process, out, signal.SIGKILL)
    process.wait()
    printed, errors = begin(out, recording, command).communicate(timeout=120)
    assert "going on from" not in printed
    assert json.loads((out / "metrics.json").read_text())["members"]["seeds"] == [1, 2, 3], errors


def test_a_time_limit_ends_all_seeds_and_not_one(tmp_path) -> None:
    recording, out = record(tmp_path), tmp_path / "out"
    process = begin(out, recording, [*ONE_BY_ONE, "epochs=5000"])
    end_after_a_checkpoint(process, out, signal.SIGTERM)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "time limit" in errors
    assert not (out / "metrics.json").exists()
