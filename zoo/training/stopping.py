"""An end that the system asks for, as at a time limit."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

from zoo.errors import Stopped

STOPPED = "stopped by the system (SIGTERM), as at a time limit; the same command in the same folder goes on from there"


@contextmanager
def stoppable() -> Iterator[None]:
    """Makes a request to end an error that says what to do, within; in other threads than the main one, which hear of none, nothing changes.

    Raises:
        Stopped: the request came.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> NoReturn:
        raise Stopped(STOPPED)

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
