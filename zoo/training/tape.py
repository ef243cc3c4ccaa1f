"""A pass through a model as the plain list of its tensor operations, in memory of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import torch
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode


class Tape:
    """Records a function of one tensor, for inputs of one shape, and plays it without the Python code and the vmap that made it.

    For small tensors these take several times as long as the arithmetic. What does not depend on the input is computed once, and so is what the
    function computes twice. Results lie where they lay at the last call, so that views need not be taken again and no memory is asked for: beyond a
    few hundred kB the system takes as long to give it as the arithmetic. The function must be one of its input alone: deterministic, without a branch
    on the input's values, which vmap forbids as well, and without a change in place of anything that does not depend on the input.
    """

    def __init__(self, function: Callable[[Tensor], Tensor], value: Tensor) -> None:
        """Record.

        Args:
            function: of a tensor, to a tensor.
            value: an input; others must have its shape.
        """
        self.input = value.clone()
        recorder = _Recorder(self.input)
        with recorder:
            result = function(self.input)
        recorded, same = _once(recorder.recorded)
        last = _renamed(recorder.slotted(result), same)
        plan = _Plan(self.input, recorded, last)
        self.steps, self.output = plan.steps, plan.filled(last)

    def __call__(self, value: Tensor) -> Tensor:
        """The function of another input of the same shape. The next call overwrites what this one returns."""
        self.input.copy_(value)
        for step in self.steps:
            step()
        output: Tensor = self.output
        return output


class _Slot(NamedTuple):
    """Stands for a tensor that depends on the input."""

    number: int


class _Recorded(NamedTuple):
    """One operation: what it takes (slots among constants), what it gave, the slots of that, and whose memory it is, if not its own."""

    operation: Any
    args: tuple[Any, ...]
    kwargs: dict[str, Any]
    gave: list[Tensor]
    slots: list[_Slot]
    lent: _Slot | None

    @property
    def changes(self) -> bool:
        """Whether it works in place."""
        return bool(self.operation._schema.is_mutable)


class _Recorder(TorchDispatchMode):
    """Writes down what depends on the input; constants are computed while it listens, and kept."""

    def __init__(self, value: Tensor) -> None:
        super().__init__()
        self.slots = {id(value): _Slot(0)}
        self.seen: list[Any] = [value]  # An id is a tensor's own only as long as it lives.
        self.recorded: list[_Recorded] = []
        self.made = 1

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        result = func(*args, **(kwargs or {}))
        self.seen.append((args, kwargs, result))
        given, named = self.slotted(args), {name: self.slotted(one) for name, one in (kwargs or {}).items()}
        if any(True for _ in _slots((given, named))):
            gave = list(result) if isinstance(result, list | tuple) else [result]
            slots = [_Slot(self.made + i) for i in range(len(gave))]
            self.made += len(gave)
            lent = next((slot for slot, one in zip(given, args, strict=True) if isinstance(slot, _Slot) and _shares_memory(gave[0], one)), None)
            self.recorded.append(_Recorded(func, given, named, gave, slots, lent))
            if self.recorded[-1].changes and lent is None:
                raise ValueError(f"{func}: a constant would be changed in place")
            self.slots |= {id(one): slot for one, slot in zip(gave, slots, strict=True)}
        return result

    def slotted(self, value: Any) -> Any:
        """A value with slots in place of the tensors that depend on the input."""
        if isinstance(value, list | tuple):
            return tuple(self.slotted(one) for one in value)
        return self.slots.get(id(value), value) if isinstance(value, Tensor) else value


class _Plan:
    """Where every result lies, and the calls that fill these places one after the other."""

    def __init__(self, value: Tensor, recorded: list[_Recorded], last: Any) -> None:
        self.steps: list[Callable[[], Any]] = []
        self.values: dict[_Slot, Tensor] = {_Slot(0): value}
        self.root: dict[_Slot, int] = {_Slot(0): 0}  # Slots that share memory share a root.
        self.memory: dict[int, Tensor] = {}
        self.free: list[Tensor] = []
        for one in recorded:
            self._settle(one)
        for one, spent in zip(recorded, self._spent(recorded, last), strict=True):
            self._lay(one, spent)

    def filled(self, value: Any) -> Any:
        """A value with the tensors themselves in place of the slots."""
        if type(value) is tuple:
            return [self.filled(one) for one in value]
        return self.values[value] if isinstance(value, _Slot) else value

    def _settle(self, one: _Recorded) -> None:
        for slot in one.slots:
            self.root[slot] = slot.number if one.lent is None else self.root[one.lent]

    def _spent(self, recorded: list[_Recorded], last: Any) -> list[set[int]]:
        """Of every operation the roots that nobody asks for after it; the input and the output are kept."""
        ends = {self.root[slot]: number for number, one in enumerate(recorded) for slot in (*_slots((one.args, one.kwargs)), *one.slots)}
        spent: list[set[int]] = [set() for _ in recorded]
        for root in ends.keys() - {0, *(self.root[slot] for slot in _slots(last))}:
            spent[ends[root]].add(root)
        return spent

    def _lay(self, one: _Recorded, spent: set[int]) -> None:
        args, kwargs = self.filled(one.args), {name: self.filled(value) for name, value in one.kwargs.items()}
        call = partial(one.operation, *args, **kwargs)
        if one.lent is not None:
            result = call()
            self.values |= zip(one.slots, result if isinstance(result, list | tuple) else [result], strict=True)
            if one.changes:
                self.steps.append(call)
        else:
            own = self._in_place(one, spent)
            places = [own] if own is not None else [self._place(slot.number, tensor) for slot, tensor in zip(one.slots, one.gave, strict=True)]
            self.values |= zip(one.slots, places, strict=True)
            out = _with_out(one.operation) if len(places) == 1 else None
            self.steps.append(partial(out, *args, **kwargs, out=places[0]) if out else partial(_copied, call, places))
        self.free += [self.memory[root] for root in spent if root in self.memory]

    def _in_place(self, one: _Recorded, spent: set[int]) -> Tensor | None:
        """The place of an argument that nobody needs any more, where the result may lie as well."""
        if torch.Tag.pointwise not in one.operation.tags:
            return None
        given = list(_slots(one.args))
        for slot in given:
            place, root = self.values[slot], self.root[slot]
            if root in spent and _alike(place, one.gave[0]) and all(other == slot or self.root[other] != root for other in given):
                self.memory[one.slots[0].number] = self.memory.pop(root)
                spent.discard(root)
                return place
        return None

    def _place(self, root: int, like: Tensor) -> Tensor:
        """Memory for a tensor: what was freed last, being in the cache, or else new."""
        extent = 1 + sum((size - 1) * stride for size, stride in zip(like.shape, like.stride(), strict=True)) if like.numel() else 0
        fitting = [i for i, one in enumerate(self.free) if (len(one), one.dtype, one.device) == (extent, like.dtype, like.device)]
        self.memory[root] = self.free.pop(fitting[-1]) if fitting else torch.empty(extent, dtype=like.dtype, device=like.device)
        return self.memory[root].as_strided(like.shape, like.stride())


def _once(recorded: list[_Recorded]) -> tuple[list[_Recorded], dict[_Slot, _Slot]]:
    """Operations without those recorded before with the same arguments, and slot -> slot that stands for it.

    Where anything is changed in place, what was computed before need not be what is computed now: then all of them.
    """
    if any(one.changes for one in recorded):
        return recorded, {}
    kept: dict[Any, _Recorded] = {}
    same: dict[_Slot, _Slot] = {}
    for one in recorded:
        args, kwargs = _renamed(one.args, same), {name: _renamed(value, same) for name, value in one.kwargs.items()}
        lent = one.lent and _renamed(one.lent, same)
        key = one.operation, _identity(args), tuple((name, _identity(value)) for name, value in kwargs.items())
        before = kept.setdefault(key, one._replace(args=args, kwargs=kwargs, lent=lent))
        same |= zip(one.slots, before.slots, strict=True)
    return list(kept.values()), same


def _renamed(value: Any, names: dict[_Slot, _Slot]) -> Any:
    if type(value) is tuple:
        return tuple(_renamed(one, names) for one in value)
    return names.get(value, value) if isinstance(value, _Slot) else value


def _identity(value: Any) -> Any:
    """A key that two values share only if they are the same to an operation."""
    if type(value) is tuple:
        return tuple(_identity(one) for one in value)
    return value if isinstance(value, _Slot) else id(value) if isinstance(value, Tensor) else (type(value), value)


def _slots(value: Any) -> Iterator[_Slot]:
    if isinstance(value, _Slot):
        yield value
    elif isinstance(value, tuple | dict):
        for one in value.values() if isinstance(value, dict) else value:
            yield from _slots(one)


def _shares_memory(one: Any, other: Any) -> bool:
    tensors = isinstance(one, Tensor) and isinstance(other, Tensor)
    return tensors and one.untyped_storage().data_ptr() == other.untyped_storage().data_ptr() != 0


def _alike(one: Tensor, other: Tensor) -> bool:
    return (one.shape, one.stride(), one.dtype) == (other.shape, other.stride(), other.dtype)


def _copied(call: Callable[[], Any], places: list[Tensor]) -> None:
    results = call()
    for place, result in zip(places, results if isinstance(results, list | tuple) else [results], strict=True):
        place.copy_(result)


def _with_out(operation: Any) -> Any:
    """The same operation that writes its one result into memory given as `out`; None where there is none."""
    wanted = [(one.name, str(one.type)) for one in operation._schema.arguments]
    packet = operation.overloadpacket
    for overload in (getattr(packet, name) for name in packet.overloads()):
        *given, last = overload._schema.arguments
        if last.is_out and last.name == "out" and [(one.name, str(one.type)) for one in given] == wanted:
            return overload
    return None
