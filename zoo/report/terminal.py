"""The diagnosis in a dozen lines on the terminal; plain text where nobody watches."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console, RenderableType
from rich.markup import escape
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from zoo.report.experiment import experiment_line
from zoo.report.floors import Floors
from zoo.report.notes import merged
from zoo.report.page import scale_of
from zoo.report.probable import probable_line
from zoo.report.tables import CandidateRow, candidate_rows, ladder_rows, parameter_rows, region_rows
from zoo.report.verdict import Record, Verdict, ladder, missing, rms_after, verdict_of
from zoo.report.wording import Scale, finite, joined, names_in_model, of_parameter

COLORS = {"complete": "green", "missing": "yellow", "unknown": "red", "none": "red"}
CANDIDATES, REGIONS, NOTES = 5, 3, 5
ELSEWHERE = "# the run on another, simulated gyro, to be diagnosed by itself; your own is to be diagnosed beside these"
BAR, INDENT = 10, 2
UNLIMITED = 10_000
LONGEST_COMMAND = 1500
_ASCII = str.maketrans(
    {"°": "deg", "−": "-", "–": "-", "…": "..", "×": "x", "±": "+-", "≤": "<=", "≥": ">=", "·": "*", "Δ": "d", "µ": "u", "\u00a0": " "}
    | {"█": "#", "░": "."}
    | dict(zip("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", strict=True))
)


def print_diagnosis(diagnosis: Record, commands: Sequence[str] = (), console: Console | None = None) -> None:
    """Verdict, numbers, the best candidates, the worst regions, the next experiment, what to type next.

    Args:
        diagnosis: the contract's `diagnosis.json`; any field may be null.
        commands: what to type next, best first.
        console: to print on; by default the standard output.
    """
    scale = scale_of(diagnosis)
    with _readable(console or Console(highlight=False)) as out:
        _print_verdict(out, verdict_of(diagnosis))
        _print_numbers(out, diagnosis, scale)
        _print_values(out, missing(diagnosis), diagnosis, scale)
        rows = [row for row in candidate_rows(diagnosis, scale) if row.likely][:CANDIDATES]
        if rows:
            out.print(_indented(_first_that_fits(out, _candidate_tables(rows, scale)), 1))
            _print_twins(out, rows, diagnosis)
        _print_regions(out, diagnosis, scale)
        for note in merged(diagnosis.get("notes") or [], diagnosis.get("runs") or [])[:NOTES]:
            out.print(_indented(Text(note, style="dim")))
        tried = _print_experiment(out, diagnosis.get("next_experiment"))
        _print_commands(out, [*commands, *tried], ELSEWHERE if tried else "")


def print_ladder(
    refinement: Record, commands: Sequence[str] = (), remark: str = "", console: Console | None = None, diagnosis: Record | None = None
) -> None:
    """Verdict, and the RMS with each added effect.

    Args:
        refinement: the contract's `refinement.json`.
        commands: what to type next, best first.
        remark: on the last of them.
        console: to print on; by default the standard output.
        diagnosis: the contract's `diagnosis.json`, where it has named what was added: what else it might be is told as well.
    """
    rungs, floors = ladder({}, refinement), Floors.read({}, refinement)
    scale = Scale.of(refinement.get("unit"), floors.fitted, rungs[0].rms if rungs else None)
    with _readable(console or Console(highlight=False)) as out:
        _print_verdict(out, verdict_of({}, refinement))
        if diagnosis and (alternatives := probable_line(diagnosis)):
            out.print(_indented(Text(alternatives)))
        _print_values(out, [rung.added for rung in rungs if rung.added], refinement, scale)
        if rungs:
            out.print(_indented(_first_that_fits(out, _ladder_tables(ladder_rows(rungs, scale, floors), scale)), 1))
        check = "" if floors.checked is None else f", of the check runs {scale.full(floors.checked)}"
        out.print(_indented(Text(f"noise floor {scale.full(floors.fitted)}{check}", style="dim")))
        _print_commands(out, commands, remark)


@contextmanager
def _readable(console: Console) -> Iterator[Console]:
    """The console; on one that only knows ASCII, what is printed on it meanwhile comes out in ASCII."""
    if console.encoding.lower().startswith("utf"):
        yield console
        return
    with console.capture() as captured:
        yield console
    text = captured.get().translate(_ASCII).encode(console.encoding, errors="replace").decode(console.encoding)
    console.out(text, end="", highlight=False)


def _indented(what: RenderableType, above: int = 0) -> Padding:
    return Padding(what, (above, 0, 0, INDENT), expand=False)


def _print_verdict(out: Console, verdict: Verdict) -> None:
    out.print()
    out.print(Text(verdict.headline, style=f"bold {COLORS[verdict.kind]}"))
    for sentence in verdict.sentences:
        out.print(_indented(Text(sentence)))


def _print_numbers(out: Console, diagnosis: Record, scale: Scale) -> None:
    means = finite(diagnosis.get("average_s"))
    parts = [f"RMS{'' if means is None else f' of {means:g} s means'} {scale.full(diagnosis.get('rms'))}"]
    names = missing(diagnosis)
    if names:
        parts.append(f"with {joined(names)} {scale.full(rms_after(diagnosis, []))}")
    parts.append(f"noise floor {scale.full(Floors.read(diagnosis).fitted)}")
    out.print(_indented(Text(", ".join(parts))))
    alternatives = probable_line(diagnosis)
    if alternatives:
        out.print(_indented(Text(alternatives)))


def _print_values(out: Console, effects: Sequence[str], record: Record, scale: Scale) -> None:
    """How large, where and when what was added is, without switches that are off; nothing where it is not what it is called.

    A line an effect, and one each time of what happens several times.
    """
    parameters = {} if record.get("outdone") else record.get("parameters") or {}
    for effect in effects:
        for name in names_in_model(record, [effect]):
            known = [row for row in parameter_rows(parameters.get(name), scale) if row[1] != "0"]
            values = [of_parameter(*row) for row in known]
            if values:
                out.print(_indented(Text(f"{effect}: {', '.join(values)}")))


def _table(*columns: tuple[str, bool]) -> Table:
    """A table without lines; name and whether it holds numbers."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for i, (name, numeric) in enumerate(columns):
        # The first column holds a name: it gives way where the line is too short, and is folded.
        first: dict[str, Any] = {"overflow": "fold", "min_width": 8} if i == 0 else {"no_wrap": True, "overflow": "ellipsis"}
        table.add_column(escape(name), justify="right" if numeric else "left", **first)
    return table


