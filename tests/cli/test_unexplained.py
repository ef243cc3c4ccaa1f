"""What `diagnose` writes and says where nothing in the catalogue explains the runs, and that it can be typed as it stands."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser

from zoo.cli.application import run
from zoo.cli.next_commands import diagnose_command, form_is_better, stub_commands
from zoo.cli.refine import _what_is_left
from zoo.report.unknown_stub import Stub

PROGRAM = "profile.legs=[[20,20,1800],[20,50,3600],[50,50,1800],[50,0,3000],[0,0,1800],[0,20,3600],[20,20,1800]]"
GYRO = ["hidden=aging", "amplitude=0.3", "runs=1", "profile=legs", PROGRAM, "sample_s=20", "thermometers=1", "seed=2", "pictures=false"]


def typed(commands: list[str], folder: Path) -> str:
    """What a shell prints that is given these commands, with an effect of the user's own already to be found."""
    places = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "PYTHONPATH": str(folder)}
    done = subprocess.run(["sh", "-ec", "\n".join(commands)], cwd=folder, env=os.environ | places, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_the_class_is_written_and_its_commands_refit_with_it(tmp_path, capsys) -> None:
    (tmp_path / "conf" / "effects").mkdir(parents=True)
    assert run("simulate", [*GYRO, "hydra.run.dir=runs"]) == 0
    given = ["data.files=[runs/run_1.csv]", "candidates=[chamber_cycling]", f"hydra.searchpath=[file://{tmp_path}/conf]"]
    capsys.readouterr()
    assert run("diagnose", [*given, "hydra.run.dir=out"]) == 0
    said = capsys.readouterr().out
    words = json.loads((tmp_path / "out" / "diagnosis.json").read_text())["unexplained_words"]
    assert "time since the run's start" in words
    assert words.split(".")[0].lower() in " ".join(said.split()).lower()
    assert f"a class to start from: {Path('out') / 'unexplained.py'}" in said.replace(f"{tmp_path}/", "")
    assert (tmp_path / "out" / "conf" / "effects" / "unexplained.yaml").is_file()
    commands = [line.strip() for line in said.splitlines() if line.startswith(("  export", "  fogzoo"))]
    assert commands[0] == f"export PYTHONPATH={tmp_path / 'out'}:$PYTHONPATH"
    assert f"'hydra.searchpath=[file://{tmp_path}/conf,file://{tmp_path / 'out'}/conf]'" in commands[1]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert f"{commands[1]}".replace("'", "&#39;") in page
    typed([commands[0], f"{commands[1]} hydra.run.dir=again"], tmp_path)
    first, last = json.loads((tmp_path / "again" / "refinement.json").read_text())["ladder"]
    assert last["added"] == "unexplained"
    assert last["rms"] < 0.5 * first["rms"]


def test_folders_of_any_name_can_be_pasted() -> None:
    """Hydra wants quotes around parentheses, those that were typed stay."""
    typed = ["fogzoo", "refine", 'hydra.searchpath=["file:///lab (1), own/conf",file:///own/conf]']
    path, command = Stub("unexplained", "", "").commands("/my runs (2)", typed)
    assert shlex.split(path)[1] == "PYTHONPATH=/my runs (2):$PYTHONPATH"
    (setting,) = (one for one in shlex.split(command) if one.startswith("hydra.searchpath="))
    parsed = OverridesParser.create().parse_override(setting).value()
    assert [str(one).strip('"') for one in parsed] == ["file:///lab (1), own/conf", "file:///own/conf", "file:///my runs (2)/conf"]


def test_after_a_class_of_ones_own_what_both_leave_is_asked_for(tmp_path) -> None:
    """And not for the class once more, which would be written of what was unexplained before."""
    record = {"effects": ["static_bias", "mohr"], "unexplained_form": {"todo": False}}
    asked = _what_is_left({"verdict": "unknown"}, record, ["unexplained"], tmp_path)
    assert asked == [diagnose_command(["static_bias", "mohr", "unexplained"])] == ["fogzoo diagnose 'effects=[static_bias,mohr,unexplained]'"]
    assert _what_is_left({"verdict": "complete"}, record, ["unexplained"], tmp_path) == []
    assert _what_is_left({"verdict": "unknown"}, record | {"model": {"path": "net"}}, ["unexplained"], tmp_path) == []


def test_an_example_that_fits_nothing_is_not_to_be_refitted_with(tmp_path) -> None:
    assert stub_commands({"unexplained_form": {"todo": True}}, tmp_path) == []
    assert stub_commands({"unexplained_form": None}, tmp_path) == []
    assert stub_commands({}, tmp_path) == []


@pytest.mark.parametrize(
    ("record", "first"),
    [
        ({"outdone": True, "rms_final": 0.01, "unexplained_form": {"rms": 0.02}}, True),
        ({"outdone": False, "rms_final": 0.02, "unexplained_form": {"rms": 0.01}}, True),
        ({"outdone": False, "rms_final": 0.01, "unexplained_form": {"rms": 0.02}}, False),
        ({"outdone": False, "rms_final": 0.02, "unexplained_form": None}, False),
        ({}, False),
    ],
)
def test_a_class_that_leaves_less_than_what_helps_is_tried_first(record, first) -> None:
    assert form_is_better(record) is first
