"""The page, written by a copy of this process that has imported what draws while the search went on: that takes as long as the drawing."""

from __future__ import annotations

from contextlib import AbstractContextManager

from zoo.ahead import Ahead, ahead


def page_ahead() -> AbstractContextManager[Ahead]:
    """`zoo.report.page.write_report`, to be begun when all is known."""
    return ahead(_draw_nothing, _write)


def _draw_nothing() -> None:
    from zoo.report.canvas import blank, inline_svg

    inline_svg(blank(1, 1), "")


def _write(*values: object, **named: object) -> None:
    from zoo.report.page import write_report

    write_report(*values, **named)  # type: ignore[arg-type]
