"""Work whose tools a copy of this process fetches ahead, while this one still makes what they will work on."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from os import close, fdopen, pipe
from typing import Any

import torch

from zoo.side_by_side import Copy, copies_allowed, copy_of_this

PATIENCE_S = 120.0
"""How long to wait for the copy once it was told what to work on; then it is done here."""


class Ahead:
    """A piece of work, to be begun and, other things having been done meanwhile, ended.

    Where there is no copy, and where it brings nothing, for whatever reason, the work is done here, so that errors are raised as ever.
    """

    def __init__(self, work: Callable[..., None], copy: Copy | None, told: int) -> None:
        """Prepare; see `ahead`."""
        self._work, self._copy, self._told = work, copy, told
        self._given: tuple[tuple[Any, ...], dict[str, Any]] = (), {}

    def begin(self, *values: Any, **named: Any) -> None:
        """Work on something, which can be pickled."""
        self._given = given = values, named
        if self._copy is not None:
            with suppress(OSError), open(self._told, "wb", closefd=False) as stream:
                pickle.dump(given, stream, pickle.HIGHEST_PROTOCOL)

    def end(self) -> None:
        """See that it is done.

        Raises:
            Exception: whatever the work raises.
        """
        if self._copy is None or self._copy.result(PATIENCE_S) is None:
            values, named = self._given
            self._work(*values, **named)


@contextmanager
def ahead(fetch: Callable[[], object], work: Callable[..., None]) -> Iterator[Ahead]:
    """A copy of this process that fetches what it needs, and waits to be told what to work on.

    Args:
        fetch: imports what the work needs.
        work: of what `Ahead.begin` is given; leaves files behind, and must not mind being done twice.
    """
    if not copies_allowed():
        yield Ahead(work, None, -1)
        return
    reading, told = pipe()

    def body() -> bool:
        close(told)
        torch.set_num_threads(1)  # those of this process do not go on in a copy
        fetch()
        with fdopen(reading, "rb") as stream:
            values, named = pickle.load(stream)
        work(*values, **named)
        return True

    copy = None
    with suppress(OSError):  # no more processes, or no memory for one
        copy = copy_of_this(body)
    close(reading)
    try:
        yield Ahead(work, copy, told)
    finally:
        close(told)
        if copy is not None:
            copy.end()
