"""An effect from outside the repository with a mistake in it: a line or two that name it, its class and its YAML, and say what is possible."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from omegaconf import OmegaConf

from zoo.catalog import build, names
from zoo.cli import application
from zoo.cli.given_model import Subject
from zoo.cli.grown_model import examine
from zoo.cli.next_commands import next_commands
from zoo.effects.checks import check_effect

CLASS = """
import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.lag import lagged

TIME = Parameter("time", 1800.0, "s", 300.0, 14400.0, "log")
SIZE = Parameter("coefficient", 0.0, "unit/(K/min)", -10.0, 10.0)


class Mine(Effect):
    name = "mine"
    place = "coil"
    shape = (TIME,)
    amplitudes = (SIZE,)
    needs = ()

    def columns(self, history: History, shape: Tensor) -> Tensor:
        column = lagged(history.time, history.rate.abs(), shape[..., 0])
        return column.unsqueeze(-1)
"""
YAML = "mine:\n  _target_: my_effects.Mine\n"
RETURN = "return column.unsqueeze(-1)"
DECLARED = "amplitudes = (SIZE,)"
QUICK = ["runs=1", "profile=legs", "profile.legs=[[20,20,1200],[20,40,3600],[40,40,1200]]", "sample_s=30"]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Iterator[Path]:
    """The user's folder, on PYTHONPATH; whatever a verb and an import leave in the process is put back."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "conf" / "effects").mkdir(parents=True)
    sys.modules.pop("my_effects", None)
    yield tmp_path
    sys.modules.pop("my_effects", None)


@pytest.fixture
def verb(folder, capsys) -> Callable[..., tuple[int, str]]:
    """Writes the user's two files and runs a verb with them; gives the exit code and what it said."""

    def run(*arguments: str, source: str | None = CLASS, yaml: str = YAML) -> tuple[int, str]:
        if source is not None:
            (folder / "my_effects.py").write_text(source, encoding="utf-8")
        (folder / "conf" / "effects" / "mine.yaml").write_text(yaml)
        capsys.readouterr()
        code = application.run(arguments[0], [*arguments[1:], "hydra.run.dir=out", f"hydra.searchpath=[file://{folder}/conf]"])
        return code, capsys.readouterr().err

    return run


@pytest.fixture
def refused(verb, folder) -> Callable[..., str]:
    """The same where the verb must refuse, in a way that holds for every mistake."""

    def run(*arguments: str, source: str | None = CLASS, yaml: str = YAML) -> str:
        code, message = verb(*arguments, source=source, yaml=yaml)
        assert code == 2, message
        assert message.startswith("error: ")
        assert 1 <= len(message.strip().splitlines()) <= 2, message
        assert "Traceback" not in message
        assert "HYDRA_FULL_ERROR" not in message
        assert str(folder / "conf" / "effects" / "mine.yaml") in message, message
        return message

    return run


def changed(old: str, new: str) -> str:
    assert CLASS.count(old) == 1, old
    return CLASS.replace(old, new)


def test_the_effect_that_the_others_are_spoilt_from_is_good(verb) -> None:
    assert verb("simulate", *QUICK, "hidden=mine") == (0, "")


@pytest.mark.parametrize("name", names("effects"))
def test_every_effect_of_the_catalogue_passes(name) -> None:
    check_effect(build("effects", name), name)


