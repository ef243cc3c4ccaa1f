"""As many threads as the work deserves."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import torch

WORTH_IT = 1_000_000
"""Values in a tensor from which on several threads are faster than one."""


@contextmanager
def threads_for(values: int) -> Iterator[None]:
    """One thread where tensors are small: waking the others takes longer than the work, many times so on a busy machine.

    The setting is the process's, so it is put back: jobs of a multirun share a process.

    Args:
        values: numbers in the largest tensor of a step.
    """
    before = torch.get_num_threads()
    if values < WORTH_IT:
        torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
