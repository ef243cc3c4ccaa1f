"""Independent pieces of work on several cores."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import torch

T = TypeVar("T")
R = TypeVar("R")
MOST = 4
"""More would wait for Python's lock rather than work."""
ALLOWED = min(torch.get_num_threads(), MOST)
"""As many as torch was given when the program started: OMP_NUM_THREADS=1 makes it one."""


def side_by_side(work: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """The results for each item, in their order, by threads with one core each: torch lets go of Python's lock while it computes.

    For large products only: with small tensors, threads wait for the lock longer than they work. Within one of these threads, and where only one is
    allowed, one item is done after the other.

    Args:
        work: must not need what it does for another item.
        items: what it is called with.
    """
    given = list(items)
    if min(ALLOWED, len(given)) < 2 or threading.current_thread() is not threading.main_thread():
        return [work(item) for item in given]
    gradients = torch.is_grad_enabled()

    def alone() -> None:
        torch.set_num_threads(1)
        torch.set_grad_enabled(gradients)

    with ThreadPoolExecutor(min(ALLOWED, len(given)), initializer=alone) as pool:
        return list(pool.map(work, given))
