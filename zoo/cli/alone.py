"""One job a folder: a sweep that was killed may have left jobs at work when it is typed again."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from zoo.artifacts import writable_folder
from zoo.errors import WorkError

LOCK = ".hydra/running.lock"
PATIENCE_S = 5.0
"""A worker whose sweep was killed needs a moment to notice."""
LOOK_S = 1.0


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keeps other jobs from a folder; the system opens it again when the process ends, however it does.

    Raises:
        WorkError: another process is at work there.
    """
    path = folder / LOCK
    lock = FileLock(writable_folder(path.parent) / path.name, timeout=PATIENCE_S)
    try:
        lock.acquire()
    except Timeout as error:
        raise WorkError(f"{folder}: another process is still at work there; let it finish, and type the same command again") from error
    try:
        yield
    finally:
        lock.release()


@contextmanager
def ending_with_parent() -> Iterator[None]:
    """Ends this process when the one that started it is gone, which nobody tells a worker in the middle of its work."""
    parent, over = os.getppid(), threading.Event()

    def look() -> None:
        while not over.wait(LOOK_S):
            if os.getppid() != parent:
                os._exit(1)

    threading.Thread(target=look, daemon=True).start()
    try:
        yield
    finally:
        over.set()
