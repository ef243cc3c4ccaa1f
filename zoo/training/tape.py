"""A pass through a model as the plain list of its tensor operations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode


class _Slot(NamedTuple):
    """Stands for a tensor that depends on the input."""

    number: int


class _Played(NamedTuple):
    """One operation: what it takes (slots among constants), where its results go, and which slots nobody asks for afterwards."""

    operation: Any
    args: list[Any]
    kwargs: dict[str, Any]
    results: list[int]
    spent: list[int]


class Tape(TorchDispatchMode):
    """Records a function of one tensor, for inputs of one shape, and plays it without the Python code and the vmap that made it.

    For small tensors these take several times as long as the arithmetic. What does not depend on the input is computed once. The function must be
    one of its input alone: deterministic, and without a branch on the input's values, which vmap forbids as well.
    """

    def __init__(self, function: Callable[[Tensor], Tensor], value: Tensor) -> None:
        """Record.

        Args:
            function: of a tensor, to a tensor.
            value: an input; others must have its shape.
        """
        super().__init__()
        self.slots = {id(value): 0}
        self.played: list[_Played] = []
        self.seen: list[Any] = [value]  # Kept while recording: an id is a tensor's own only as long as it lives.
        self.made = 1
        with self:
            self.first = function(value)
        self.last = self._slotted(self.first)
        self._forget_early()
        self.slots, self.seen = {}, []

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        result = func(*args, **(kwargs or {}))
        if _same_view(result, args):
            self.seen.append(result)
            if id(args[0]) in self.slots:
                self.slots[id(result)] = self.slots[id(args[0])]
            return result
        self.seen.append((args, kwargs, result))
        given = [self._slotted(one) for one in args]
        named = {name: self._slotted(one) for name, one in (kwargs or {}).items()}
        if any(_slots([*given, *named.values()])):
            several = result if isinstance(result, list | tuple) else [result]
            made = list(range(self.made, self.made + len(several)))
            self.made += len(made)
            self.slots |= {id(one): slot for one, slot in zip(several, made, strict=True)}
            self.played.append(_Played(func, given, named, made, []))
        return result

    def __call__(self, value: Tensor) -> Tensor:
        """The function of another input of the same shape."""
        values: list[Any] = [None] * self.made
        values[0] = value
        for operation, args, kwargs, results, spent in self.played:
            result = operation(*_filled(args, values), **{name: _filled([one], values)[0] for name, one in kwargs.items()})
            if isinstance(result, list | tuple):
                values[results[0] : results[-1] + 1] = result
            else:
                values[results[0]] = result
            for slot in spent:
                values[slot] = None
        output: Tensor = _filled([self.last], values)[0]
        return output

    def _slotted(self, value: Any) -> Any:
        if isinstance(value, list | tuple):
            return [self._slotted(one) for one in value]
        return _Slot(self.slots[id(value)]) if isinstance(value, Tensor) and id(value) in self.slots else value

    def _forget_early(self) -> None:
        # Memory that is free again is used again while it is in the cache.
        needed = {slot.number for slot in _slots([self.last])}
        for one in reversed(self.played):
            mentioned = {slot.number for slot in _slots([*one.args, *one.kwargs.values()])} | set(one.results)
            one.spent.extend(mentioned - needed)
            needed |= mentioned


def _same_view(result: Any, args: Any) -> bool:
    """Whether an operation only gives its first argument another name, as expanding to the same size does."""
    if not (isinstance(result, Tensor) and args and isinstance(args[0], Tensor)) or result is args[0]:
        return False
    one, other = result, args[0]
    return one.data_ptr() == other.data_ptr() and (one.shape, one.stride(), one.dtype) == (other.shape, other.stride(), other.dtype)


def _slots(values: list[Any]) -> list[_Slot]:
    found = []
    for one in values:
        if type(one) is _Slot:
            found.append(one)
        elif isinstance(one, list):
            found.extend(_slots(one))
    return found


def _filled(args: list[Any], values: list[Any]) -> list[Any]:
    return [values[one.number] if type(one) is _Slot else _filled(one, values) if type(one) is list else one for one in args]