# What the class declares


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('name = "mine"', "", ["Mine.name is missing"]),
        ('name = "mine"', 'name = "mien"', ["Mine.name = 'mien'", "called 'mine'"]),
        ('place = "coil"', 'place = "spool"', ["Mine.place = 'spool'", "nown: coil, housing"]),
        (DECLARED, "", ["Mine.amplitudes is missing", "tuple of Parameter"]),
        (DECLARED, "amplitudes = SIZE", ["Mine.amplitudes = Parameter(", "comma"]),
        (DECLARED, "amplitudes = [SIZE]", ["Mine.amplitudes = [Parameter("]),
        (DECLARED, "amplitudes = ()", ["Mine.amplitudes is empty"]),
        ("shape = (TIME,)", "shape = (TIME)", ["Mine.shape = Parameter(", "comma"]),
        ("shape = (TIME,)", "shape = (1800.0,)", ["Mine.shape = (1800.0,)", "tuple of Parameter"]),
        ("shape = (TIME,)", "shape = None", ["Mine.shape is missing"]),
        ("needs = ()", 'needs = ("supply_v")', ["Mine.needs = 'supply_v'", "tuple of str"]),
        ("    needs = ()", "    def __init__(self) -> None:\n        self.mine = 1", ["Mine.__init__ does not call super().__init__()"]),
    ],
)
def test_a_wrong_declaration(refused, old, new, words) -> None:
    message = refused("simulate", *QUICK, "hidden=mine", source=changed(old, new))
    for word in ["effect 'mine' (", *words]:
        assert word in message, message


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ('"s", 300.0, 14400.0, "logarithmic"', ["scale='logarithmic'", "did you mean log?"]),
        ('"s", 300.0, 14400.0, True', ["scale=True", "index, inverse, linear, log"]),
        ('"s", 0.0, 14400.0, "log"', ["bounds 0 … 14400", "above 0"]),
        ('"s", -300.0, 14400.0, "inverse"', ["bounds -300 … 14400", "above 0"]),
        ('"s", 14400.0, 300.0, "log"', ["bounds 14400 … 300", "the lower first"]),
        ('"s", 1800.0, 1800.0', ["bounds 1800 … 1800", "the lower first"]),
        ('"s", 300.0, float("inf")', ["bounds 300 … inf", "finite"]),
        ('"s", float("nan"), 300.0', ["bounds nan … 300", "finite"]),
        ('300.0, "s", 14400.0', ["bounds 's' … 14400.0", "numbers are needed"]),
        ('"s", 3000.0, 14400.0', ["default 1800", "3000 … 14400"]),
    ],
)
def test_a_parameter_that_cannot_be_searched(refused, folder, wrong, words) -> None:
    message = refused("simulate", *QUICK, "hidden=mine", source=changed('"s", 300.0, 14400.0, "log"', wrong))
    for word in ["effect 'mine' (", "parameter 'time'", f"{folder / 'my_effects.py'}, line 8", *words]:
        assert word in message, message


# What its columns are


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (RETURN, "return column", ["returns (40,) ", "(40, 1) is needed", ".unsqueeze(-1)"]),
        (RETURN, "return torch.stack([column, column])", ["returns (2, 40) ", "(40, 1) is needed", "time goes before columns"]),
        (RETURN, "return column.unsqueeze(-2)", ["returns (1, 40) ", "time goes before columns"]),
        (RETURN, "return torch.stack([column, column], dim=-1)", ["returns (40, 2) ", "(40, 1) is needed", "there is 1 amplitude"]),
        (DECLARED, 'amplitudes = (SIZE, Parameter("slope", 0.0, "unit", -1.0, 1.0))', ["returns (40, 1) ", "there are 2 amplitudes"]),
        (RETURN, "return column[..., 1:].unsqueeze(-1)", ["returns (39, 1) ", "one row a sample"]),
        (RETURN, "return column.float().unsqueeze(-1)", ["torch.float32", "torch.float64 is needed"]),
        (RETURN, "return (column > 1).unsqueeze(-1)", ["torch.bool", "torch.float64 is needed"]),
        (RETURN, "return column.unsqueeze(-1) * torch.nan", ["NaN or infinite values, at time 789.644"]),
        (RETURN, "return history.temperature.sqrt().unsqueeze(-1)", ["NaN or infinite"]),
        (RETURN, "return 1 / (column - column).unsqueeze(-1)", ["NaN or infinite"]),
        (RETURN, "pass", ["returns a NoneType", "a Tensor is needed"]),
        (RETURN, "return column.unsqueeze(-1).numpy()", ["returns a ndarray"]),
        (RETURN, "return column.unsqueze(-1)", ["fails with AttributeError", "unsqueze", "my_effects.py, line 21"]),
        (RETURN, 'return column.unsqueeze(-1) * history.inputs["supply_v"]', ["fails with KeyError", "needs = ('supply_v',)"]),
    ],
)
def test_columns_that_cannot_be_fitted(refused, old, new, words) -> None:
    message = refused("simulate", *QUICK, "hidden=mine", source=changed(old, new))
    for word in ["effect 'mine' (", "Mine.columns", *words]:
        assert word in message, message


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("history.rate if history.run == 1 else 2 * history.rate", "fails with RuntimeError"),
        ("lagged(history.time, history.thermometer - history.thermometer[0], shape[..., 0])", "are not what each is alone"),
    ],
)
def test_runs_together_that_are_not_each_by_itself(refused, wrong, words) -> None:
    good = "lagged(history.time, history.rate.abs(), shape[..., 0])"
    wrong = wrong + " + 0 * shape[..., 0:1]"
    message = refused("simulate", *QUICK, "hidden=mine", source=changed(good, wrong).replace("needs = ()", "needs = ()\n    runs_together = True"))
    for word in ("effect 'mine' (", "Mine.runs_together is True", words, "leave it out"):
        assert word in message, message


