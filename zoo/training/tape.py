"""A function of tensors as the plain list of its operations, in memory of its own."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import torch
from torch import Tensor

from zoo.training.recording import Operation, Recorder, Slot, once, renamed, within

KEPT = 8
"""Tapes of one function, each in memory of its own: for what is cut into pieces, with a shorter last one in every direction, and some to spare."""


class Tape:
    """Records a function of tensors, for inputs of one shape, and plays it without the Python code, the vmap and the gradient's graph that made it.

    For small tensors these take several times as long as the arithmetic. What does not depend on the inputs is computed once, and so is what the
    function computes twice. Results lie where they lay at the last call, so that views need not be taken again and no memory is asked for: beyond a
    few hundred kB the system takes as long to give it as the arithmetic. The function must be one of its inputs alone: deterministic, and without a
    branch on their values, which vmap forbids as well. One whose operations do not tell all, see `Recorder`, is called every time.

    Attributes:
        faithful: whether it is played.
        steps: the calls, one after the other.
    """

    def __init__(self, function: Callable[..., Any], *values: Tensor) -> None:
        """Record.

        Args:
            function: of tensors, to a tensor or nested tuples of tensors.
            *values: inputs; others must have their shapes, types and device.
        """
        with torch.inference_mode(False), torch.no_grad():  # Tensors made in inference mode could be written in inference mode only.
            inputs = [value.detach().clone() for value in values]
        recorder = Recorder(*inputs)
        with recorder:
            found = function(*inputs)
        found = recorder.result(found)
        self.function, self.faithful = function, recorder.faithful
        self.inputs: list[Tensor] = []
        self.steps: list[Callable[[], Any]] = []
        if self.faithful:
            recorded, same = once(recorder.recorded)
            with torch.inference_mode(False), torch.no_grad():
                plan = _Plan(inputs, recorded, renamed(found, same))
            self.inputs, self.steps, self.output = inputs, plan.steps, plan.output

    def __call__(self, *inputs: Tensor) -> Any:
        """The function of other inputs, without a gradient. The next call overwrites what this one returns."""
        if not self.faithful:
            return self.function(*inputs)
        for place, value in zip(self.inputs, inputs, strict=True):
            place.copy_(value.detach())
        for step in self.steps:
            step()
        return self.output


class Recorded:
    """A function of tensors that is played from a tape for inputs of shapes that come again; what comes only once is not worth recording.

    The next call may overwrite what this one returns, see `Tape`.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        """Prepare.

        Args:
            function: see `Tape`.
        """
        self.function = function
        self.tapes: dict[tuple[Any, ...], Tape | None] = {}

    def __call__(self, *inputs: Tensor) -> Any:
        """The function of some inputs."""
        key = tuple((one.shape, one.dtype, one.device) for one in inputs)
        known = key in self.tapes
        tape = self.tapes.pop(key, None)
        if known and tape is None:
            tape = Tape(self.function, *(one.contiguous() for one in inputs))
            self._forget()
        self.tapes[key] = tape  # Last, as the latest used.
        return tape(*inputs) if tape else self.function(*(one.contiguous() for one in inputs))

    def _forget(self) -> None:
        """Room for one more: shapes of members that end one by one never come again."""
        held = [key for key, tape in self.tapes.items() if tape]
        for key in held[: 1 - KEPT]:
            del self.tapes[key]


