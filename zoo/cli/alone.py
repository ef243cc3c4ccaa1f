"""One job a folder: a sweep that was killed may have left jobs at work when it is typed again."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from zoo.artifacts import writable_folder
from zoo.errors import WorkError

LOCK = ".hydra/running.lock"
PATIENCE_S = 5.0
"""A worker whose sweep was killed needs a moment to notice."""


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
