"""Independent pieces of work in processes of their own, for what threads cannot share: much Python between small tensors."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, TypeVar

import torch

from zoo.errors import WorkError

T = TypeVar("T")
R = TypeVar("R")
MOST = 8
"""Each holds a torch of its own: half a gigabyte, and seconds to start."""
THREADS = "OMP_NUM_THREADS"
LOOK_S = 1.0

# A worker has one parent, and many jobs.
_watched: set[int] = set()


def in_processes(
    work: Callable[[T], R], items: Iterable[T], jobs: int | None = None, first: Callable[[], object] | None = None
) -> Iterator[tuple[int, R]]:
    """Yields (place of an item, its result) as they are done; each process has one thread.

    Args:
        work: a function that can be pickled, as are `items`, `first` and the results; tensors travel by value.
        items: what it is called with.
        jobs: processes; by default as many as torch was given threads, eight at most. With one, everything is done here.
        first: called once in each process before its first item.

    Raises:
        WorkError: a process was ended from outside.
        Exception: what `work` raised; what is not begun yet is left.
    """
    given = list(items)
    jobs = min(jobs or min(torch.get_num_threads(), MOST), len(given))
    if jobs < 2:
        yield from ((place, work(item)) for place, item in enumerate(given))
        return
    # Not fork: torch's threads would not be there in the copy, and their locks would.
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), _begin, (os.getpid(), pickle.dumps(first)))
    try:
        # Pickled here: multiprocessing's own pickler would keep an open file for each tensor.
        with _one_thread():
            places = {pool.submit(_do, pickle.dumps((work, item))): place for place, item in enumerate(given)}
        for done in as_completed(places):
            yield places[done], pickle.loads(done.result())
    except BrokenProcessPool as error:
        raise WorkError("a process was ended from outside; where memory ran out, fewer at a time need less: OMP_NUM_THREADS=1") from error
    finally:
        pool.shutdown(cancel_futures=True)


def end_with_parent(parent: int) -> None:
    """Ends this process once the one that started it is gone, which nobody tells a worker in the middle of its work, or waiting for more.

    Args:
        parent: its process number.
    """
    if parent in {*_watched, os.getpid()}:  # joblib with one job at a time does it itself
        return
    _watched.add(parent)

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_S)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()


@contextmanager
def _one_thread() -> Iterator[None]:
    """For processes started meanwhile: NumPy, torch and whoever asks them how many threads there are find out while they are imported."""
    before = os.environ.get(THREADS)
    os.environ[THREADS] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[THREADS]
        else:
            os.environ[THREADS] = before


def _begin(parent: int, first: bytes) -> None:
    end_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C reaches all of them; only the parent has to say so
    call: Any = pickle.loads(first)
    if call is not None:
        call()


def _do(task: bytes) -> bytes:
    work, item = pickle.loads(task)
    return pickle.dumps(work(item))
