"""Launchers and sweepers that come in packages of their own: the same results from each, and a line where one is not installed."""

from __future__ import annotations

import csv
import dataclasses
import importlib
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hydra.core.plugins import Plugins
from omegaconf import OmegaConf

from zoo.catalog import config_folder
from zoo.cli import application
from zoo.cli.interrupts import MESSAGE
from zoo.cli.wrong_settings import check_choices, check_proposals

SCHEMAS = {
    "launcher/joblib": "hydra_joblib_launcher.config.JobLibLauncherConf",
    "launcher/submitit_local": "hydra_submitit_launcher.config.LocalQueueConf",
    "launcher/submitit_slurm": "hydra_submitit_launcher.config.SlurmQueueConf",
    "launcher/ray": "hydra_ray_launcher._config.RayLauncherConf",
    "sweeper/optuna": "hydra_optuna_sweeper.config.OptunaSweeperConf",
}
SWEEP = ["train", "-m", "data.files=[a.csv]", "data.average_s=100", "hydra.sweep.dir=sweep"]
TWO_FAIL = ["model=bp", "epochs=20,0", "seed=1,2"]
FOGZOO = [sys.executable, "-c", "from zoo.cli import main; main()"]


def needs(*plugins: str) -> None:
    for plugin in plugins:
        if importlib.util.find_spec("hydra_plugins") is None or importlib.util.find_spec(f"hydra_plugins.{plugin}") is None:
            pytest.skip(f"{plugin} is not installed; pip install -e '.[sweep]' brings all but ray's")


def write_recording() -> None:
    seconds = np.arange(0, 4 * 3600, 20.0)
    temperature = 40 + 20 * np.sin(seconds / 2000)
    error = 0.2 * np.tanh((temperature - 35) / 8) + 0.01 * np.random.default_rng(1).normal(size=len(seconds))
    np.savetxt("a.csv", np.column_stack([seconds, temperature, error]), "%.6f", ",", header="time_s,temperature_c,rate_dph", comments="")


@pytest.fixture
def recordings(tmp_path) -> Path:
    write_recording()
    return tmp_path


def importable_from(folder: Path, monkeypatch) -> None:
    """By commands that are begun, and by their workers."""
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")]))


@pytest.fixture
def early_checkpoints(recordings, monkeypatch) -> list[str]:
    """Settings by which checkpoints come early, so that a worker is far from its end when one is there, however quick the machine."""
    Path("mine.py").write_text(
        "import zoo.training.checkpoints\nfrom zoo.models.bp import BP\nzoo.training.checkpoints.EVERY_S = 0.1\nclass Mine(BP):\n    pass\n"
    )
    importable_from(recordings, monkeypatch)
    return ["model=bp", "model._target_=mine.Mine"]


def sweep(*more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*FOGZOO, *SWEEP, *more], capture_output=True, text=True, check=False)


def table() -> list[tuple[str, ...]]:
    with Path("sweep/sweep.csv").open() as file:
        return [tuple(value for key, value in row.items() if key != "wall_time_s") for row in csv.DictReader(file)]


