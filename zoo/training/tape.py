"""A function of tensors as the plain list of its operations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode


class _Slot(NamedTuple):
    """Stands for a tensor that depends on the inputs."""

    number: int


class _Played(NamedTuple):
    """One operation: what it takes (slots among constants), where its results go, and which slots nobody asks for afterwards."""

    operation: Any
    args: list[Any]
    kwargs: dict[str, Any]
    results: list[int]
    spent: list[int]


class Tape(TorchDispatchMode):
    """Records a function of tensors, for inputs of one shape, and plays it without the Python code, the vmap and the gradient's graph that made it.

    For small tensors these take several times as long as the arithmetic. What does not depend on the inputs is computed once. The function must be
    one of its inputs alone: deterministic, and without a branch on their values, which vmap forbids as well. One that writes what depends on its
    inputs into something that does not is not recorded but called every time.
    """

    def __init__(self, function: Callable[..., Any], *values: Tensor) -> None:
        """Record.

        Args:
            function: of tensors, to a tensor or a tuple of tensors.
            *values: inputs; others must have their shapes and be as contiguous.
        """
        super().__init__()
        self.function, self.faithful = function, True
        self.slots = {_place(value): number for number, value in enumerate(values)}
        self.played: list[_Played] = []
        self.seen: list[Any] = [values]  # Kept while recording: a place is a tensor's own only as long as it lives.
        self.made = len(values)
        with self:
            found = function(*values)
        self.last = self._slotted(found)
        self._forget_early()
        self.slots, self.seen = {}, []

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        given = [self._slotted(one) for one in args]
        named = {name: self._slotted(one) for name, one in (kwargs or {}).items()}
        result = func(*args, **(kwargs or {}))
        self.seen.append((args, kwargs, result))
        changes = func._schema.is_mutable
        if isinstance(result, Tensor) and not changes and _place(result) in self.slots:
            return result  # Only another name for what is there, as a tensor expanded to its own size.
        if any(_slots([*given, *named.values()])):
            several = result if isinstance(result, list | tuple) else [result]
            made = list(range(self.made, self.made + len(several)))
            self.made += len(made)
            self.faithful &= not changes or type(given[0]) is _Slot
            self.slots |= {_place(one): slot for one, slot in zip(several, made, strict=True) if isinstance(one, Tensor)}
            self.played.append(_Played(func, given, named, made, []))
        return result

    def __call__(self, *inputs: Tensor) -> Any:
        """The function of other inputs of the same shapes."""
        if not self.faithful:
            return self.function(*inputs)
        values: list[Any] = [*inputs, *[None] * (self.made - len(inputs))]
        for operation, args, kwargs, results, spent in self.played:
            result = operation(*_filled(args, values), **{name: _filled([one], values)[0] for name, one in kwargs.items()})
            if isinstance(result, list | tuple):
                values[results[0] : results[-1] + 1] = result
            else:
                values[results[0]] = result
            for slot in spent:
                values[slot] = None
        return _filled([self.last], values)[0]

    def _slotted(self, value: Any) -> Any:
        if isinstance(value, list | tuple):
            return [self._slotted(one) for one in value]
        return _Slot(self.slots[_place(value)]) if isinstance(value, Tensor) and _place(value) in self.slots else value

    def _forget_early(self) -> None:
        # Memory that is free again is used again while it is in the cache.
        needed = {slot.number for slot in _slots([self.last])}
        for one in reversed(self.played):
            mentioned = {slot.number for slot in _slots([*one.args, *one.kwargs.values()])} | set(one.results)
            one.spent.extend(mentioned - needed)
            needed |= mentioned


class Recorded:
    """A function of tensors that is played from a tape for inputs of shapes that come again; what comes only once is not worth recording."""

    def __init__(self, function: Callable[..., Any]) -> None:
        """Prepare.

        Args:
            function: see `Tape`.
        """
        self.function = function
        self.tapes: dict[tuple[Any, ...], Tape | None] = {}

    def __call__(self, *inputs: Tensor) -> Any:
        """The function of some inputs."""
        given = [one.contiguous() for one in inputs]
        key = tuple(one.shape for one in given)
        if key not in self.tapes:
            self.tapes[key] = None
            return self.function(*given)
        tape = self.tapes[key] or Tape(self.function, *given)
        self.tapes[key] = tape
        return tape(*given)


def _place(tensor: Tensor) -> tuple[Any, ...]:
    """Where a tensor lies in memory: the same for all its names, of which what a gradient keeps for itself is one."""
    return tensor.data_ptr(), tensor.shape, tensor.stride(), tensor.dtype


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
