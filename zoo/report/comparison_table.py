"""Methods side by side on the terminal: a table a run, a row a method, a column a kind of stage; then those that decide, and the differences."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from zoo.report.comparison_page import scale_of, stage_rows
from zoo.report.comparison_words import judges, notes, statement, whole_noise
from zoo.report.wording import times
from zoo.scoring.comparison import TOGETHER, UNCOMPENSATED

UNLIMITED = 10_000
STATED = 6
"""Pairs put into words; the page has the others."""


def print_comparison(document: dict[str, Any], console: Console | None = None) -> None:
    """Print one table a run, and one of those that decide with the noise floor. Numbers are never cut, however narrow the terminal.

    Args:
        document: `comparison.json`.
        console: to print on; by default the standard output.
    """
    out = console or Console(highlight=False)
    scale = scale_of(document)
    title = f"RMS of the error [{scale.label}], {document['average_s']:g} s means"
    out.print(Text(f"\n{title}{', median over seeds' if any(one['distinct'] > 1 for one in document['methods']) else ''}", style="bold"))
    labels = _labels(document)
    rows = [row | {name: row[name][0] * scale.factor for name in labels} for row in stage_rows(document)]
    runs = [run for run in dict.fromkeys(row["run"] for row in rows) if run not in TOGETHER]
    tables = [*(_table(run, [row for row in rows if row["run"] == run], labels) for run in runs), _summary(document, labels, scale.factor)]
    # A file or a pipe has no width, and a line that is too long is better than numbers cut in the middle.
    needed = max(out.measure(table, options=out.options.update(width=UNLIMITED)).maximum for table in tables)
    for table in tables:
        out.print()
        out.print(table, width=None if out.is_terminal else max(needed, out.width), crop=False)
    out.print()
    for pair in document["pairs"][:STATED]:
        out.print(Text(f"{statement(pair)}."))
    for note in notes(document):
        out.print(Text(note, style="yellow"))


def _labels(document: dict[str, Any]) -> dict[str, str]:
    """What is shown, by the methods' names: with how many models there are."""
    labels = {UNCOMPENSATED: UNCOMPENSATED}
    for one in document["methods"]:
        count = f" ({one['distinct']} seeds)" if one["distinct"] > 1 else f" ({len(one['models'])} ×)" if len(one["models"]) > 1 else ""
        labels[one["name"]] = one["name"] + count
    return labels


def _table(run: str, rows: list[dict[str, Any]], labels: dict[str, str]) -> Table:
    """Best values are bold; names are folded where the line is too short."""
    table = _blank(run)
    for row in rows:
        table.add_column(row["stage"], justify="right", no_wrap=True, min_width=max(len(row["stage"]), *(len(_number(row[name])) for name in labels)))
    table.add_row(Text("blocks", style="dim"), *(Text(str(row["blocks"]), style="dim") for row in rows))
    for name, label in labels.items():
        table.add_row(Text(label), *(_cell(row[name], min(row[one] for one in labels)) for row in rows))
    return table


def _summary(document: dict[str, Any], labels: dict[str, str], factor: float) -> Table:
    """The runs that decide: the median, the range of 90 % of the seeds, and the distance from the noise."""
    table = _blank(judges(document))
    several = any(one["distinct"] > 1 for one in document["methods"])
    for head in ("RMS", *(["90 % of seeds"] if several else []), "× floor"):
        table.add_column(head, justify="right", no_wrap=True)
    empty = [""] if several else []
    bare, floor = document["rms"][UNCOMPENSATED] * factor, document["noise_floor"] * factor
    table.add_row(Text("noise floor" if whole_noise(document) else "noise floor, white", style="dim"), Text(_number(floor), style="dim"), *empty, "")
    table.add_row(UNCOMPENSATED, _number(bare), *empty, times(bare / floor))
    medians = [one["rms"]["median"] * factor for one in document["methods"]]
    for one, median in zip(document["methods"], medians, strict=True):
        spread = [" … ".join(_number(one["rms"][end] * factor) for end in ("low", "high"))] if one["distinct"] > 1 else empty
        table.add_row(Text(labels[one["name"]]), _cell(median, medians[0]), *spread, times(one["excess"]))
    return table


def _blank(head: str) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    table.add_column(Text(head, style="bold not dim"), overflow="fold", min_width=8)
    return table


def _cell(value: float, best: float) -> Text:
    return Text(_number(value), style="bold" if value == best else "")


def _number(value: float) -> str:
    return f"{value:#.3g}" if value < 999.5 else f"{value:.0f}"
