"""`fogzoo … | head`: who reads may leave early. That is no failure, and nothing is left to say it to."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from zoo.errors import causes

CLOSED_PIPE = 141
"""The exit code that shells give a command that such a pipe has ended, 128 + SIGPIPE."""


def nobody_reads(error: BaseException) -> bool:
    """Whether an exception came from printing into a closed pipe; rich makes a SystemExit of it."""
    return any(isinstance(cause, BrokenPipeError) for cause in causes(error))


def print_to_nobody() -> int:
    """Whatever is printed from now on goes nowhere, what Python itself flushes at its end included; returns the exit code."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return CLOSED_PIPE


@contextmanager
def unread_logs() -> Iterator[None]:
    """Lets a line of Hydra's log that cannot be printed be lost, instead of a traceback in its place."""
    before = logging.raiseExceptions
    logging.raiseExceptions = False
    try:
        yield
    finally:
        logging.raiseExceptions = before
