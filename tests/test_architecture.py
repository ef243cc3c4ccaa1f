"""The house rules that a machine can check; a failure names the file, the line and the arrow that points the wrong way."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from zoo.catalog import build, names
from zoo.cli.application import VERBS
from zoo.effects.base import Effect

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted((ROOT / "zoo").rglob("*.py"))

RANK = {
    "errors": 0, "given": 0, "units": 0, "artifacts": 0, "side_by_side": 0, "ahead": 0, "processes": 0, "threads": 0, "progress": 0,
    "physics": 1, "swarm": 1, "scoring": 1,
    "effects": 2, "measurements": 2,
    "models": 3, "simulator": 3,
    "fitting": 3.5,  # between the models and those who fit them
    "training": 4, "diagnosis": 4, "papers": 4,
    "export": 5, "report": 5, "comparison": 5, "compensation": 5,
    "catalog": 6,
    "cli": 7,
}  # fmt: skip
SIBLINGS = {("units", "errors"), ("given", "errors"), ("artifacts", "errors"), ("processes", "errors"), ("ahead", "side_by_side")}
"""Imports within a rank that are allowed; everything else goes downwards or stays at home."""

ONLY_IN = {
    ("lightning", "pytorch_lightning"): ("training/", "measurements/datamodule.py"),
    ("hydra", "omegaconf"): ("catalog.py", "cli/"),
    ("matplotlib", "mpl_toolkits", "jinja2"): ("report/",),
    ("pandas", "pyarrow"): ("measurements/", "simulator/", "cli/"),
}
VAGUE = {"utils", "util", "helpers", "helper", "common", "misc", "tools", "stuff"}
LONGEST_FILE, LONGEST_FUNCTION, LONGEST_DOOR = 400, 60, 5

GLOBAL_STATE = {
    "torch.manual_seed", "torch.seed", "torch.cuda.manual_seed", "torch.cuda.manual_seed_all", "torch.set_default_dtype",
    "torch.set_default_device", "random.seed", "np.random.seed", "numpy.random.seed", "seed_everything", "lightning.seed_everything",
}  # fmt: skip
WARNING_FILTERS = {"warnings.filterwarnings", "warnings.simplefilter"}
DRAWS = {f"torch.{name}" for name in ("rand", "randn", "randint", "randperm", "normal", "bernoulli", "multinomial", "poisson")}


def place(path: Path) -> str:
    return path.relative_to(ROOT / "zoo").as_posix()


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path: Path) -> Iterator[tuple[int, str]]:
    """Line and dotted name of all that a file imports, also inside functions and for type checking only."""
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"zoo/{place(path)}:{node.lineno}: a relative import; write from zoo.… import …"
            whole = [f"zoo.{alias.name}" for alias in node.names] if node.module == "zoo" else [str(node.module)]
            yield from ((node.lineno, name) for name in whole)


def calls(path: Path) -> Iterator[tuple[ast.Call, str]]:
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Call):
            yield node, ast.unparse(node.func)


def functions(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


def length(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without its docstring."""
    said = function.body[0] if ast.get_docstring(function) is not None else None
    return (function.end_lineno or 0) - function.lineno + 1 - ((said.end_lineno or 0) - said.lineno + 1 if said else 0)