@pytest.mark.parametrize(
    "wrong",
    [
        "lagged(history.time, history.rate.abs(), shape[0])",
        "torch.exp(-history.time / shape[0])",
        "torch.exp(-history.time / shape[..., 0])",
        "torch.exp(-history.time / shape.mean())",
        "lagged(history.time, history.rate.abs(), shape[..., 0]) - history.rate.mean()",
        "lagged(history.time, history.temperature - history.temperature[0], shape[..., 0])",
    ],
)
def test_a_batch_that_is_not_each_by_itself(refused, wrong) -> None:
    message = refused("simulate", *QUICK, "hidden=mine", source=changed("lagged(history.time, history.rate.abs(), shape[..., 0])", wrong))
    for word in ("effect 'mine' (", "Mine.columns", "shape[..., 0] and not shape[0]"):
        assert word in message, message


def test_two_shapes_unpacked_along_the_batch_are_noticed(refused) -> None:
    """Two rows of two parameters: nothing fails, and every number is another's."""
    source = changed("shape = (TIME,)", 'shape = (TIME, Parameter("power", 1.0, "1", 0.5, 3.0))')
    source = source.replace("column = lagged(history.time, history.rate.abs(), shape[..., 0])", "time, power = shape")
    source = source.replace(RETURN, "return torch.exp(-history.time / time[..., None]).pow(power[..., None]).unsqueeze(-1)")
    assert "treats a batch otherwise than each of its members" in refused("simulate", *QUICK, "hidden=mine", source=source)


# How it is found


@pytest.mark.parametrize("more", [["hidden=mine"], ["effects=[static_bias,mine]"]], ids=["candidate", "chosen"])
@pytest.mark.parametrize(
    ("yaml", "words"),
    [
        ("mien:\n  _target_: my_effects.Mine\n", ["'mien' at the top", "'mine:'"]),
        ("_target_: my_effects.Mine\n", ["'_target_' at the top", "'mine:'"]),
        ("", ["nothing", "'mine:'"]),
        ("mine:\n", ["no _target_ below 'mine:'"]),
        ("mine:\n  target: my_effects.Mine\n", ["no _target_ below 'mine:'", "_target_: MODULE.CLASS"]),
        ("mine:\n_target_: my_effects.Mine\n", ["'mine, _target_' at the top"]),
        ("mine:\n  _target_: my_effects.lagged\n", ["zoo.physics.lag.lagged: TypeError", "missing 3 required"]),
        ("mine:\n  _target_: my_effects.torch.Generator\n", ["a Generator is no effect", "derived from zoo.effects.base.Effect"]),
        ("mine:\n  _target_: my_effects.Mine\n  width: 3\n", ["my_effects.Mine: TypeError", "width"]),
    ],
)
def test_a_wrong_yaml(refused, yaml, words, more) -> None:
    message = refused("simulate", *QUICK, *more, yaml=yaml)
    for word in words:
        assert word in message, message


@pytest.mark.parametrize("more", [["hidden=mine"], ["effects=[static_bias,mine]"]], ids=["candidate", "chosen"])
@pytest.mark.parametrize("yaml", ["mine: {\n", "mine:\n\t_target_: my_effects.Mine\n", "my_effects.Mine\n"])
def test_a_file_that_is_no_yaml_of_settings(refused, yaml, more) -> None:
    assert "mine" in refused("simulate", *QUICK, *more, yaml=yaml)


