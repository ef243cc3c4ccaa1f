"""A class to start from for an effect that nothing in the catalogue is, as Python source and YAML, and what to type to use it."""

from __future__ import annotations

import inspect
import json
import re
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path
from typing import Any

from zoo.artifacts import write_text
from zoo.diagnosis import forms, quantities
from zoo.effects.base import Parameter
from zoo.given import in_quotes
from zoo.report.verdict import Record
from zoo.report.wording import joined, significant

NAME = "unexplained"
"""Of the class; of another beside it with a number."""
SEARCHPATH = "hydra.searchpath="
WIDTH = 140
"""Longest line of the source."""


@dataclass(frozen=True)
class Stub:
    """What to write, and where below a folder.

    Attributes:
        name: that no effect of the diagnosis has.
        source: of `<name>.py`.
        yaml: of `conf/effects/<name>.yaml`.
        beside: effects that are to be added before it.
    """

    name: str
    source: str
    yaml: str
    beside: tuple[str, ...] = ()

    def commands(self, folder: str | Path, refine: Sequence[str] = ("fogzoo", "refine")) -> list[str]:
        """What to type to refit with the class as it stands.

        Args:
            folder: where the files were written.
            refine: the words of the command, with the settings of the diagnosis; a search path among them is kept, and with it Python's.
        """
        place = Path(folder).resolve()
        given = [word.removeprefix(SEARCHPATH).strip("[]") for word in refine if word.startswith(SEARCHPATH)]
        folders = ",".join([*given, in_quotes(f"file://{place / 'conf'}")])
        add = f"[{','.join([*self.beside, self.name])}]" if self.beside else self.name
        typed = [*refine[:2], f"add={add}", *(word for word in refine[2:] if not word.startswith(SEARCHPATH)), f"{SEARCHPATH}[{folders}]"]
        return [f"export PYTHONPATH={shlex.quote(str(place))}{':$PYTHONPATH' if given else ''}", shlex.join(typed)]


def stub_of(diagnosis: Record) -> Stub | None:
    """The class for what a diagnosis could not explain; None where it describes no form.

    Args:
        diagnosis: its `unexplained_form` names functions of `zoo.diagnosis.forms` and `quantities`, whose source is copied: what is written is
            what was tried.
    """
    form = diagnosis.get("unexplained_form")
    if not form:
        return None
    beside = tuple(name for name in form.get("effects") or () if name not in (diagnosis.get("effects") or form["effects"]))
    name = _free_name(diagnosis)
    return Stub(name, _source(name, form, diagnosis), f"{name}:\n  _target_: {name}.Unexplained\n", beside)


def _free_name(diagnosis: Record) -> str:
    """That of no effect which is in the model or the catalogue: such as the class that an earlier diagnosis has written."""
    form, candidates = diagnosis["unexplained_form"], diagnosis.get("candidates") or ()
    taken = {*(form.get("effects") or ()), *(one["effect"] for one in candidates)}
    taken.update(*(diagnosis.get(key) or () for key in ("effects", "not_tried", "left_out")))
    return next(name for name in chain([NAME], (f"{NAME}_{number}" for number in count(2))) if name not in taken)


def write_stub(diagnosis: Record, folder: str | Path) -> Path | None:
    """Write the class and `conf/effects/<name>.yaml`; returns the former's path, None where there is nothing to write.

    Args:
        diagnosis: see `stub_of`.
        folder: of the report.
    """
    stub = stub_of(diagnosis)
    if stub is None:
        return None
    write_text(Path(folder) / "conf" / "effects" / f"{stub.name}.yaml", stub.yaml)
    return write_text(Path(folder) / f"{stub.name}.py", stub.source)


def stub_line(path: Path) -> str:
    """The line for the terminal."""
    return f"a class to start from: {path}"


def _source(name: str, form: Record, diagnosis: Record) -> str:
    methods = [_method(getattr(forms, form["columns"]), "columns"), _method(getattr(quantities, form["quantity"]), "quantity")]
    body = "\n\n".join(methods)
    imports = ["import torch"] if "torch." in body else []
    imports += ["from torch import Tensor", "", "from zoo.effects.base import Effect, History, Parameter" + (", spread" if "spread(" in body else "")]
    lags = [name for name in ("behind", "lagged") if f"{name}(" in body]
    imports += [f"from zoo.physics.lag import {', '.join(lags)}"] if lags else []
    lines = [
        '"""An effect that is in no catalogue yet."""',
        "",
        *imports,
        "",
        "",
        "class Unexplained(Effect):",
        *_docstring(form, diagnosis),
        "",
        f'    name = "{name}"',
        f'    place = "{form["place"]}"',
        *([f"    needs = ({', '.join(map(_quoted, form['needs']))},)"] if form["needs"] else []),
        *_parameters("shape", form["shape"]),
        *_parameters("amplitudes", form["amplitudes"]),
        f"    formula = {_quoted(form['formula'])}",
        f"    source = {_quoted('found by fogzoo diagnose in ' + joined(form['runs']))}",
        f"    signature = {_quoted(form['words'])}",
        *([f"    low, high = {form['range'][0]!r}, {form['range'][1]!r}"] if "self.low" in body else []),
        "",
    ]
    return "\n".join([*lines, body, ""])


def _docstring(form: Record, diagnosis: Record) -> list[str]:
    """What was found, and what is left to do."""
    now, after = (f"{significant(value)} {diagnosis.get('unit')}" for value in (diagnosis.get("rms"), form["rms"]))
    if form["todo"]:
        told = ["TODO: nothing smooth explains the residual; the columns below are only an example of how they are written."]
    else:
        told = [
            f"With it the RMS falls from {now} to {after}.",
            "TODO: say what makes it, give it a name, and narrow the bounds to what is physical.",
        ]
    return [f'    """Error {form["formula"]}, x = {form["depends_on"]}.'.replace(", x =", ", with"), "", *_wrapped([form["words"], *told]), '    """']


def _wrapped(sentences: list[str]) -> list[str]:
    """Lines of text, indented, no longer than the house allows."""
    lines: list[str] = []
    for sentence in sentences:
        line = "   "
        for word in sentence.split():
            if len(line) + len(word) + 1 > WIDTH:
                lines.append(line)
                line = "   "
            line += f" {word}"
        lines.append(line)
    return lines


def _parameters(kind: str, declared: list[dict[str, Any]]) -> list[str]:
    """A tuple of declarations, one a line."""
    if not declared:
        return []
    return [f"    {kind} = (", *(f"        {_parameter(one)}," for one in declared), "    )"]


def _parameter(one: dict[str, Any]) -> str:
    scale = [] if one["scale"] == "linear" else [_quoted(one["scale"])]
    more = [f"{key}={_quoted(one[key])}" for key in ("source", "meaning") if one[key]]
    grid = [f"grid={one['grid']}"] if one["grid"] != Parameter.grid else []
    first = [_quoted(one["name"]), repr(one["default"]), _quoted(one["unit"]), repr(one["low"]), repr(one["high"])]
    return f"Parameter({', '.join([*first, *scale, *more, *grid])})"


def _quoted(text: str) -> str:
    """A string as source text."""
    return json.dumps(text, ensure_ascii=False)


def _method(function: Callable[..., Any], name: str) -> str:
    """A function's source as a method of another name."""
    text = re.sub(r"^def \w+\(self: Any", f"def {name}(self", inspect.getsource(function))
    return "\n".join(f"    {line}".rstrip() for line in text.rstrip().split("\n"))
