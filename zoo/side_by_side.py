"""Independent pieces of work on several cores, by copies of this process: they know all that it knows, and give back their results.

Threads share Python's lock, and between small tensors they wait for it longer than they work. A fresh process, as in `zoo.processes`, would first
have to import torch and to be sent everything.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import select
import selectors
import signal
import struct
import sys
import threading
import time
import warnings
from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, TypeVar

import torch

T = TypeVar("T")
R = TypeVar("R")
MOST = 4
ALLOWED = min(torch.get_num_threads(), MOST)
"""As many as torch was given threads when the program started: OMP_NUM_THREADS=1 makes it one."""
COPIES = sys.platform == "linux"
"""Elsewhere the system's own libraries do not stand being copied while they run."""
PATIENCE_S = 20.0
"""How much longer than all that was done here a copy may take for the last item that it took."""
GRACE_S = 1.0
"""How long the next part of a result is waited for at least, once it has begun to come."""
PLACE = struct.Struct("I")
PART = 1 << 20
"""Bytes of a result that are read at once, at most."""
PARENT_GONE = 1
"""Linux's PR_SET_PDEATHSIG."""
WORTH_S = 0.3
"""What would last less in one process stays there: whatever either process writes to after it was copied, the system has to copy as well."""

_busy: ContextVar[bool] = ContextVar("busy", default=False)
_memory: ContextVar[dict[int, tuple[Any, Any]] | None] = ContextVar("memory", default=None)
_paces: dict[Hashable, float] = {}
"""Seconds that an item took when this work was last done, by its code."""


