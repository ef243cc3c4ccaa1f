"""What all tests share."""

import gc
import signal
from collections.abc import Iterator

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
