"""Work whose tools a copy of this process fetches ahead, while this one still makes what they will work on."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from os import close, pipe, read, write
from tempfile import TemporaryFile
from typing import IO, Any

import torch

from zoo.side_by_side import Copy, copies_allowed, copy_of_this

PATIENCE_S = 120.0
"""How long to wait for the copy once it was told what to work on; then it is done here."""


class Ahead:
    """A piece of work, to be begun and, other things having been done meanwhile, ended.

    Where there is no copy, and where it brings nothing, for whatever reason, the work is done here, so that errors are raised as ever.
    """

    def __init__(self, work: Callable[..., None], copy: Copy | None = None, tell: Callable[[object], None] = lambda _: None) -> None:
        """Prepare; see `ahead`."""
        self._work, self._copy, self._tell = work, copy, tell
        self._given: tuple[tuple[Any, ...], dict[str, Any]] = (), {}

    def begin(self, *values: Any, **named: Any) -> None:
        """Work on something; what cannot be pickled is worked on here."""
        self._given, told = (values, named), False
        with suppress(Exception):
            self._tell(self._given)
            told = True
        if not told:
            self.leave()

    def end(self) -> None:
        """See that it is done.

        Raises:
            Exception: whatever the work raises.
        """
        if self._copy is None or self._copy.result(PATIENCE_S) is None:
            self.leave()  # before anybody works on the same here
            values, named = self._given
            self._work(*values, **named)

    def leave(self) -> None:
        """End the copy, whether it is done or not."""
        copy, self._copy = self._copy, None
        if copy is not None:
            copy.end()


@contextmanager
def ahead(fetch: Callable[[], object], work: Callable[..., None]) -> Iterator[Ahead]:
    """A copy of this process that fetches what it needs, and waits to be told what to work on.

    Args:
        fetch: imports what the work needs.
        work: of what `Ahead.begin` is given; leaves files behind, and must not mind being done twice.
    """
    if not copies_allowed():
        yield Ahead(work)
        return
    with TemporaryFile(buffering=0) as sheet:  # a pipe would hold little, and a copy that hangs would stop who fills it
        reading, told = pipe()

        def body() -> bool:
            close(told)
            torch.set_num_threads(1)  # those of this process do not go on in a copy
            fetch()
            if read(reading, 1):
                sheet.seek(0)
                values, named = pickle.loads(sheet.read())
                work(*values, **named)
            return True

        copy = None
        with suppress(OSError):  # no more processes, or no memory for one
            copy = copy_of_this(body)
        close(reading)
        prepared = Ahead(work, copy, lambda given: _tell(given, sheet, told))
        try:
            yield prepared
        finally:
            close(told)
            prepared.leave()


def _tell(given: object, sheet: IO[bytes], told: int) -> None:
    """Write down what to work on, and that it is all there."""
    pickle.dump(given, sheet, pickle.HIGHEST_PROTOCOL)
    write(told, b".")