def side_by_side(work: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """The results for each item, in their order, by this process and copies of it, with one core each.

    Where only one is allowed, within one of them, in another thread than the main one, and where a GPU works, one item is done after the other; so
    are those of work that was short the last time, until they show that the rest is worth copies. What a copy does not bring, for whatever reason, is
    done here, so that errors are raised as ever. Each of several finds what was remembered before the first, and leaves nothing to the next: see
    `of_item`.

    Args:
        work: must not need what it does for another item, nor tell anybody of it: what it leaves behind besides its result is lost in a copy, and
            the lock of a progress bar may be held in it for ever. Its results can be pickled.
        items: what it is called with, a thousand at most.
    """
    given = list(items)
    if len(given) < 2:
        return [work(item) for item in given]
    kind: Hashable = getattr(work, "__code__", None)
    work = _forgetful(work)
    if not copies_allowed() or len(given) * PLACE.size > select.PIPE_BUF:
        return [work(item) for item in given]
    begun, pace, done = time.monotonic(), _paces.get(kind), list[R]()
    with _alone():
        while len(done) < len(given) and pace is not None and pace * (len(given) - len(done)) < WORTH_S:
            done.append(work(given[len(done)]))
            pace = (time.monotonic() - begun) / len(done)
    rest = given[len(done) :]
    workers = max(min(ALLOWED, len(rest)), 1)
    found = _shared(work, rest, workers) if rest else []
    _paces[kind] = (time.monotonic() - begun) * workers / len(given)
    return [*done, *found]


def copies_allowed() -> bool:
    """Whether this process may be copied, for work on another core."""
    elsewhere = _busy.get() or threading.current_thread() is not threading.main_thread() or torch.cuda.is_initialized()
    return ALLOWED > 1 and COPIES and not elsewhere


def of_item(shared: R, make: Callable[[], R]) -> R:
    """A memory for the item that is being worked on, beside one that all share; between items that one itself.

    What is computed of many things at once differs, by its last digits, from the same computed of few. Remembered by one item and found by another,
    it would make results depend on which process did which.

    Args:
        shared: what remembers.
        make: an empty one.
    """
    memory = _memory.get()
    if memory is None:
        return shared
    if id(shared) not in memory:
        memory[id(shared)] = shared, make()
    return memory[id(shared)][1]


def _forgetful(work: Callable[[T], R]) -> Callable[[T], R]:
    """The same work with a memory of its own for each item; an item within an item has that of the outer one."""

    def alone(item: T) -> R:
        token = _memory.set({} if _memory.get() is None else _memory.get())
        try:
            return work(item)
        finally:
            _memory.reset(token)

    return alone


def _shared(work: Callable[[T], R], given: list[T], workers: int) -> list[R]:
    """The results for each item by so many processes, of which this is one."""
    begun, found = time.monotonic(), dict[int, R]()
    copies: list[Copy] = []
    with _queue(len(given)) as queue:
        try:
            with _alone(), suppress(OSError):  # no more processes, or no memory for one
                while len(copies) < workers - 1:
                    copies.append(copy_of_this(lambda: _done(work, given, queue)))
            with _alone():
                found = {place: work(given[place]) for place in _taken(queue)}
            until = time.monotonic() + PATIENCE_S + (time.monotonic() - begun)
            for copy in copies:
                found |= copy.result(until - time.monotonic()) or {}
        finally:
            for copy in copies:
                copy.end()
    with _alone():
        return [found[place] if place in found else work(item) for place, item in enumerate(given)]


@contextmanager
def _alone() -> Iterator[None]:
    """One core, and no copies of copies."""
    threads, token = torch.get_num_threads(), _busy.set(True)
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
        _busy.reset(token)


@contextmanager
def _queue(items: int) -> Iterator[int]:
    """A pipe that holds the place of every item: whoever is free reads the next."""
    queue, writing = os.pipe()
    os.write(writing, b"".join(PLACE.pack(place) for place in range(items)))
    os.close(writing)
    try:
        yield queue
    finally:
        os.close(queue)


def _taken(queue: int) -> Iterator[int]:
    """Places of items that nobody else has taken."""
    while place := os.read(queue, PLACE.size):
        yield PLACE.unpack(place)[0]


def _done(work: Callable[[T], R], given: list[T], queue: int) -> dict[int, R]:
    """The results of the items that were free, by their places."""
    found: dict[int, R] = {}
    with suppress(Exception):  # done again, and raised, where it can be told
        for place in _taken(queue):
            found[place] = work(given[place])
    return found


@dataclass(frozen=True)
class Copy:
    """A copy of this process, and where it writes its result to."""

    process: int
    output: int

    def result(self, patience_s: float) -> Any:
        """What it came to; None where that has not come by then, is broken off or cannot be made again here."""
        until, written = time.monotonic() + patience_s, bytearray()
        with selectors.DefaultSelector() as output:
            output.register(self.output, selectors.EVENT_READ)
            while output.select(max(until - time.monotonic(), GRACE_S if written else 0.0)):
                if not (part := os.read(self.output, PART)):
                    with suppress(Exception):
                        return pickle.loads(written)
                    break
                written += part
        return None

    def end(self) -> None:
        """Whether it is done or not."""
        os.close(self.output)
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)


def copy_of_this(body: Callable[[], Any]) -> Copy:
    """A copy of this process that does one thing, whose result it gives back, and ends.

    Raises:
        OSError: the system gives no further process.
    """
    output, writing = os.pipe()
    this = os.getpid()
    try:
        with warnings.catch_warnings():
            # Python warns of other threads: theirs do not go on in the copy. On one core torch has none, and a progress bar's is not called upon.
            warnings.simplefilter("ignore", DeprecationWarning)
            process = os.fork()
    except OSError:
        os.close(output)
        os.close(writing)
        raise
    if process:
        os.close(writing)
        return Copy(process, output)
    try:
        _end_with(this)
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        found = body()
        with os.fdopen(writing, "wb") as stream:
            pickle.dump(found, stream, pickle.HIGHEST_PROTOCOL)
    finally:
        os._exit(0)


def _end_with(parent: int) -> None:
    """Have the system end this copy when that process is gone, however it went: nobody would take what it brings."""
    ctypes.CDLL(None).prctl(PARENT_GONE, signal.SIGKILL)
    if os.getppid() != parent:  # gone before that
        os._exit(0)