class _Plan:
    """Where every result lies, and the calls that fill these places one after the other; each is made once while it is planned."""

    def __init__(self, inputs: list[Tensor], recorded: list[Operation], last: Any) -> None:
        self.steps: list[Callable[[], Any]] = []
        self.values: dict[Slot, Any] = {Slot(number): value for number, value in enumerate(inputs)}
        self.root: dict[Slot, int] = {slot: slot.number for slot in self.values}  # Slots that share memory share a root.
        self.memory: dict[int, Tensor] = {}
        self.free: list[Tensor] = []
        for one in recorded:
            self.root |= {slot: slot.number if one.lent is None else self.root[one.lent] for slot in one.slots}
        for one, spent in zip(recorded, self._spent(recorded, last), strict=True):
            self._lay(one, spent)
        self.output = self._returned(last)

    def _filled(self, value: Any) -> Any:
        """A value with the tensors themselves in place of the slots."""
        if type(value) is tuple:
            return [self._filled(one) for one in value]
        if isinstance(value, Slot):
            return self.values[value]
        return value.detach() if isinstance(value, Tensor) else value  # So that no gradient need be forbidden at every call.

    def _returned(self, value: Any) -> Any:
        """A result of the function: constants are copied every time, since who gets them may change them."""
        if type(value) is tuple:
            return tuple(self._returned(one) for one in value)
        if isinstance(value, Tensor):
            place = torch.empty_like(value)
            self.steps.append(partial(place.copy_, value.detach()))
            return place
        return self._filled(value)

    def _spent(self, recorded: list[Operation], last: Any) -> list[set[int]]:
        """Of every operation the roots that nobody asks for after it; the inputs and the output are kept."""
        kept = {self.root[slot] for slot in (*self.values, *within(last, Slot))}
        ends = {self.root[slot]: number for number, one in enumerate(recorded) for slot in (*within((one.args, one.kwargs), Slot), *one.slots)}
        spent: list[set[int]] = [set() for _ in recorded]
        for root in ends.keys() - kept:
            spent[ends[root]].add(root)
        return spent

    def _lay(self, one: Operation, spent: set[int]) -> None:
        args, kwargs = self._filled(one.args), {name: self._filled(value) for name, value in one.kwargs.items()}
        call = partial(one.function, *args, **kwargs)
        if one.changes:
            self.values[one.slots[0]] = self._filled(one.lent)
            call()
            self.steps.append(call)
        elif one.lent is not None:
            views = call()
            self.values |= zip(one.slots, views if isinstance(views, list | tuple) else [views], strict=True)
        else:
            own = self._in_place(one, spent)
            places: list[Tensor | None] = (
                [own] if own is not None else [self._place(slot.number, tensor) for slot, tensor in zip(one.slots, one.gave, strict=True)]
            )
            self.values |= zip(one.slots, places, strict=True)
            self.steps.append(_filling(one, args, kwargs, places))
        self.free += [self.memory[root] for root in spent if root in self.memory]

    def _in_place(self, one: Operation, spent: set[int]) -> Tensor | None:
        """The place of an argument that nobody needs any more, where the result may lie as well."""
        if torch.Tag.pointwise not in one.function.tags:
            return None
        given = within((one.args, one.kwargs), Slot)
        for slot in given:
            place, root = self.values[slot], self.root[slot]
            if root in spent and _alike(place, one.gave[0]) and all(other == slot or self.root[other] != root for other in given):
                self.memory[one.slots[0].number] = self.memory.pop(root)
                spent.discard(root)
                found: Tensor = place
                return found
        return None

    def _place(self, root: int, like: Tensor | None) -> Tensor | None:
        """Memory for a tensor: what was freed last, being in the cache, or else new."""
        if like is None:
            return None
        extent = 1 + sum((size - 1) * stride for size, stride in zip(like.shape, like.stride(), strict=True)) if like.numel() else 0
        fitting = [i for i, one in enumerate(self.free) if (len(one), one.dtype, one.device) == (extent, like.dtype, like.device)]
        self.memory[root] = self.free.pop(fitting[-1]) if fitting else torch.empty(extent, dtype=like.dtype, device=like.device)
        return self.memory[root].as_strided(like.shape, like.stride())


def _filling(one: Operation, args: list[Any], kwargs: dict[str, Any], places: list[Tensor | None]) -> Callable[[], Any]:
    """A call that lays the results of an operation into their places, made once."""
    if one.function is torch.ops.aten.bmm.default and args[0].shape[-1] == 1:
        return _filling(one._replace(function=torch.ops.aten.mul.Tensor), args, kwargs, places)  # The same products in a third of the time.
    out, name = _with_out(one.function) if len(places) == 1 else (None, "")
    if out:
        # Torch's own name for an operation takes half the time of the operation itself, if it takes the same arguments.
        named = partial(getattr(torch, one.function.overloadpacket.__name__, _unnamed), *args, **kwargs, **{name: places[0]})
        if _gives(named, places[0], one.gave[0]):
            return named
    step = partial(out, *args, **kwargs, **{name: places[0]}) if out else partial(_copied, partial(one.function, *args, **kwargs), places)
    step()
    return step


def _gives(call: Callable[[], Any], place: Any, expected: Any) -> bool:
    """Whether a call is possible and lays into its place what is expected."""
    try:
        call()
    except (TypeError, ValueError, AttributeError, IndexError, RuntimeError):
        return False
    return torch.equal(place, expected)


def _unnamed(*args: Any, **kwargs: Any) -> None:
    raise TypeError


def _alike(one: Tensor, other: Tensor) -> bool:
    return (one.shape, one.stride(), one.dtype, one.device) == (other.shape, other.stride(), other.dtype, other.device)


def _copied(call: Callable[[], Any], places: list[Tensor | None]) -> None:
    results = call()
    for place, result in zip(places, results if isinstance(results, list | tuple) else [results], strict=True):
        if place is not None:
            place.copy_(result)


@cache
def _with_out(operation: Any) -> tuple[Any, str]:
    """The same operation that writes its one result into memory given, and the name to give it by; None where there is none."""
    wanted = [(one.name, str(one.type)) for one in operation._schema.arguments]
    packet = operation.overloadpacket
    for overload in (getattr(packet, name) for name in packet.overloads()):
        *given, last = overload._schema.arguments
        if last.is_out and [(one.name, str(one.type)) for one in given] == wanted:
            return overload, last.name
    return None, ""
