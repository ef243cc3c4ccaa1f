"""The two ways in which a command can end badly."""

from __future__ import annotations

import difflib
import os
import sysconfig
import traceback
from collections.abc import Iterable
from pathlib import Path

OTHERS = ("<", *(f"{folder}{os.sep}" for folder in (sysconfig.get_path("stdlib"), sysconfig.get_path("purelib"), Path(__file__).parent)))
"""How files begin that the user did not write: frozen modules, Python's library, installed packages, this one."""


class InputError(ValueError):
    """What the user gave cannot be used (exit code 2).

    The message is one or two lines: which file, row, column or key, what was found, what is possible.
    """


class BadRow(InputError):
    """A row of a file lacks a number, or its time does not increase: whoever can do without it may leave it out."""


class WorkError(RuntimeError):
    """The input was fine and the work failed all the same (exit code 1)."""


class Stopped(WorkError):
    """The system asked for an end, as at a time limit: nothing else should be begun."""


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
    hint = f"did you mean {', '.join(close)}? Known" if close else "known"
    return f"{hint}: {', '.join(known)}"


def causes(error: BaseException | None) -> list[BaseException]:
    """An exception and those that led to it, the last one raised first."""
    found: list[BaseException] = []
    while error is not None and error not in found:
        found.append(error)
        error = error.__cause__ or error.__context__
    return found


def in_brief(error: BaseException) -> str:
    """Kind and text of an exception of the user's own code in one line, with the last line of theirs that it came from."""
    lines = traceback.extract_tb(error.__traceback__)
    own = [f" ({line.filename}, line {line.lineno})" for line in lines if not line.filename.startswith(OTHERS)]
    kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
    return f"{kind}{' '.join(str(error).split())}{own[-1] if own else ''}"
