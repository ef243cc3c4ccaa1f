"""Ctrl-C: one line and the exit code that shells use for it. Light to import, since it has to stand guard before anything heavy is."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

INTERRUPTED = 130
MESSAGE = "interrupted; results are written whole or not at all"


def tell_interrupted() -> int:
    """Says so; returns the exit code."""
    print(MESSAGE, file=sys.stderr)
    return INTERRUPTED


@contextmanager
def leaving_at_once() -> Iterator[None]:
    """For imports: Ctrl-C ends the process there and then.

    An exception would be a traceback through the import machinery, or be lost in a C extension that was importing another module.
    """
    # Who started the process in the background has Ctrl-C ignored, and only the main thread may say what a signal does.
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not usual or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, _leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _leave(*_: object) -> None:
    # Not print: the signal may have come in the middle of one.
    os.write(2, f"{MESSAGE}\n".encode())
    os._exit(INTERRUPTED)
