"""What reading noticed, each thing once."""

from __future__ import annotations

from collections.abc import Iterable

from zoo.report.wording import joined

ROUTINE = (" is converted from ", "taken as recorded, every ")
"""What was asked for: told last."""


def merged(notes: list[str], runs: Iterable[str]) -> list[str]:
    """Equal notes become one, the routine ones last: with the runs that it is about where they are named, else with how often it was said.

    Args:
        notes: sentences, some of which begin with ``RUN: ``.
        runs: names of the runs.
    """
    known, about = set(runs), dict[str, list[str]]()
    for note in sorted(notes, key=lambda note: any(words in note for words in ROUTINE)):
        name, _, rest = note.partition(": ")
        text, run = (rest, name) if name in known else (note, "")
        about.setdefault(text, []).append(run)
    return [_note(text, [name for name in dict.fromkeys(names) if name], len(names)) for text, names in about.items()]


def _note(text: str, names: list[str], count: int) -> str:
    if names:
        return f"{joined(names)}: {text}"
    return text if count == 1 else f"{text} ({count} times)"
