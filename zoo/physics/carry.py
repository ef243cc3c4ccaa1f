"""What is remembered from one chunk of a long record to the next.

A primitive with memory (a lag, a play, an integral) asks here for what it left at the end of the chunk before, in the order in which the primitives
are called, and so any sum of them can be computed chunk by chunk:

    states = []
    for x in chunks:
        with Carried(states) as carried:
            y = model(x)
        states = carried.states

Outside of such a block nothing is carried, and a record is whole. The states are plain tensors: handed in and out, they make a pure function
(chunk, states) -> (y, states), which can be traced for chunks of one sample. In a scripted function nothing is carried either.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextvars import ContextVar, Token

import torch
from torch import Tensor

from zoo.errors import WorkError

is_scripting = torch.jit.is_scripting  # type: ignore[attr-defined]
"""Where this is so, the compiler leaves out what stands under `else`."""


class Carried:
    """One chunk of a record: a context in which the primitives go on from `states`.

    Attributes:
        states: after the block, what the primitives left, in the order of their calls.
    """

    def __init__(self, states: Sequence[Tensor] = ()) -> None:
        """Go on.

        Args:
            states: what the chunk before left; empty in the first chunk of a record.
        """
        self.states: list[Tensor] = []
        self.is_first = not states
        self._before = list(states)
        self._token: Token[Carried | None] | None = None

    def __enter__(self) -> Carried:
        self._token = _present.set(self)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        assert self._token is not None
        _present.reset(self._token)
        if kind is None and not self.is_first and len(self.states) != len(self._before):
            raise WorkError(
                f"{len(self._before)} states were left in one chunk and {len(self.states)} in the next; what remembers must always be asked"
            )

    def exchange(self, state: Tensor) -> Tensor | None:
        """Leaves a state for the next chunk and gives what stood at its place in the chunk before; None in the first chunk."""
        place = len(self.states)
        self.states.append(state)
        return self._known(place)

    def resume(self, start: Tensor) -> Tensor:
        """The state at the next place, or in the first chunk `start`; what will be left has to be given to `exchange` next."""
        known = self._known(len(self.states))
        return start if known is None else known

    def _known(self, place: int) -> Tensor | None:
        if self.is_first:
            return None
        if place >= len(self._before):
            raise WorkError(
                f"{len(self._before)} states were left in one chunk and more are asked for in the next; what remembers must always be asked"
            )
        return self._before[place]


_present: ContextVar[Carried | None] = ContextVar("carried", default=None)


def is_carried() -> bool:
    """Whether this is a chunk of a longer record."""
    if is_scripting():
        return False
    else:  # noqa: RET505 (what stands here is not compiled)
        return _present.get() is not None


def with_last(value: Tensor) -> Tensor:
    """A signal with its last sample of the chunk before in front, so that its differences go on across the border.

    Args:
        value: (..., T).

    Returns:
        (..., T) in the first chunk and in a whole record, else (..., 1+T).
    """
    if is_scripting():
        return value
    else:  # noqa: RET505
        return _with_last(value)


def after_first(first: Tensor, rest: Tensor) -> Tensor:
    """A signal from its first sample and those after it; where the record goes on from another chunk, the latter are all.

    Args:
        first: (...) at the record's first sample.
        rest: (..., T−1), or (..., T) where the record goes on.

    Returns:
        (..., T).
    """
    if is_scripting():
        return torch.cat([first.unsqueeze(-1), rest], dim=-1)
    else:  # noqa: RET505
        carried = _present.get()
        return torch.cat([first.unsqueeze(-1), rest], dim=-1) if carried is None or carried.is_first else rest


def resumed(start: Tensor) -> Tensor:
    """The state before a chunk: `start` (...) of a recurrence where the record begins, else what `left` was given in the chunk before."""
    if is_scripting():
        return start
    else:  # noqa: RET505
        carried = _present.get()
        return start if carried is None else carried.resume(start)


def left(states: Tensor, start: Tensor) -> Tensor:
    """The states themselves, of which the last stays for the next chunk; belongs to the call of `resumed` before.

    Args:
        states: (..., T), T may be 0.
        start: (...) the state before them.

    Returns:
        (..., T).
    """
    if is_scripting():
        return states
    else:  # noqa: RET505
        carried = _present.get()
        if carried is not None:
            carried.exchange(states[..., -1] if states.shape[-1] else start)
        return states


def at_start(value: Tensor) -> Tensor:
    """(...) first sample of a whole record (..., T), in whichever chunk of it."""
    if is_scripting():
        return value[..., 0]
    else:  # noqa: RET505
        first = resumed(value[..., 0])
        return left(first.unsqueeze(-1), first)[..., 0]


def _with_last(value: Tensor) -> Tensor:
    carried = _present.get()
    before = None if carried is None else carried.exchange(value[..., -1:])
    return value if before is None else torch.cat([before.expand(*value.shape[:-1], 1), value], dim=-1)
