"""What a function of tensors does, as a list of tensor operations.

torch's own `make_fx` writes the same list, in 100 ms for a small network's pass where this takes 3: as long as a whole search by ten ants.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, TypeVar

import torch
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode

Kind = TypeVar("Kind")


class Slot(NamedTuple):
    """Stands for a tensor that depends on the inputs."""

    number: int


class Operation(NamedTuple):
    """One operation: what it takes (slots among constants), what it gave, the slots of that, and whose memory it is, if not its own."""

    function: Any
    args: tuple[Any, ...]
    kwargs: dict[str, Any]
    gave: tuple[Any, ...]
    slots: tuple[Slot, ...]
    lent: Slot | None

    @property
    def changes(self) -> bool:
        """Whether it works in place."""
        return bool(self.function._schema.is_mutable)


class Recorder(TorchDispatchMode):
    """Writes down what depends on the inputs; constants are computed while it listens, and kept.

    Attributes:
        recorded: the operations.
        faithful: whether these are all that the function does. They are not if it writes what depends on its inputs into a constant, changes a
            constant that an operation has taken, gives a tensor in place another shape, or takes numbers out of tensors.
    """

    def __init__(self, *values: Tensor) -> None:
        super().__init__()
        self.recorded: list[Operation] = []
        self.faithful = True
        self._made = 0
        self._slots: dict[tuple[Any, ...], Slot] = {}
        self._memory: dict[Slot, int] = {}
        self._owned: set[int] = set()  # Memory of what depends on the inputs.
        self._relied: set[int] = set()  # Memory of constants that an operation takes.
        self._seen: list[Any] = []  # A place is a tensor's own only as long as it lives.
        self._named(values)

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        given, named = self.slotted(args), self.slotted(kwargs or {})
        result = func(*args, **(kwargs or {}))
        self._seen.append((args, kwargs, result))
        gave = tuple(result) if isinstance(result, list | tuple) else (result,)
        taken = [_memory(one) for one in within((given, named), Tensor)]
        depends = within((given, named), Slot)
        written = list(_written(func, given, named))
        self.faithful &= self._owned.isdisjoint(taken)  # A constant is no view of what depends on the inputs, taken where no operation was heard.
        if not depends:
            self.faithful &= self._relied.isdisjoint(_memory(one) for one in within(tuple(written), Tensor))
        elif written or len(gave) > 1 or not isinstance(result, Tensor) or _place(result) not in self._slots:
            # Else it is only another name for what is there, as a tensor expanded to its own size.
            self._relied.update(taken)
            lent = next((slot for slot in depends if self._memory[slot] == _memory(gave[0]) != 0), None)
            if written:
                self.faithful &= len(written) == len(gave) == 1 and isinstance(written[0], Slot) and torch.Tag.inplace_view not in func.tags
                lent = written[0] if self.faithful else None
            self.faithful &= all(one is None or isinstance(one, Tensor) for one in gave)
            self.recorded.append(Operation(func, given, named, gave, self._named(gave), lent))
        return result

    def result(self, value: Any) -> Any:
        """What the function gave, with slots."""
        slotted = self.slotted(value)
        self.faithful &= self._owned.isdisjoint(_memory(one) for one in within(slotted, Tensor))
        return slotted

    def slotted(self, value: Any) -> Any:
        """A value with slots in place of the tensors that depend on the inputs."""
        if isinstance(value, list | tuple):
            return tuple(self.slotted(one) for one in value)
        if isinstance(value, dict):
            return {name: self.slotted(one) for name, one in value.items()}
        return self._slots.get(_place(value), value) if isinstance(value, Tensor) else value

    def _named(self, values: tuple[Any, ...]) -> tuple[Slot, ...]:
        slots = tuple(Slot(self._made + i) for i in range(len(values)))
        self._made += len(slots)
        self._seen.append(values)
        self._memory |= {slot: _memory(one) for slot, one in zip(slots, values, strict=True)}
        self._owned |= {*self._memory.values()} - {0}
        self._slots |= {_place(one): slot for slot, one in zip(slots, values, strict=True) if isinstance(one, Tensor)}
        return slots


def once(recorded: list[Operation]) -> tuple[list[Operation], dict[Slot, Slot]]:
    """Operations without those recorded before with the same arguments, and slot -> slot that stands for it.

    Where anything is changed in place, what was computed before need not be what is computed now: then all of them.
    """
    if any(one.changes for one in recorded):
        return recorded, {}
    kept: dict[Any, Operation] = {}
    same: dict[Slot, Slot] = {}
    for one in recorded:
        args, kwargs, lent = renamed(one.args, same), renamed(one.kwargs, same), renamed(one.lent, same)
        before = kept.setdefault((one.function, _identity((args, kwargs))), one._replace(args=args, kwargs=kwargs, lent=lent))
        same |= zip(one.slots, before.slots, strict=True)
    return list(kept.values()), same


def renamed(value: Any, names: dict[Slot, Slot]) -> Any:
    """A value with other slots, wherever they occur in it."""
    if type(value) is tuple:
        return tuple(renamed(one, names) for one in value)
    if isinstance(value, dict):
        return {name: renamed(one, names) for name, one in value.items()}
    return names.get(value, value) if isinstance(value, Slot) else value


def within(value: Any, kind: type[Kind]) -> list[Kind]:
    """All of one kind in nested tuples and dicts, as often as they occur."""
    if isinstance(value, kind):
        return [value]
    if type(value) is dict:
        value = tuple(value.values())
    return [one for each in value for one in within(each, kind)] if type(value) is tuple else []


def _identity(value: Any) -> Any:
    """A key that two values share only if they are the same to an operation."""
    if type(value) is tuple:
        return tuple(_identity(one) for one in value)
    if isinstance(value, dict):
        return tuple((name, _identity(one)) for name, one in value.items())
    return value if isinstance(value, Slot) else _place(value) if isinstance(value, Tensor) else (type(value), repr(value))


def _written(function: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Iterator[Any]:
    """The arguments that an operation changes in place."""
    if function._schema.is_mutable:
        for number, one in enumerate(function._schema.arguments):
            if one.alias_info is not None and one.alias_info.is_write:
                yield args[number] if number < len(args) else kwargs.get(one.name)


def _place(tensor: Tensor) -> tuple[Any, ...]:
    """Where a tensor lies in memory: the same for all its names, of which what a gradient keeps for itself is one."""
    return tensor.data_ptr(), tensor.shape, tensor.stride(), tensor.dtype


def _memory(value: Any) -> int:
    """The same for all that lie in the same memory; 0 for what has none, as the zeros that a derivative in forward mode starts from."""
    return value.untyped_storage().data_ptr() if isinstance(value, Tensor) and not value._is_zerotensor() else 0
