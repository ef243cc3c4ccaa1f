"""The two ways in which a command can end badly."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class InputError(ValueError):
    """What the user gave cannot be used (exit code 2).

    The message is one or two lines: which file, row, column or key, what was found, what is possible.
    """


class WorkError(RuntimeError):
    """The input was fine and the work failed all the same (exit code 1)."""


def nearest(name: str, known: Iterable[str]) -> str:
    """The known names closest to a mistyped one, as the end of an error message.

    Args:
        name: what was given.
        known: what would have been possible.

    Returns:
        ``"did you mean a, b? Known: ..."``, or just the known names where none is close.
    """
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=3, cutoff=0.4)
    hint = f"did you mean {', '.join(close)}? " if close else ""
    return f"{hint}Known: {', '.join(known)}"
