"""Models side by side on the terminal: a table a run, a row a model, a column a kind of stage."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

UNLIMITED = 10_000
EVERYWHERE = "all runs"
"""What the pooled RMS is headed by."""


def print_comparison(title: str, rows: list[dict[str, Any]], columns: list[str], pooled: dict[str, float], console: Console | None = None) -> None:
    """Print one table a run, and the RMS over all where there are several. Numbers are never cut, however narrow the terminal.

    Args:
        title: quantity and unit.
        rows: ``{"run": ..., "stage": ..., "blocks": ..., COLUMN: rms}``, one a run and stage.
        columns: the uncompensated error first, then the models.
        pooled: RMS over all runs by column.
        console: to print on; by default the standard output.
    """
    out = console or Console(highlight=False)
    out.print(Text(f"\n{title}", style="bold"))
    tables = [_table(run, [row for row in rows if row["run"] == run], columns) for run in dict.fromkeys(row["run"] for row in rows)]
    if len(tables) > 1:
        tables.append(_table(EVERYWHERE, [{"stage": "whole", **pooled}], columns))
    # A file or a pipe has no width, and a line that is too long is better than numbers cut in the middle.
    needed = max(out.measure(table, options=out.options.update(width=UNLIMITED)).maximum for table in tables)
    for table in tables:
        out.print()
        out.print(table, width=None if out.is_terminal else max(needed, out.width), crop=False)


def _table(run: str, rows: list[dict[str, Any]], columns: list[str]) -> Table:
    """Best values are bold; names are folded where the line is too short."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    table.add_column(Text(run, style="bold not dim"), overflow="fold", min_width=8)
    for row in rows:
        table.add_column(row["stage"], justify="right", no_wrap=True, min_width=_widest(row, columns))
    if all("blocks" in row for row in rows):
        table.add_row(Text("blocks", style="dim"), *(Text(str(row["blocks"]), style="dim") for row in rows))
    for name in columns:
        table.add_row(Text(name), *(_cell(row, name, columns) for row in rows))
    return table


def _widest(row: dict[str, Any], columns: list[str]) -> int:
    return max(len(row["stage"]), *(len(_number(row[name])) for name in columns))


def _cell(row: dict[str, Any], name: str, columns: list[str]) -> Text:
    return Text(_number(row[name]), style="bold" if row[name] == min(row[one] for one in columns) else "")


def _number(value: float) -> str:
    return f"{value:#.3g}"
