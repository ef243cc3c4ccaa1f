"""Tab completion: what a shell asks for, and what it is given."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from zoo.cli import application, main

VERBS = ["compare", "compensate", "diagnose", "export", "refine", "reproduce", "simulate", "train"]


def offered(line: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """What is offered to go on with on a half-typed line; whoever types it sees no message."""
    monkeypatch.setenv("COMP_LINE", line)
    monkeypatch.setattr(sys, "argv", ["/somewhere/fogzoo", "-sc", "query=bash"])
    with pytest.raises(SystemExit):
        main()
    told = capsys.readouterr()
    assert not told.err
    return sorted(told.out.split())


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("fogzoo ", VERBS),
        ("fogzoo re", ["refine", "reproduce"]),
        ("fogzoo train", ["train"]),
        ("fogzoo trian model=b", []),
        ("fogzoo train model=b", ["model=bp"]),
        ("fogzoo train -m model=bp init=r", ["init=random"]),
        ("~/.venv/bin/fogzoo export refuse", ["refuse_outside="]),
        ("fogzoo train --cf", []),
        ("fogzoo train mode=[ model=b", []),
    ],
)
def test_a_verb_and_its_settings_are_completed(line: str, words: list[str], monkeypatch, capsys) -> None:
    assert offered(line, monkeypatch, capsys) == words


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("fogzoo train 'data.files=[run_*.csv]' goa", ["goal="]),
        ("fogzoo simulate 'profile.legs=[[20, 30, 600]]' noise=n", ["noise=none"]),
        ("fogzoo train 'data.files=[a.csv] goa", []),
        ("fogzoo reproduce paper=qi", ["paper=qiu2023"]),
        ("fogzoo reproduce paper=qiu2023 meth", ["methods."]),
        ("fogzoo diagnose model=./mo", ["model=./model_of_mine"]),
        ("fogzoo diagnose model=./model_of_mine candi", ["candidates="]),
    ],
)
def test_settings_are_completed_as_they_are_typed_in_a_shell(line: str, words: list[str], tmp_path, monkeypatch, capsys) -> None:
    """With quotes, which Hydra's own completion does not expect, and with names of ours, which Hydra does not know."""
    (tmp_path / "model_of_mine").mkdir()
    assert offered(line, monkeypatch, capsys) == words


@pytest.mark.parametrize("verb", [[], ["train"]])
@pytest.mark.parametrize(("shell", "registered"), [("bash", "-F hydra_bash_completion fogzoo"), ("fish", "complete -c fogzoo ")])
def test_what_is_installed_is_for_the_program(verb: list[str], shell: str, registered: str, monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "argv", ["/somewhere/fogzoo", *verb, "-sc", f"install={shell}"])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 0
    told = capsys.readouterr().out
    assert registered in told
    assert "fogzoo train" not in told


def test_a_script_is_completed_as_hydra_does_it(monkeypatch, capsys) -> None:
    monkeypatch.setenv("COMP_LINE", "python scripts/train.py model=b")
    monkeypatch.setattr(sys, "argv", ["scripts/train.py"])
    assert application.run("train", ["-sc", "query=bash"]) == 0
    assert capsys.readouterr().out.split() == ["model=bp"]


TYPED = """
eval "$(fogzoo -sc install=bash)"
complete -p fogzoo
COMP_LINE="fogzoo tr" COMP_CWORD=1; hydra_bash_completion; echo "${COMPREPLY[@]}"
COMP_LINE="fogzoo train model=po" COMP_CWORD=2; hydra_bash_completion; echo "${COMPREPLY[@]}"
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_bash_completes_what_is_typed(tmp_path: Path) -> None:
    source, program = tmp_path / "source" / "fogzoo", tmp_path / "fogzoo"
    source.parent.mkdir()
    source.write_text("from zoo.cli import main\nmain()\n")
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{source}" "$@"\n')  # as pip does it where there are blanks in Python's path
    program.chmod(0o755)
    environment = os.environ | {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(["bash", "--norc", "-c", TYPED], capture_output=True, text=True, env=environment, check=True)
    registered, *offers = done.stdout.splitlines()
    assert registered.endswith("-F hydra_bash_completion fogzoo")
    assert offers == ["train", "model=polynomial"]
    assert not done.stderr
