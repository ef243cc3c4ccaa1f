"""What all tests share."""

import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
import torch

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # started in a shell's background, which the programs under test would inherit
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="module")
def _as_quick_as_alone() -> Iterator[None]:
    """A file's tests start as in a process of their own.

    The collector's rounds leave alone what other files loaded: with thousands of tests and torch's modules they took most of the time of Python's
    own work. And a file that leaves torch with more threads than it was given would slow down all that come after it, twofold and more.
    """
    gc.collect()
    gc.freeze()
    threads = torch.get_num_threads()
    yield
    assert torch.get_num_threads() == threads, "set back what was changed of torch"


@pytest.fixture
def nothing_is_left() -> Iterator[None]:
    """No more open files and child processes than before: what other tests have left may go meanwhile."""

    def left() -> tuple[int, set[str]]:
        children = Path(f"/proc/self/task/{os.getpid()}/children").read_text()
        return len(list(Path("/proc/self/fd").iterdir())), set(children.split())

    files, processes = left()
    yield
    more_files, more_processes = left()
    assert more_files <= files
    assert more_processes <= processes