def undocumented(node: ast.Module | ast.ClassDef, prefix: str = "") -> Iterator[tuple[int, str]]:
    """Public classes, functions and methods without a docstring."""
    for child in node.body:
        if isinstance(child, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and not child.name.startswith("_"):
            if ast.get_docstring(child) is None:
                yield child.lineno, prefix + child.name
            if isinstance(child, ast.ClassDef):
                yield from undocumented(child, f"{child.name}.")


def put_back(path: Path) -> set[ast.AST]:
    """All that stands inside `with warnings.catch_warnings()`."""
    blocks = [node for node in ast.walk(parsed(path)) if isinstance(node, ast.With) and "catch_warnings" in ast.unparse(node.items[0])]
    return {inner for block in blocks for inner in ast.walk(block)}


def check_none(wrong: list[str]) -> None:
    assert not wrong, "\n" + "\n".join(wrong)


def test_every_room_has_a_rank() -> None:
    rooms = {Path(place(path)).parts[0].removesuffix(".py") for path in FILES}
    check_none([f"zoo/{room}: has no rank in RANK" for room in rooms - {*RANK, "__init__"}])


def test_arrows_point_down() -> None:
    wrong = []
    for path in FILES:
        home = Path(place(path)).parts[0].removesuffix(".py")
        for line, name in imports(path):
            top, _, rest = name.partition(".")
            room = rest.split(".")[0]
            known = top == "zoo" and home in RANK and room in RANK and room != home
            if known and (home, room) not in SIBLINGS and not RANK[home] > RANK[room]:
                wrong.append(f"zoo/{place(path)}:{line}: {home} (rank {RANK[home]}) -> {room} (rank {RANK[room]}), by {name}")
    check_none(wrong)


def test_libraries_stay_in_their_rooms() -> None:
    wrong = []
    for path in FILES:
        for line, name in imports(path):
            for libraries, rooms in ONLY_IN.items():
                if name.split(".")[0] in libraries and not place(path).startswith(rooms):
                    wrong.append(f"zoo/{place(path)}:{line}: imports {name}, which belongs in {', '.join(rooms)}")
    check_none(wrong)


def test_files_and_functions_are_short() -> None:
    wrong = []
    for path in FILES:
        lines = len(path.read_text(encoding="utf-8").splitlines())
        wrong += [f"zoo/{place(path)}: {lines} lines, {LONGEST_FILE} at most"] if lines > LONGEST_FILE else []
        wrong += [
            f"zoo/{place(path)}:{one.lineno}: {one.name} has {length(one)} lines, {LONGEST_FUNCTION} at most"
            for one in functions(parsed(path))
            if length(one) > LONGEST_FUNCTION
        ]
    check_none(wrong)


def test_names_say_something() -> None:
    check_none([f"zoo/{place(path)}: name the thing" for path in FILES if VAGUE & {Path(part).stem for part in Path(place(path)).parts}])


def test_everything_public_says_what_it_is() -> None:
    check_none([f"zoo/{place(path)}:{line}: {name} has no docstring" for path in FILES for line, name in undocumented(parsed(path))])


def test_nothing_global_is_set() -> None:
    wrong = []
    for path in FILES:
        undone = put_back(path)
        for call, name in calls(path):
            if name in GLOBAL_STATE or (name in WARNING_FILTERS and call not in undone):
                wrong.append(f"zoo/{place(path)}:{call.lineno}: {name} changes the state of the whole process")
    check_none(wrong)


def test_every_draw_takes_a_generator() -> None:
    wrong = []
    for path in FILES:
        for call, name in calls(path):
            given = {keyword.arg for keyword in call.keywords}
            in_place = name.startswith(("nn.init.", "torch.nn.init.")) and name.endswith("_") and not name.endswith(("zeros_", "ones_", "constant_"))
            in_place = in_place or name.endswith((".normal_", ".uniform_", ".exponential_", ".cauchy_", ".random_"))
            if (name in DRAWS or in_place) and not given & {"generator", None}:
                wrong.append(f"zoo/{place(path)}:{call.lineno}: {name} draws without generator=")
            if name.startswith(("np.random.", "numpy.random.")):
                wrong.append(f"zoo/{place(path)}:{call.lineno}: {name}; draw from a torch.Generator")
    check_none(wrong)


@pytest.mark.parametrize("verb", VERBS)
def test_a_script_is_only_a_door(verb: str) -> None:
    lines = [line for line in (ROOT / "scripts" / f"{verb}.py").read_text(encoding="utf-8").splitlines() if line.strip()]
    assert len(lines) <= LONGEST_DOOR
    assert f'run("{verb}", sys.argv[1:])' in lines[-1]


@pytest.mark.parametrize("name", names("effects"))
def test_an_effect_of_the_catalogue_is_called_as_its_file(name: str) -> None:
    effect = build("effects", name)
    assert isinstance(effect, Effect)
    assert effect.name == type(effect).name == name
    assert type(effect).__module__ == f"zoo.effects.{name}"