@pytest.mark.parametrize("more", [["hidden=mine"], ["effects=[static_bias,mine]"]], ids=["candidate", "chosen"])
@pytest.mark.parametrize(
    ("target", "source", "words"),
    [
        ("my_efects.Mine", CLASS, ["no module 'my_efects'", "PYTHONPATH"]),
        ("lab.effects.Mine", CLASS, ["no module 'lab'", "PYTHONPATH"]),
        ("my_effects.Mien", CLASS, ["module 'my_effects' has no 'Mien'", "did you mean Mine? Known: Mine"]),
        ("Mine", CLASS, ["Mine: MODULE.CLASS is needed"]),
        ("my_effects.Mine", CLASS.replace("class Mine(Effect):", "class Mine(Effect)"), ["SyntaxError", "my_effects.py, line 12"]),
        ("my_effects.Mine", CLASS.replace("import Tensor", "import Tensro"), ["ImportError", "Tensro", "my_effects.py, line 3"]),
        ("my_effects.Mine", CLASS.replace("(Effect):", "(Efect):"), ["NameError", "Efect", "my_effects.py, line 12"]),
        ("my_effects.Mine", CLASS.replace("import torch\n", "import nothing_of_that_name\n", 1), ["nothing_of_that_name", "my_effects.py, line 2"]),
    ],
)
def test_a_class_that_python_does_not_find(refused, target, source, words, more) -> None:
    message = refused("simulate", *QUICK, *more, source=source, yaml=f"mine:\n  _target_: {target}\n")
    for word in ["effect 'mine' (", *words]:
        assert word in message, message
    assert ("PYTHONPATH" in message) == ("PYTHONPATH" in words)


def test_without_pythonpath_there_is_no_module(refused) -> None:
    assert "there is no module 'my_effects'; is its folder on PYTHONPATH?" in refused("simulate", *QUICK, "hidden=mine", source=None)


# Wherever it is met


@pytest.fixture(scope="module")
def recorded() -> dict[str, bytes]:
    """The files of a simulation, once it was done."""
    return {}


@pytest.fixture
def recording(folder, verb, recorded) -> str:
    """The setting that names a recorded run, which has the effect in it."""
    if not recorded:
        assert verb("simulate", *QUICK, "hidden=mine", "amplitude=0.3") == (0, "")
        recorded |= {path.name: path.read_bytes() for path in (folder / "out").glob("*.csv")}
        (folder / "out").rename(folder / "simulated")
        del sys.modules["my_effects"]
    (folder / "runs").mkdir()
    for name, data in recorded.items():
        (folder / "runs" / name).write_bytes(data)
    return "data.files=[runs/run_1.csv]"


FLAT = "_target_: my_effects.Mine\n"


@pytest.mark.parametrize(
    "arguments",
    [
        ["diagnose"],
        ["diagnose", "candidates=[mine]"],
        ["diagnose", "effects=[static_bias,mine]"],
        ["refine", "add=mine"],
        ["refine", "add=aging"],
        ["refine", "add=aging", "effects=[static_bias,mine]"],
        ["train", "model=graybox", "effects=[static_bias,mine]"],
    ],
    ids=" ".join,
)
@pytest.mark.parametrize("mistake", ["columns", "yaml"])
def test_every_verb_that_uses_it_refuses_it(refused, recording, folder, arguments, mistake) -> None:
    wrong = {"source": changed(RETURN, "return column")} if mistake == "columns" else {"yaml": FLAT}
    message = refused(arguments[0], recording, *arguments[1:], **wrong)
    assert ("(40, 1) is needed" if mistake == "columns" else "'_target_' at the top") in message
    assert not list((folder / "out").glob("*.json"))


@pytest.mark.parametrize(
    "arguments", [["diagnose", "candidates=[aging]"], ["refine", "add=aging", "candidates=[warm_up]"], ["train", "model=polynomial"]], ids=" ".join
)
def test_who_does_not_ask_for_it_is_not_bothered(verb, recording, arguments) -> None:
    code, message = verb(arguments[0], recording, *arguments[1:], source=changed(RETURN, "return column"), yaml=FLAT)
    assert code == 0, message


# What to type next


