"""A training that is killed, as by a power cut, goes on where it was."""

from __future__ import annotations

import json
import os
import signal
import time
from pathlib import Path

import pytest
import torch

from zoo.catalog import load_model

pytestmark = pytest.mark.slow

AT_EVERY_POINT = """
import zoo.training.checkpoints, zoo.training.stepwise
zoo.training.checkpoints.EVERY_S = zoo.training.stepwise.EVERY_S = 0.0
"""
"""Makes it leave a checkpoint at every point of the curve."""


@pytest.fixture
def begin(command, tmp_path):
    """Begins a training."""
    recording = record(tmp_path)

    def begin(out: Path, more: list[str]):
        return command("train", *more, f"data.files=[{recording}]", "data.average_s=100", f"hydra.run.dir={out}", first=AT_EVERY_POINT)

    return begin


def end_after_a_checkpoint(process, out: Path, by: signal.Signals) -> tuple[int, str, str]:
    while not (out / "last.ckpt").is_file():
        assert not process.is_over, process.end()
        time.sleep(0.005)
    os.kill(process.pid, by)
    return process.end()


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
def test_the_same_command_ends_where_it_would_have(begin, tmp_path, more) -> None:
    for name in ("whole", "killed"):
        process = begin(tmp_path / name, more)
        if name == "killed":
            end_after_a_checkpoint(process, tmp_path / name, signal.SIGKILL)
            left = {path.name for path in (tmp_path / name).iterdir()}
            assert not left & {"metrics.json", "weights.pt", "members.pt", "model.yaml"}
            assert torch.load(tmp_path / name / "last.ckpt", weights_only=True)["finished"] is False
            process = begin(tmp_path / name, more)
        code, printed, errors = process.end()
        assert code == 0, errors
        assert ("going on from" in printed) == (name == "killed")
    whole, killed = (json.loads((tmp_path / name / "metrics.json").read_text()) for name in ("whole", "killed"))
    for key in ("rms", "epochs", "evaluations", "loss", "members"):
        assert killed.get(key) == whole.get(key)
    one, other = (load_model(tmp_path / name).state_dict() for name in ("whole", "killed"))
    assert all(torch.equal(one[key], other[key]) for key in one)
    assert not list((tmp_path / "killed").glob(".*.part"))


STEADY = ["optimizer=levenberg_marquardt", "optimizer.settled=0", "seeds=20", "model.hidden=12"]


@pytest.mark.parametrize("more", [[], STEADY], ids=["adam", "levenberg_marquardt"])
def test_an_end_at_a_time_limit_is_told_and_leaves_a_checkpoint(begin, tmp_path, more) -> None:
    out = tmp_path / "out"
    code, _, errors = end_after_a_checkpoint(begin(out, ["epochs=100000", *more]), out, signal.SIGTERM)
    assert code == 1
    assert "time limit" in errors
    assert "Traceback" not in errors
    assert not (out / "metrics.json").exists()
    assert torch.load(out / "last.ckpt", weights_only=True)["finished"] is False


ONE_BY_ONE = ["optimizer=lbfgs", "seeds=3"]
"""Seeds whose steps depend on all weights of one: they are trained one after another."""


def test_seeds_that_are_trained_one_after_another_begin_again_after_a_kill(begin, tmp_path) -> None:
    """The checkpoint is that of one of them, from which the command cannot go on."""
    out, typed = tmp_path / "out", [*ONE_BY_ONE, "epochs=150"]
    end_after_a_checkpoint(begin(out, typed), out, signal.SIGKILL)
    _, printed, errors = begin(out, typed).end()
    assert "going on from" not in printed
    assert json.loads((out / "metrics.json").read_text())["members"]["seeds"] == [1, 2, 3], errors


def test_a_time_limit_ends_all_seeds_and_not_one(begin, tmp_path) -> None:
    out = tmp_path / "out"
    code, _, errors = end_after_a_checkpoint(begin(out, [*ONE_BY_ONE, "epochs=5000"]), out, signal.SIGTERM)
    assert code == 1
    assert "time limit" in errors
    assert not (out / "metrics.json").exists()
