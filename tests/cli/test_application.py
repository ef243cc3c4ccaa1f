"""The command line as a stranger meets it: verbs, help, wrong input, exit codes."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from unittest import mock

import pytest

import zoo
from zoo.cli import USAGE, application, main

SMALL = ["runs=1", "profile=legs", "profile.legs=[[20,20,600],[20,30,600]]", "sample_s=30"]
FULL = "HYDRA_FULL_ERROR"


def told(verb: str, *arguments: str, capsys) -> tuple[int, str]:
    """Exit code and what went to the standard error."""
    capsys.readouterr()
    code = application.run(verb, list(arguments))
    return code, capsys.readouterr().err


def one_message(text: str) -> str:
    """At most two lines and no traceback."""
    assert 1 <= len(text.splitlines()) <= 2, text
    assert "Traceback" not in text
    return text


@pytest.mark.parametrize("arguments", [["--help"], ["-h"], ["help"], []])
def test_help_lists_the_verbs(arguments, capsys) -> None:
    with mock.patch.object(sys, "argv", ["fogzoo", *arguments]), pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == (0 if arguments else 2)
    listed = re.findall(r"^  fogzoo (\w+)", capsys.readouterr().out, re.MULTILINE)
    assert sorted(listed) == sorted(application.VERBS)


def test_an_unknown_verb_gets_the_nearest(capsys) -> None:
    with mock.patch.object(sys, "argv", ["fogzoo", "diagnoze"]), pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 2
    message = one_message(capsys.readouterr().err)
    assert "'diagnoze'" in message
    assert "did you mean diagnose" in message


@pytest.mark.parametrize("verb", application.VERBS)
def test_every_verb_has_help_and_shows_its_config(verb, capsys) -> None:
    with pytest.raises(SystemExit) as stopped:  # Hydra's own way to end after --help and --cfg, or none
        sys.exit(application.run(verb, ["--help"]))
    assert not stopped.value.code
    shown = capsys.readouterr().out
    (does,) = re.findall(rf"^  fogzoo {verb} +(.+)$", USAGE, re.MULTILINE)
    assert shown.startswith(f"fogzoo {verb}: {does}\nMostly: "), "as in the list of verbs"
    mostly = shown.splitlines()[1]
    assert all(re.search(rf"^ *{key}:", shown, re.MULTILINE) for key in re.findall(r"([a-z_]+)(?==)", mostly) if key != "paper"), mostly
    assert f"conf/{verb}.yaml" in shown
    assert "Powered by Hydra" in shown
    assert application.run(verb, ["--cfg", "job"]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"^seed: 1$", shown, re.MULTILINE)
    assert re.search(r"^torch_device: cpu$", shown, re.MULTILINE)
    assert not Path("outputs").exists()


@pytest.mark.parametrize("verb", application.VERBS)
def test_an_unknown_key_is_named(verb, capsys) -> None:
    code, message = told(verb, "sed=3", capsys=capsys)
    assert code == 2
    assert "'sed'" in one_message(message)
    assert len(message.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "near"),
    [
        (["simulate", "effects=[static_bias,hysterezis]"], "hysteresis"),
        (["diagnose", "data.files=[a.csv]", "effects=[static_bias,mor]"], "mohr"),
        (["simulate", "gyro=mediun"], "medium"),
        (["train", "data.files=[a.csv]", "model=polinomial"], "polynomial"),
        (["train", "data.files=[a.csv]", "hydra/launcher=basik"], "basic"),
        (["reproduce", "paper=qiu2032"], "qiu2023"),
    ],
)
def test_an_unknown_name_gets_the_nearest(arguments, near, capsys) -> None:
    code, message = told(*arguments, capsys=capsys)
    assert code == 2
    assert f"did you mean {near}" in one_message(message)
    assert "unknown experiment" not in message, "when a paper was asked for"


@pytest.mark.parametrize(("kind", "key"), [("model", "model=mynett"), ("effects", "effects=[static_bias,mynett]")])
def test_an_unknown_name_may_be_near_one_of_the_users_own(kind, key, tmp_path, capsys) -> None:
    (tmp_path / "conf" / kind).mkdir(parents=True)
    (tmp_path / "conf" / kind / "mynet.yaml").write_text("_target_: mine.MyNet\n")
    code, message = told("train", "data.files=[a.csv]", key, f"hydra.searchpath=[file://{tmp_path}/conf]", capsys=capsys)
    assert code == 2
    assert "unknown" in one_message(message)
    assert "'mynett': did you mean mynet" in message
    assert {"model": "polynomial", "effects": "mohr"}[kind] in message, "the package's own as well"


@pytest.mark.parametrize(("verb", "key"), [("diagnose", "data.files"), ("compensate", "run"), ("export", "run"), ("reproduce", "paper")])
def test_a_missing_setting_is_named(verb, key, capsys) -> None:
    code, message = told(verb, capsys=capsys)
    assert code == 2
    assert key in one_message(message)


@pytest.mark.parametrize("text", ["[[", "seed=", "=", "runs=[1,"])
def test_half_typed_settings_are_no_traceback(text, capsys) -> None:
    code, message = told("simulate", text, capsys=capsys)
    assert code == 2
    one_message(message)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        (["run_1.csv"], "'data.files=[run_1.csv]'"),
        (["a.csv", "b(2).csv"], """'data.files=[a.csv,"b(2).csv"]'"""),
        (["data.files"], "settings are key=value"),
        (["data.files=[Läufe-ä.csv]"], """'data.files=["Läufe-ä.csv"]'"""),
        (["data.files=[a.csv,run(2).csv]"], """'data.files=[a.csv,"run(2).csv"]'"""),
        (["data.columns.temperature=Temp Coil [°C]"], """'data.columns.temperature="Temp Coil [°C]"'"""),
    ],
)
def test_what_the_parser_stumbles_over_is_given_back_as_it_was_meant(typed, meant, capsys) -> None:
    code, message = told("diagnose", *typed, capsys=capsys)
    assert code == 2
    assert meant in one_message(message)
    assert "Lexer" not in message
    assert "EOF" not in message


def test_a_name_with_special_characters_is_read_as_the_message_says(capsys) -> None:
    code, message = told("diagnose", 'data.files=["run(2)-ä.csv"]', capsys=capsys)
    assert code == 2
    assert "run(2)-ä.csv: no such file" in message


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (["--confg-name", "x"], "unknown flag --confg-name: did you mean --config-name"),
        (["--cfg", "jobs"], "choose from"),
        (["--cfg", "job", "-m", "seed=1,2"], "--multirun and --cfg: each asks for something else"),
        (["seed=1", "--cfg", "job", "seed=2"], "seed=2 stands apart"),
    ],
)
def test_a_wrong_flag_gets_a_line_and_no_usage(typed, said, capsys) -> None:
    code, message = told("diagnose", *typed, capsys=capsys)
    assert code == 2
    assert said in one_message(message)


@pytest.mark.parametrize("arguments", [["--version"], ["diagnose", "--version"]])
def test_the_version(arguments, capsys) -> None:
    with mock.patch.object(sys, "argv", ["fogzoo", *arguments]), pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 0
    assert capsys.readouterr().out == f"fogzoo {zoo.__version__}\n"


@pytest.mark.parametrize("folder", ["file/below", "file"])
def test_a_folder_that_cannot_be_made_is_named(folder, capsys) -> None:
    Path("file").write_text("in the way")
    code, message = told("simulate", *SMALL, f"hydra.run.dir={folder}", capsys=capsys)
    assert code == 2
    assert "file" in one_message(message)
    assert Path("file").read_text() == "in the way"


@pytest.mark.parametrize("before", [None, "0", "1"])
def test_the_environment_is_left_as_it_was(before, monkeypatch) -> None:
    monkeypatch.delenv(FULL)
    if before is not None:
        monkeypatch.setenv(FULL, before)
    assert application.run("simulate", [*SMALL, "hydra.run.dir=out"]) == 0
    assert os.environ.get(FULL) == before
    if before != "1":
        assert application.run("simulate", ["runs=none", "hydra.run.dir=bad"]) == 2
        assert os.environ.get(FULL) == before


@pytest.mark.parametrize(("verb", "wrong"), [("simulate", "runs=none"), ("train", "model=nope")])
def test_who_asks_for_the_trace_gets_it_besides(verb, wrong, monkeypatch, capsys) -> None:
    monkeypatch.setenv(FULL, "1")
    code, message = told(verb, wrong, "hydra.run.dir=bad", capsys=capsys)
    assert code == 2
    assert message.startswith("Traceback")
    assert one_message(message.splitlines()[-1]).startswith("error: ")
    assert os.environ[FULL] == "1"


def test_a_folder_of_configs_that_is_not_there_is_told_once(capsys) -> None:
    code, message = told("train", "data.files=[a.csv]", "hydra.searchpath=[file:///nowhere/conf]", capsys=capsys)
    assert code == 2
    assert "/nowhere/conf: no such folder" in one_message(message)


def test_results_lie_where_the_contract_says(capsys) -> None:
    assert application.run("simulate", SMALL) == 0
    last = Path(capsys.readouterr().out.splitlines()[-1])
    assert re.fullmatch(r"outputs/simulate/\d{4}-\d\d-\d\d/\d\d-\d\d-\d\d", last.relative_to(Path.cwd()).as_posix())
    assert {"run_1.csv", "check.csv", "truth.json", ".hydra"} <= {path.name for path in last.iterdir()}


def test_a_sweep_needs_no_folder_and_no_job_before_it(tmp_path) -> None:
    """In a process of its own, as typed: Hydra's configuration of an earlier job would answer for what this one lacks."""
    command = [sys.executable, "-c", "from zoo.cli import main; main()", "simulate", "-m", *SMALL, "seed=1,2"]
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    assert sorted(path.parent.name for path in tmp_path.glob("outputs/simulate/multirun/*/*/*/truth.json")) == ["0", "1"]


