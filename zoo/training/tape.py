"""A pass through a model as the plain list of its tensor operations, in memory of its own."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import torch
from torch import Tensor

from zoo.training.recording import Recorded, Recorder, Slot, mentioned, once, renamed


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
        recorder = Recorder(self.input)
        with recorder:
            result = function(self.input)
        recorded, same = once(recorder.recorded)
        last = renamed(recorder.slotted(result), same)
        plan = _Plan(self.input, recorded, last)
        self.steps, self.output = plan.steps, plan.filled(last)

    def __call__(self, value: Tensor) -> Tensor:
        """The function of another input of the same shape. The next call overwrites what this one returns."""
        self.input.copy_(value)
        for step in self.steps:
            step()
        output: Tensor = self.output
        return output


class _Plan:
    """Where every result lies, and the calls that fill these places one after the other."""

    def __init__(self, value: Tensor, recorded: list[Recorded], last: Any) -> None:
        self.steps: list[Callable[[], Any]] = []
        self.values: dict[Slot, Tensor] = {Slot(0): value}
        self.root: dict[Slot, int] = {Slot(0): 0}  # Slots that share memory share a root.
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
        return self.values[value] if isinstance(value, Slot) else value

    def _settle(self, one: Recorded) -> None:
        for slot in one.slots:
            self.root[slot] = slot.number if one.lent is None else self.root[one.lent]

    def _spent(self, recorded: list[Recorded], last: Any) -> list[set[int]]:
        """Of every operation the roots that nobody asks for after it; the input and the output are kept."""
        ends = {self.root[slot]: number for number, one in enumerate(recorded) for slot in (*mentioned((one.args, one.kwargs)), *one.slots)}
        spent: list[set[int]] = [set() for _ in recorded]
        for root in ends.keys() - {0, *(self.root[slot] for slot in mentioned(last))}:
            spent[ends[root]].add(root)
        return spent

    def _lay(self, one: Recorded, spent: set[int]) -> None:
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

    def _in_place(self, one: Recorded, spent: set[int]) -> Tensor | None:
        """The place of an argument that nobody needs any more, where the result may lie as well."""
        if torch.Tag.pointwise not in one.operation.tags:
            return None
        given = list(mentioned((one.args, one.kwargs)))
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


def _alike(one: Tensor, other: Tensor) -> bool:
    return (one.shape, one.stride(), one.dtype) == (other.shape, other.stride(), other.dtype)


def _copied(call: Callable[[], Any], places: list[Tensor]) -> None:
    results = call()
    for place, result in zip(places, results if isinstance(results, list | tuple) else [results], strict=True):
        place.copy_(result)


@cache
def _with_out(operation: Any) -> Any:
    """The same operation that writes its one result into memory given as `out`; None where there is none."""
    wanted = [(one.name, str(one.type)) for one in operation._schema.arguments]
    packet = operation.overloadpacket
    for overload in (getattr(packet, name) for name in packet.overloads()):
        *given, last = overload._schema.arguments
        if last.is_out and last.name == "out" and [(one.name, str(one.type)) for one in given] == wanted:
            return overload
    return None