def _first_that_fits(out: Console, tables: Iterable[Table]) -> Table:
    """The first of some tables, with ever fewer columns, whose every cell can be written in full; else the last."""
    anything = out.options.update(width=UNLIMITED)
    for table in tables:
        if out.measure(table, options=anything).maximum + INDENT <= out.width:
            break
    return table


def _candidate_tables(rows: list[CandidateRow], scale: Scale) -> Iterator[Table]:
    """Name, probability and RMS always; the rest as far as there is room."""
    for more, bar in ((2, BAR), (1, BAR), (0, BAR), (0, 0)):
        columns = [("candidate", False), ("probability", False), (f"RMS [{scale.label}]", True), ("cross-val.", True), ("ΔBIC", True)]
        table = _table(*columns[: 3 + more])
        for row in rows:
            name = Text(row.effect, style="bold" if row.needed else "")
            table.add_row(name, _bar(row, bar), row.rms, *(row.rms_cross_validated, row.delta_bic)[:more])
        yield table


def _bar(row: CandidateRow, width: int) -> Text:
    filled = round(width * float(row.width.rstrip("%")) / 100)
    return Text.assemble(("█" * filled, "cyan"), ("░" * (width - filled), "dim"), f" {row.probability:>6}")


def _print_twins(out: Console, rows: list[CandidateRow], diagnosis: Record) -> None:
    """On lines of their own, as they may be many; those of missing effects stand in the verdict already."""
    said = missing(diagnosis) if diagnosis.get("verdict") == "missing" else []
    parts = [f"{row.effect} from {joined(row.twins, 'or')}" for row in rows if row.twins and row.effect not in said]
    if parts:
        out.print(_indented(Text(f"not told apart: {'; '.join(parts)}", style="dim")))


def _print_regions(out: Console, diagnosis: Record, scale: Scale) -> None:
    rows = region_rows((diagnosis.get("where") or [])[:REGIONS], scale)
    columns = [("worst in", False), ("stage", False), ("from [h]", True), ("to [h]", True), ("T [°C]", True)]
    columns += [(f"RMS [{scale.label}]", True), ("× floor", True)]
    chosen = ((0, 1, 2, 3, 4, 5, 6), (0, 1, 2, 3, 5, 6), (0, 1, 5, 6))
    if rows:
        out.print(_indented(_first_that_fits(out, _tables(columns, [row[1:] for row in rows], chosen)), 1))


def _print_experiment(out: Console, experiment: Record | None) -> list[str]:
    """The run to take next, in a sentence; returns the command that tries it, unless a program of hundreds of legs makes it fill the screen."""
    line = experiment_line(experiment)
    if line is None or experiment is None:
        return []
    command = str(experiment.get("command") or "")
    elsewhere = "; the command that tries it stands in the report" if len(command) > LONGEST_COMMAND else ""
    out.print(_indented(Text(f"next experiment, {line}{elsewhere}"), 1))
    return [command] if command and not elsewhere else []


def _ladder_tables(rows: list[list[str]], scale: Scale) -> Iterator[Table]:
    columns = [("step", False), (f"RMS [{scale.label}]", True), ("× floor", True), ("check runs", True), ("× floor", True)]
    yield from _tables(columns, rows, ((0, 1, 2, 3, 4), (0, 1, 3)))


def _tables(columns: list[tuple[str, bool]], rows: list[list[str]], chosen: Sequence[Sequence[int]]) -> Iterator[Table]:
    """One table a choice of columns."""
    for choice in chosen:
        table = _table(*(columns[i] for i in choice))
        for row in rows:
            table.add_row(*(Text(row[i]) for i in choice))
        yield table


def _print_commands(out: Console, commands: Sequence[str], remark: str = "") -> None:
    """Never wrapped or shortened, so that they can be copied."""
    if commands:
        out.print("\n  next", style="dim")
    for command in commands:
        out.print(Text(f"  {command}", style="cyan"), soft_wrap=True)
    if remark:
        out.print(_indented(Text(remark, style="dim")))
    out.print()