def test_a_failing_job_costs_the_others_nothing(capsys) -> None:
    """The wrong one goes first."""
    code, message = told("simulate", "-m", *SMALL, "seed=-1,1,2", "hydra.sweep.dir=sweep", capsys=capsys)
    assert code == 2
    assert "seed=-1" in message
    assert "Traceback" not in message
    assert not Path("sweep/0/run_1.csv").exists()
    for job, seed in (("1", 1), ("2", 2)):
        assert json.loads(Path("sweep", job, "truth.json").read_text())["seed"] == seed
    assert Path("sweep/1/run_1.csv").read_bytes() != Path("sweep/2/run_1.csv").read_bytes()


def written(language: str) -> str:
    """The example of an effect in CONTRIBUTING.md."""
    text = (Path(__file__).resolve().parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)[0]


def test_the_effect_that_contributing_shows_works_from_outside(tmp_path, monkeypatch) -> None:
    (tmp_path / "conf" / "effects").mkdir(parents=True)
    (tmp_path / "my_effects.py").write_text(written("python"), encoding="utf-8")
    (tmp_path / "conf" / "effects" / "mine.yaml").write_text(written("yaml"), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "my_effects", raising=False)
    path = f"hydra.searchpath=[file://{tmp_path}/conf]"
    simulated = ["runs=2", "profile=cycle", "profile.hold_s=1800", "sample_s=20", "hidden=mine", "amplitude=0.2", "seed=3", "hydra.run.dir=runs"]
    assert application.run("simulate", [*simulated, path]) == 0
    assert json.loads(Path("runs/truth.json").read_text())["hidden"] == ["mine"]
    fit = ["data.files=[runs/run_*.csv]", "data.average_s=100", "candidates=[mine,aging]", path]
    assert application.run("diagnose", [*fit, "effects=[static_bias,mohr]", "hydra.run.dir=without"]) == 0
    found = json.loads(Path("without/diagnosis.json").read_text())
    assert found["missing"] == ["mine"]
    assert application.run("diagnose", [*fit, "effects=[static_bias,mohr,mine]", "hydra.run.dir=with"]) == 0
    assert json.loads(Path("with/diagnosis.json").read_text())["rms"] < 0.5 * found["rms"]