def test_the_next_command_can_be_pasted_and_means_the_same(verb, monkeypatch) -> None:
    """Whatever was set for the diagnosis holds for the refinement too, null and spaces included."""
    commands: list[str] = []
    configs: list[dict] = []

    def remember(config, out) -> Path:
        configs.append(OmegaConf.to_container(config))
        commands.extend(next_commands(["mine"]))
        return out

    monkeypatch.setattr("zoo.cli.diagnose.run", remember)
    monkeypatch.setattr("zoo.cli.refine.run", remember)
    settings = ["data.files=[a.csv,b.csv]", "effects=[static_bias,mohr]", "candidates=[mine]", "data.average_s=null", "data.gap_s=900"]
    settings += ["data.columns.time='t in s'", "+data.columns.temperature_outer=T2", "+effects.mohr._convert_=all", "torch_device=cuda", "seed=5"]
    assert verb("diagnose", *settings) == (0, "")
    words = shlex.split(commands[0])
    assert words[:3] == ["fogzoo", "refine", "add=[mine]"]
    assert application.run("refine", [*words[2:], "hydra.run.dir=out"]) == 0
    diagnosed, refined = configs
    assert refined == diagnosed | {"add": ["mine"]}
    assert shlex.split(commands[1])[2:] == words[2:], "and what is added is not added twice"


def test_the_proposed_run_is_simulated_with_the_effect_wherever_it_lies(verb, monkeypatch) -> None:
    commands: list[str | None] = []
    proposed = [shlex.join(["fogzoo", "simulate", *QUICK, "hidden=mine"]), None]

    def remember(config, out) -> Path:
        for command in proposed:
            found = SimpleNamespace(record={"next_experiment": {"command": command}}, search=SimpleNamespace(missing=[]))
            monkeypatch.setattr("zoo.cli.grown_model.diagnose", lambda *_, found=found: found)
            commands.append(examine(Subject([], {}), [], print)[0].record["next_experiment"]["command"])
        return out

    monkeypatch.setattr("zoo.cli.diagnose.run", remember)
    assert verb("diagnose", "data.files=[a.csv]") == (0, "")
    simulated, none = commands
    assert none is None
    assert simulated is not None
    assert application.run("simulate", [*shlex.split(simulated)[2:], "hydra.run.dir=out"]) == 0


def test_without_a_missing_effect_there_is_nothing_to_type() -> None:
    assert next_commands([]) == []


@pytest.mark.parametrize("ahead", ["history.rate - history.rate.mean(-1, keepdim=True)", "history.temperature.roll(-3, -1)"])
def test_an_effect_that_looks_into_the_future_is_refused(refused, ahead) -> None:
    message = refused(
        "simulate", *QUICK, "hidden=mine", source=changed("lagged(history.time, history.rate.abs(), shape[..., 0])", f"0.0 * shape + {ahead}")
    )
    assert "Mine.columns looks into the future" in message


def test_numbers_that_are_none_are_told_of_an_effect_without_shape_too(refused) -> None:
    source = changed("shape = (TIME,)", "shape = ()").replace("lagged(history.time, history.rate.abs(), shape[..., 0])", "history.temperature.sqrt()")
    assert "Mine.columns has NaN or infinite values; finite ones" in refused("simulate", *QUICK, "hidden=mine", source=source)


def test_what_fails_on_real_runs_only_is_named(verb, folder) -> None:
    source = changed(RETURN, "if len(history.time) > 100:\n            raise ValueError('too long for me')\n        return column.unsqueeze(-1)")
    assert verb("simulate", *QUICK, source=source)[0] == 0
    (folder / "out").rename(folder / "sim")
    code, told = verb("refine", "add=mine", "data.files=[sim/run_1.csv]", source=source)
    assert code == 1
    assert "effect 'mine': Mine.columns fails on these runs: ValueError: too long for me" in told


def test_an_effect_may_do_whatever_torch_lets_it(verb, folder) -> None:
    """Take a gradient, and write to a tensor of its own whenever it is asked."""
    kept = (
        "self.asked = getattr(self, 'asked', torch.zeros(3)).add_(1.0)\n        with torch.enable_grad():\n"
        "            here = column.detach().clone().requires_grad_()\n            column = torch.autograd.grad(here.square().sum() / 2, here)[0]"
    )
    source = changed(RETURN, f"{kept}\n        {RETURN}")
    for seed in (1, 2):
        assert verb("simulate", *QUICK, "hidden=mine", f"seed={seed}", source=source) == (0, "")
        (folder / "out").rename(folder / f"gyro_{seed}")
    files = ["data.files=[gyro_1/run_1.csv]", "data.check_files=[gyro_2/run_1.csv]"]
    code, told = verb("refine", "add=mine", "candidates=[mine]", *files, source=source)
    assert code == 0, told