@pytest.mark.parametrize("choice", SCHEMAS)
def test_a_missing_plugin_gets_a_line_with_what_brings_it(choice, monkeypatch, tmp_path, capsys) -> None:
    found = {name: kind for name, kind in Plugins.instance().class_name_to_class.items() if not name.startswith("hydra_plugins.")}
    monkeypatch.setattr(Plugins.instance(), "class_name_to_class", found)
    assert application.run("train", ["-m", f"hydra/{choice.replace('/', '=')}", "data.files=[a.csv]", "seed=1,2"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    group, name = choice.split("/")
    assert f"hydra/{group}={name.partition('_')[0]}" in line
    assert re.search(rf"pip install .*hydra-{name.partition('_')[0]}-{group}", line)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(shutil.which("srun") is not None, reason="this machine is in a Slurm cluster")
def test_where_there_is_no_cluster_that_is_said(recordings, capsys) -> None:
    needs("hydra_submitit_launcher")
    assert application.run("train", [*SWEEP[1:], "hydra/launcher=submitit_slurm", "model=polynomial", "seed=1,2"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "hydra/launcher=submitit_local" in line


@pytest.mark.parametrize("choice", SCHEMAS)
def test_settings_are_those_that_the_plugin_has(choice) -> None:
    """Ours take the place of the plugin's: one that it has got since would be missed, one that it has lost would stop it."""
    module, _, name = SCHEMAS[choice].rpartition(".")
    needs(module.partition(".")[0])
    schema = getattr(importlib.import_module(f"hydra_plugins.{module}"), name)
    ours = OmegaConf.load(config_folder() / "hydra" / f"{choice}.yaml")
    fields = {one.name for one in dataclasses.fields(schema)} - {"defaults"}
    assert set(ours) - {"defaults"} == fields
    assert ours._target_ == schema._target_


@pytest.fixture(scope="module")
def sweep_here(command) -> Callable[..., tuple[int, str, str]]:
    """The same where no worker is started; see `command`."""
    return lambda *more: command(*SWEEP, *more).end()


@pytest.fixture(scope="module")
def in_one_process(sweep_here, tmp_path_factory) -> list[tuple[str, ...]]:
    """The table of a sweep without any launcher."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("here"))
        write_recording()
        assert sweep_here(*TWO_FAIL)[0] == 2
        return table()


@pytest.mark.slow
@pytest.mark.parametrize("launcher", ["joblib", "submitit_local", "ray"])
def test_jobs_in_other_processes_end_as_they_do_in_this_one(launcher, recordings, request) -> None:
    """One fails, whose exit code and reason reach the command; nothing but lines of ended jobs and the table is printed, and no warning."""
    needs("hydra_ray_launcher" if launcher == "ray" else f"hydra_{launcher.partition('_')[0]}_launcher")
    here = request.getfixturevalue("in_one_process")
    there = sweep(*TWO_FAIL, f"hydra/launcher={launcher}")
    assert there.returncode == 2, there.stderr
    assert table() == here
    assert "2 of 4 jobs failed" in there.stderr
    assert "Warning" not in there.stderr
    assert "Traceback" not in there.stderr
    assert len(re.findall(r"^job \d+ done: seed=\d$", there.stdout.replace("epochs=20 ", ""), re.MULTILINE)) == 2
    assert len(re.findall(r"^job \d+ failed: .*epochs=0: a whole number", there.stdout, re.MULTILINE)) == 2
    assert "uncompensated" in Path("sweep/0/output.txt").read_text()
    assert "uncompensated" not in there.stdout
    assert there.stdout.splitlines()[-1] == str(recordings / "sweep" / "sweep.csv")


@pytest.mark.slow
def test_a_sweep_that_was_killed_goes_on_where_it_was(sweep_here, early_checkpoints) -> None:
    """Its workers end with it; the same command finishes what they left, as if nothing had been."""
    needs("hydra_joblib_launcher")
    jobs = [*early_checkpoints, "init=random", "epochs=2000,20", "seed=1"]
    typed = [*jobs, "hydra/launcher=joblib", "hydra.launcher.n_jobs=2"]
    killed = subprocess.Popen([*FOGZOO, *SWEEP, *typed], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 120
    while not Path("sweep/0/last.ckpt").is_file() and time.monotonic() < deadline:
        time.sleep(0.1)
    killed.kill()
    killed.wait()
    assert not Path("sweep/0/metrics.json").is_file()
    while members(killed.pid) and time.monotonic() < deadline:
        time.sleep(0.2)
    assert not members(killed.pid)
    assert not Path("sweep/0/metrics.json").is_file()
    assert sweep(*typed).returncode == 0
    assert "going on from" in Path("sweep/0/output.txt").read_text()
    found = table()
    shutil.rmtree("sweep")
    assert sweep_here(*jobs)[0] == 0
    assert table() == found


def members(session: int) -> list[str]:
    """Processes of a session, those that have ended aside."""
    stats = (path.read_text() for path in Path("/proc").glob("[0-9]*/stat") if path.exists())
    fields = (text.rpartition(")")[2].split() for text in stats)
    return [one for one in fields if one[3] == str(session) and one[0] != "Z"]


@pytest.mark.slow
def test_a_worker_that_dies_is_told_and_made_up_for(recordings, monkeypatch) -> None:
    needs("hydra_joblib_launcher")
    typed = ["model=bp", "epochs=20,30", "hydra/launcher=joblib"]
    Path("mine.py").write_text(
        "import os, signal\nfrom zoo.models.bp import BP\n"
        "class Mine(BP):\n    def __init__(self, *given, **named):\n        super().__init__(*given, **named)\n"
        "        if not os.path.exists('survived'):\n            open('survived', 'w').close(); os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    importable_from(recordings, monkeypatch)
    command = [*FOGZOO, *SWEEP, *typed, "model._target_=mine.Mine"]
    first = subprocess.run([*command, "hydra.launcher.n_jobs=2"], capture_output=True, text=True, check=False)
    assert first.returncode == 1
    assert "ended without a word" in first.stderr
    assert "the same command" in first.stderr
    again = [*command, "hydra.launcher.n_jobs=1"]  # in one process
    assert subprocess.run(again, capture_output=True, text=True, check=False).returncode == 0
    assert len(table()) == 2


@pytest.mark.parametrize("typed", [["model.hidden=3"], ["epochs=3", "hydra.sweeper.n_trials=5"]])
def test_optuna_without_a_range_to_propose_from_is_refused(typed: list[str], capsys) -> None:
    """All trials would be the same."""
    assert application.run("train", ["-m", "hydra/sweeper=optuna", "model=bp", *typed, "data.files=[a.csv]"]) == 2
    assert "no setting is given as a range to propose values from" in capsys.readouterr().err


def test_optuna_is_asked_nothing_where_it_has_nothing_to_do() -> None:
    """One job, and settings of a search that are given as such."""
    check_proposals(["--cfg", "job", "hydra/sweeper=optuna"])
    check_proposals(["-m", "hydra/sweeper=optuna", "model.hidden=range(2,5)"])
    check_proposals(["-m", "hydra/sweeper=optuna", "++hydra.sweeper.params={model.hidden: 'range(2,5)'}"])
    check_proposals(["-m", "hydra/sweeper=optuna", "experiment=mine"])


@pytest.mark.parametrize("typed", [["model=bp,wavelet,ls_svm", "model.hidden=range(2,12)"], ["model.hidden=interval(2,5)", "model=ls_svm,bp"]])
def test_optuna_proposes_nothing_that_does_not_go_together(typed: list[str], capsys, tmp_path, monkeypatch) -> None:
    """The one trial in which it does not would end the others."""
    monkeypatch.chdir(tmp_path)
    assert application.run("train", ["-m", "hydra/sweeper=optuna", *typed, "optimizer.lr=tag(log,interval(1e-3,1e-1))", "data.files=[a.csv]"]) == 2
    told = capsys.readouterr().err
    assert "unknown key 'model.hidden': model has no hidden" in told
    assert not list(tmp_path.iterdir())


def test_what_goes_together_is_proposed() -> None:
    ranges = ["model=bp,wavelet", "model.hidden=choice(2,3,5)", "optimizer=adam,sgd", "++optimizer.lr=0.01", "hydra.sweeper.n_trials=4"]
    check_choices("train", ["-m", "hydra/sweeper=optuna", "hydra/sweeper/sampler=random", *ranges, "seed=shuffle(range(3))"])
    check_choices("train", ["-m", "model=bp,ls_svm", "model.hidden=3"])  # Hydra's own sweeper looks for itself


@pytest.mark.slow
def test_optuna_proposes_the_same_again_and_finds_it_done(sweep_here, recordings) -> None:
    """A range includes its end; trials that fail cost the others nothing."""
    needs("hydra_optuna_sweeper")
    typed = ["hydra/sweeper=optuna", "model=polynomial", "model.order=range(0,2)", "hydra/sweeper/sampler=random"]
    assert sweep_here(*typed, "hydra.sweeper.n_trials=12")[0] == 2
    tried = {key: rms for key, *_, rms, _unit in table()}
    assert set(tried) == {"1", "2"}
    best = OmegaConf.load("sweep/optimization_results.yaml")
    assert best.best_params["model.order"] == 2
    assert best.best_value == pytest.approx(min(json.loads(path.read_text())["rms"] for path in Path("sweep").rglob("metrics.json")))
    _, again, _ = sweep_here(*typed, "hydra.sweeper.n_trials=12")
    done = len(list(Path("sweep").rglob("metrics.json")))
    assert f"({done} done before)" in again


@pytest.mark.slow
def test_ctrl_c_ends_all_jobs_with_a_line(early_checkpoints) -> None:
    needs("hydra_joblib_launcher")
    typed = [*early_checkpoints, "epochs=50000", "seed=1,2,3", "hydra/launcher=joblib"]
    running = subprocess.Popen([*FOGZOO, *SWEEP, *typed], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    deadline = time.monotonic() + 120
    while not Path("sweep/0/last.ckpt").is_file() and time.monotonic() < deadline:
        time.sleep(0.1)
    os.killpg(running.pid, signal.SIGINT)
    _, message = running.communicate(timeout=60)
    assert running.returncode == 130
    assert message.splitlines() == [MESSAGE]
    ended = time.monotonic() + 20  # on a busy machine the last of them may outlive the one that they worked for
    while members(running.pid) and time.monotonic() < ended:
        time.sleep(0.1)
    assert not members(running.pid)
