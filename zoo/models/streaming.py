"""A model over a record of any length, chunk by chunk; what it remembers goes on from each chunk to the next, see `zoo.physics.carry`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import torch
from torch import Tensor

from zoo.effects.sum import Sum
from zoo.errors import WorkError, in_brief
from zoo.models.base import Model
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.places import FIRST_S
from zoo.physics.carry import Carried

ROWS = 8192
"""Rows at a time: what is computed of them stays in the caches."""
SAME = 1e-6
"""Difference between a record in pieces and as a whole, over the largest prediction, that no memory leaves; rounding leaves less than 1e-9."""
PIECES = (1, 1, 2, 61, 1, 307, 23)
"""Rows of the chunks, over and over, in which a model is tried."""
Predict = Callable[[Tensor], Tensor]


def continued(predict: Predict, x: Tensor, states: Sequence[Tensor]) -> tuple[Tensor, list[Tensor]]:
    """One chunk of a record, as a pure function that can be traced for chunks of one sample.

    Args:
        predict: a model, or a part of one.
        x: (M, C) raw columns.
        states: as the chunk before returned them; empty for the first chunk.

    Returns:
        (M,) prediction, and the states after it.
    """
    with Carried(states) as carried:
        predicted = predict(x)
    return predicted, carried.states


class Stream:
    """A model on its way through one record."""

    def __init__(self, predict: Predict, sizes: Callable[[], Iterator[int]] | None = None) -> None:
        """Begin a record.

        Args:
            predict: the model, or whatever else remembers by `zoo.physics.carry`.
            sizes: makes the numbers of rows to compute at a time; by default `ROWS` for ever.
        """
        self._predict, self._states = predict, list[Tensor]()
        self._sizes = (sizes or _always)()

    @torch.no_grad()
    def __call__(self, x: Tensor) -> Tensor:
        """(M, C) the record's next raw columns -> (M, …) what is made of them, such as the error. The first call should bring the first minute."""
        done, parts = 0, list[Tensor]()
        while done < len(x):
            size = next(self._sizes)
            if not self._states:  # a record that starts in motion is known by its first minute
                size = max(size, 2, 1 + int((x[:, 0] <= x[0, 0] + FIRST_S).sum()))
            predicted, self._states = continued(self._predict, x[done : done + size], self._states)
            parts.append(predicted)
            done += size
        return torch.cat(parts) if parts else x.new_zeros(0)


def check_streams(model: Model, x: Tensor) -> None:
    """Compare a record in pieces with the whole.

    Args:
        model: trained.
        x: (T, C) raw columns of a record, some thousand rows.

    Raises:
        WorkError: they differ; names the effect that remembers what does not go on.
    """
    difference = _difference(model, x)
    if not difference:
        return
    wrong = next(((name, found) for name, part in _parts(model) if (found := _difference(part, x))), (_title(model), difference))
    raise WorkError(
        f"{wrong[0]} has a memory of its own that ends with every piece of a long record ({wrong[1]})\n"
        "what zoo.physics has goes on (lagged, clamped, affine, elapsed, maxwell, at_start): build on that"
    )


def _always() -> Iterator[int]:
    while True:
        yield ROWS


def _uneven() -> Iterator[int]:
    while True:
        yield from PIECES


@torch.no_grad()
def _difference(predict: Predict, x: Tensor) -> str:
    """How a record in pieces differs from the whole; empty where it does not."""
    whole = predict(x)
    if not bool(torch.isfinite(whole).all()):
        return ""  # another fault, told where it is met
    try:
        pieces = Stream(predict, _uneven)(x)
    except Exception as error:
        return in_brief(error)
    apart, size = float((pieces - whole).abs().max()), float(whole.abs().max())
    return "" if apart <= SAME * size else f"its prediction changes by {apart:.2g} of {size:.2g}"


def _parts(model: Model) -> Iterator[tuple[str, Predict]]:
    """What may be at fault: each effect by itself, and a hybrid's network."""
    physics = model.physics if isinstance(model, Hybrid) else model
    if isinstance(physics, GrayBox):
        for name, effect in physics.named_effects():
            alone, grey = Sum({name: effect}), physics
            yield f"effect '{name}' ({_title(effect)})", lambda x, alone=alone, grey=grey: alone(grey.histories(x, grey.coil_value))  # type: ignore[misc]
    if isinstance(model, Hybrid):
        yield _title(model.network), lambda x: model.network(x[:, model.columns])


def _title(module: torch.nn.Module) -> str:
    return f"{type(module).__module__}.{type(module).__qualname__}"
