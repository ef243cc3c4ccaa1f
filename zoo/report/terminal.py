"""The diagnosis in a dozen lines on the terminal; plain text where nobody watches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console, RenderableType
from rich.markup import escape
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from zoo.report.page import floor_of, scale_of
from zoo.report.tables import CandidateRow, candidate_rows, ladder_rows, region_rows
from zoo.report.verdict import Record, Verdict, ladder, missing, rms_after, verdict_of
from zoo.report.wording import Scale, finite, joined

COLORS = {"complete": "green", "missing": "yellow", "unknown": "red", "none": "red"}
CANDIDATES, REGIONS = 5, 3
BAR = 10
WIDE = 80
"""Narrower terminals get fewer columns."""
_ASCII = str.maketrans(
    {"°": "deg", "−": "-", "–": "-", "…": "..", "×": "x", "±": "+-", "·": "*", "Δ": "d", "█": "#", "░": ".", "²": "2", "µ": "u", "\u00a0": " "}
)


def print_diagnosis(diagnosis: Record, commands: Sequence[str] = (), console: Console | None = None) -> None:
    """Verdict, numbers, the best candidates, the worst regions, what to type next.

    Args:
        diagnosis: the contract's `diagnosis.json`; any field may be null.
        commands: what to type next, best first.
        console: to print on; by default the standard output.
    """
    scale = scale_of(diagnosis)
    with _readable(console or Console(highlight=False)) as out:
        _print_verdict(out, verdict_of(diagnosis))
        _print_numbers(out, diagnosis, scale)
        rows = [row for row in candidate_rows(diagnosis, scale) if row.likely][:CANDIDATES]
        if rows:
            out.print(_indented(_candidate_table(rows, scale, out.width >= WIDE), 1))
        _print_regions(out, diagnosis, scale)
        _print_commands(out, commands)


def print_ladder(refinement: Record, commands: Sequence[str] = (), console: Console | None = None) -> None:
    """Verdict, and the RMS with each added effect.

    Args:
        refinement: the contract's `refinement.json`.
        commands: what to type next, best first.
        console: to print on; by default the standard output.
    """
    rungs, floor = ladder({}, refinement), finite(refinement.get("noise_floor"))
    scale = Scale.of(refinement.get("unit"), floor, rungs[0].rms if rungs else None)
    with _readable(console or Console(highlight=False)) as out:
        _print_verdict(out, verdict_of({}, refinement))
        if rungs:
            out.print(_indented(_ladder_table(ladder_rows(rungs, scale, floor, refinement.get("noise_floor_check")), scale, out.width >= WIDE), 1))
        out.print(f"  noise floor {scale.full(floor)}", style="dim")
        _print_commands(out, commands)


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
    return Padding(what, (above, 0, 0, 2), expand=False)


def _print_verdict(out: Console, verdict: Verdict) -> None:
    out.print()
    out.print(Text(verdict.headline, style=f"bold {COLORS[verdict.kind]}"))
    for sentence in verdict.sentences:
        out.print(_indented(Text(sentence)))


def _print_numbers(out: Console, diagnosis: Record, scale: Scale) -> None:
    parts = [f"RMS {scale.full(diagnosis.get('rms'))}"]
    names = missing(diagnosis)
    if names:
        parts.append(f"with {joined(names)} {scale.full(rms_after(diagnosis, []))}")
    parts.append(f"noise floor {scale.full(floor_of(diagnosis))}")
    out.print(_indented(Text(", ".join(parts))))


def _table(*columns: tuple[str, bool]) -> Table:
    """A table without lines; name and whether it holds numbers."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for i, (name, numeric) in enumerate(columns):
        # The first column holds a name: it gives way where the line is too short, and is folded.
        first: dict[str, Any] = {"overflow": "fold", "min_width": 8} if i == 0 else {"no_wrap": True, "overflow": "ellipsis"}
        table.add_column(escape(name), justify="right" if numeric else "left", **first)
    return table


def _candidate_table(rows: list[CandidateRow], scale: Scale, wide: bool) -> Table:
    twins = any(row.twins for row in rows)
    more = [("cross-val.", True), ("ΔBIC", True), *([("not told from", False)] if twins else [])] if wide else []
    table = _table(("candidate", False), ("probability", False), (f"RMS [{scale.label}]", True), *more)
    for row in rows:
        name = Text(row.effect, style="bold" if row.needed else "")
        extra: list[Any] = [row.rms_cross_validated, row.delta_bic, *([Text(", ".join(row.twins))] if twins else [])] if wide else []
        table.add_row(name, _bar(row), row.rms, *extra)
    return table


def _bar(row: CandidateRow) -> Text:
    filled = round(BAR * float(row.width.rstrip("%")) / 100)
    return Text.assemble(("█" * filled, "cyan"), ("░" * (BAR - filled), "dim"), f" {row.probability:>6}")


def _print_regions(out: Console, diagnosis: Record, scale: Scale) -> None:
    rows = region_rows((diagnosis.get("where") or [])[:REGIONS], scale)
    if not rows:
        return
    columns = [("worst in", False), ("stage", False), ("from [h]", True), ("to [h]", True), ("T [°C]", True)]
    columns += [(f"RMS [{scale.label}]", True), ("× floor", True)]
    chosen = range(7) if out.width >= WIDE else (0, 1, 5, 6)
    table = _table(*(columns[i] for i in chosen))
    for row in rows:
        table.add_row(*(Text(row[i + 1]) for i in chosen))
    out.print(_indented(table, 1))


def _ladder_table(rows: list[list[str]], scale: Scale, wide: bool) -> Table:
    columns = [("step", False), (f"RMS [{scale.label}]", True), ("× floor", True), ("check runs", True), ("× floor", True)]
    chosen = range(5) if wide else (0, 1, 3)
    table = _table(*(columns[i] for i in chosen))
    for row in rows:
        table.add_row(*(Text(row[i]) for i in chosen))
    return table


def _print_commands(out: Console, commands: Sequence[str]) -> None:
    """Never wrapped or shortened, so that they can be copied."""
    if commands:
        out.print("\n  next", style="dim")
    for command in commands:
        out.print(Text(f"  {command}", style="cyan"), soft_wrap=True)
    out.print()
