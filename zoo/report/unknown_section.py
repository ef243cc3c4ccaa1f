"""The part of the page on what nothing in the catalogue explains: what it looks like, in words, and a class to start from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from zoo.report.canvas import inline_svg
from zoo.report.palette import styled
from zoo.report.template import filled
from zoo.report.unknown_figure import unknown_figure
from zoo.report.unknown_stub import stub_of
from zoo.report.verdict import Record
from zoo.report.wording import Scale, joined


def unknown_section(
    diagnosis: Record, scale: Scale, folder: str | Path, refine: Sequence[str] = ("fogzoo", "refine"), done: bool = False
) -> Markup | None:
    """The section "What it looks like"; None where the diagnosis describes nothing.

    Args:
        diagnosis: with the fields of `zoo.diagnosis.description.Description.record`.
        scale: how values are written.
        folder: where the stub is written, see `zoo.report.unknown_stub.write_stub`.
        refine: the words of the command that refines, with the settings of the diagnosis.
        done: whether effects were added since.
    """
    stub = stub_of(diagnosis)
    if stub is None:
        return None
    context = {
        "done": done,
        "words": diagnosis["unexplained_words"],
        "panels": [_panel(entry, scale, i) for i, entry in enumerate(_drawable(diagnosis))],
        "form": diagnosis["unexplained_form"],
        "rms": scale.full(diagnosis.get("rms")),
        "after": scale.full(diagnosis["unexplained_form"]["rms"]),
        "stub": stub,
        "commands": stub.commands(folder, refine),
        "folder": str(folder),
    }
    return Markup(filled("unknown.html.j2", context))


def _drawable(diagnosis: Record) -> list[dict[str, Any]]:
    return [entry for entry in diagnosis.get("unexplained") or [] if entry.get("curves")]


def _panel(entry: dict[str, Any], scale: Scale, number: int) -> dict[str, Any]:
    """A drawing and what is said below it."""
    with styled(f"u{number}"):
        drawing = inline_svg(unknown_figure(entry, scale), f"The unexplained part against {entry['depends_on']}. {entry['words']}")
    as_good = f"As good: {joined(entry['as_good'], 'or')}." if entry.get("as_good") else ""
    return {"drawing": drawing, "words": entry["words"], "as_good": as_good}
