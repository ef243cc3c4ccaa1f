"""A diagnosis keeps its tensors together on the device that it is given.

The device is pretended: computed on the CPU, and as particular as a GPU about what is given to it. What needs a real one is in
tests/cli/test_cuda.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import pytest
import torch
from torch import Tensor
from torch.overrides import TorchFunctionMode

from zoo.diagnosis.diagnose import diagnose

DEVICE = torch.device("cuda:0")
CPU = torch.device("cpu")
INDEXING = ("__getitem__", "__setitem__", "index_put_")
ACROSS = ("copy_", "_has_compatible_shallow_copy_type")
"""What takes tensors of two devices."""
TO_THE_HOST = ("numpy", "__array__")
MARK = "there"
"""Of sparse tensors, which cannot be of a class of one's own."""


class There(Tensor):
    """A tensor on the device; whatever is computed of one is one."""

    __torch_function__ = torch._C._disabled_torch_function_impl  # what is computed of one is made one by `PretendedDevice`


class PretendedDevice(TorchFunctionMode):
    """While it lasts `cuda:0` is there."""

    def __torch_function__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        kwargs, name = kwargs or {}, getattr(func, "__name__", "")
        tensors = [*_tensors(args), *_tensors(kwargs.values())]
        there = any(_is_there(one) for one in tensors)
        if func == Tensor.device.__get__:
            return DEVICE if there else func(*args)
        if func == Tensor.is_cuda.__get__:
            return there
        if name in TO_THE_HOST and there:
            raise TypeError("can't convert cuda:0 device type tensor to numpy")
        if name in {"to", "cpu", "cuda"} and tensors and tensors[0] is args[0]:
            return _sent(func, args, kwargs)
        asked = kwargs.get("device")
        if asked is not None:
            there, kwargs = torch.device(asked).type == "cuda", {**kwargs, "device": CPU}
        elif name not in ACROSS and not (name in INDEXING and _is_there(args[0])):
            _must_be_together(name, tensors)
        return _each(_there if there else _here, func(*args, **kwargs))


def _sent(func: Any, args: Any, kwargs: Any) -> Tensor:
    """Of `to`, `cpu` and `cuda`."""
    one, *others = args
    places = [*others, *kwargs.values()]
    goes = _is_there(one)
    for place in places:
        if isinstance(place, Tensor):
            goes = _is_there(place)
        elif isinstance(place, str | torch.device):
            goes = torch.device(place).type == "cuda"
    if func.__name__ != "to":
        return _there(one) if func.__name__ == "cuda" else _here(one)
    others = [CPU if isinstance(place, str | torch.device) else place for place in others]
    kwargs = {key: CPU if key == "device" else value for key, value in kwargs.items()}
    found = func(one, *others, **kwargs)
    return _there(found) if goes else _here(found)


def _tensors(values: Iterable[Any]) -> list[Tensor]:
    """Also those in lists and tuples."""
    found: list[Tensor] = []
    for one in values:
        if isinstance(one, Tensor):
            found.append(one)
        elif isinstance(one, list | tuple):
            found += _tensors(one)
    return found


def _each(sent: Callable[[Any], Any], found: Any) -> Any:
    """A tensor, or several in what torch returns of its own kinds."""
    if isinstance(found, tuple | list) and any(isinstance(one, Tensor) for one in found):
        return type(found)(map(sent, found))
    return sent(found)


def _is_there(value: Tensor) -> bool:
    return isinstance(value, There) or hasattr(value, MARK)


def _there(value: Any) -> Any:
    if not isinstance(value, Tensor) or _is_there(value):
        return value
    if value.layout == torch.strided:
        return value.as_subclass(There)
    setattr(value, MARK, True)
    return value


def _here(value: Any) -> Any:
    return value.as_subclass(Tensor) if isinstance(value, There) else value


def _must_be_together(name: str, tensors: list[Tensor]) -> None:
    """As on a GPU: a single number may come from the CPU, anything else may not."""
    if name == "__getitem__":
        tensors = [one for one in tensors if one.ndim]  # a number is looked up as one
    wide = {_is_there(one) for one in tensors if one.ndim}
    if len(wide) > 1 or (wide == {False} and any(_is_there(one) for one in tensors)):
        raise RuntimeError(f"Expected all tensors to be on the same device, but {name} found cuda:0 and cpu")


@pytest.fixture
def device(monkeypatch) -> Iterator[torch.device]:
    """The device, for a while."""
    monkeypatch.setattr("torch.cuda.is_initialized", lambda: True)
    before = torch.__future__.get_overwrite_module_params_on_conversion()
    torch.__future__.set_overwrite_module_params_on_conversion(True)
    try:
        with PretendedDevice():
            yield DEVICE
    finally:
        torch.__future__.set_overwrite_module_params_on_conversion(before)


def test_the_device_is_particular(device) -> None:
    here, there = torch.ones(3), torch.ones(3, device=device)
    assert (there * 2.0).device == (there + torch.tensor(1.0)).device == there[here.long()].device == device
    assert there.to(here).device == there.cpu().device == here.device
    with pytest.raises(RuntimeError, match="same device"):
        here + there
    with pytest.raises(RuntimeError, match="same device"):
        here[there.long()]
    with pytest.raises(TypeError, match="numpy"):
        there.numpy()


def test_what_is_missing_is_found_there(device, runs, catalogue, base) -> None:
    some = {name: catalogue[name] for name in (*base, "polarization", "moisture", "bias_step", "hysteresis", "chamber_cycling")}
    found = diagnose([run.to(device) for run in runs("polarization")], base, some)
    assert found.record["missing"] == ["polarization"]
    assert found.search.final.residual.device == device


def test_what_nothing_explains_is_described_there(device, runs, white, catalogue, base) -> None:
    found = []
    for run in runs():
        square = torch.gradient(run.temperature, spacing=(run.time / 60.0,))[0].square()
        found.append(replace(run, error=run.error + 4 * white * (square - square.mean()) / square.std()).to(device))
    record = diagnose(found, base, {name: catalogue[name] for name in (*base, "moisture")}).record
    assert record["verdict"] == "unknown"
    assert record["unexplained"]
