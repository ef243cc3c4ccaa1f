"""What a function of one tensor does, as a list of tensor operations."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode


class Slot(NamedTuple):
    """Stands for a tensor that depends on the input."""

    number: int


class Recorded(NamedTuple):
    """One operation: what it takes (slots among constants), what it gave, the slots of that, and whose memory it is, if not its own."""

    operation: Any
    args: tuple[Any, ...]
    kwargs: dict[str, Any]
    gave: list[Tensor]
    slots: list[Slot]
    lent: Slot | None

    @property
    def changes(self) -> bool:
        """Whether it works in place."""
        return bool(self.operation._schema.is_mutable)


class Recorder(TorchDispatchMode):
    """Writes down what depends on the input; constants are computed while it listens, and kept."""

    def __init__(self, value: Tensor) -> None:
        super().__init__()
        self.slots = {id(value): Slot(0)}
        self.seen: list[Any] = [value]  # An id is a tensor's own only as long as it lives.
        self.recorded: list[Recorded] = []
        self.made = 1

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        result = func(*args, **(kwargs or {}))
        self.seen.append((args, kwargs, result))
        given, named = self.slotted(args), {name: self.slotted(one) for name, one in (kwargs or {}).items()}
        if any(True for _ in mentioned((given, named))):
            gave = list(result) if isinstance(result, list | tuple) else [result]
            slots = [Slot(self.made + i) for i in range(len(gave))]
            self.made += len(gave)
            lent = next((slot for slot, one in zip(given, args, strict=True) if isinstance(slot, Slot) and _shares_memory(gave[0], one)), None)
            self.recorded.append(Recorded(func, given, named, gave, slots, lent))
            if self.recorded[-1].changes and lent is None:
                raise ValueError(f"{func}: a constant would be changed in place")
            self.slots |= {id(one): slot for one, slot in zip(gave, slots, strict=True)}
        return result

    def slotted(self, value: Any) -> Any:
        """A value with slots in place of the tensors that depend on the input."""
        if isinstance(value, list | tuple):
            return tuple(self.slotted(one) for one in value)
        return self.slots.get(id(value), value) if isinstance(value, Tensor) else value


def once(recorded: list[Recorded]) -> tuple[list[Recorded], dict[Slot, Slot]]:
    """Operations without those recorded before with the same arguments, and slot -> slot that stands for it.

    Where anything is changed in place, what was computed before need not be what is computed now: then all of them.
    """
    if any(one.changes for one in recorded):
        return recorded, {}
    kept: dict[Any, Recorded] = {}
    same: dict[Slot, Slot] = {}
    for one in recorded:
        args, kwargs = renamed(one.args, same), {name: renamed(value, same) for name, value in one.kwargs.items()}
        lent = one.lent and renamed(one.lent, same)
        key = one.operation, _identity(args), tuple((name, _identity(value)) for name, value in kwargs.items())
        before = kept.setdefault(key, one._replace(args=args, kwargs=kwargs, lent=lent))
        same |= zip(one.slots, before.slots, strict=True)
    return list(kept.values()), same


def renamed(value: Any, names: dict[Slot, Slot]) -> Any:
    """A value with other slots, wherever they occur in it."""
    if type(value) is tuple:
        return tuple(renamed(one, names) for one in value)
    return names.get(value, value) if isinstance(value, Slot) else value


def _identity(value: Any) -> Any:
    """A key that two values share only if they are the same to an operation."""
    if type(value) is tuple:
        return tuple(_identity(one) for one in value)
    return value if isinstance(value, Slot) else id(value) if isinstance(value, Tensor) else (type(value), value)


def mentioned(value: Any) -> Iterator[Slot]:
    """All slots in nested tuples and dicts, as often as they occur."""
    if isinstance(value, Slot):
        yield value
    elif isinstance(value, tuple | dict):
        for one in value.values() if isinstance(value, dict) else value:
            yield from mentioned(one)


def _shares_memory(one: Any, other: Any) -> bool:
    tensors = isinstance(one, Tensor) and isinstance(other, Tensor)
    return tensors and one.untyped_storage().data_ptr() == other.untyped_storage().data_ptr() != 0
