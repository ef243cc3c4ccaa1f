"""A made-up record within what a model was fitted to, to try the model on: every column moves, through all of its range."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain

import torch
from torch import Tensor

from zoo.models.base import Model
from zoo.models.ranges import Ranges, Watched, outside

REFERENCE = "reference_"
SAMPLES, SPAN_S, SWINGS = 2000, 36000.0, 4.3
UNKNOWN = (0.0, 40.0)
"""Range of a column of which nothing is known."""
SLOWER, MOSTLY = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024), 0.9
"""How many times slower a record may be, and the share of it that is to lie within what was fitted."""


def example(inputs: Sequence[str], ranges: Ranges) -> Tensor:
    """Ten hours, with more than four swings of every column at uneven steps.

    Args:
        inputs: raw columns, ``time_s`` first.
        ranges: by column.

    Returns:
        (T, C).
    """
    place = torch.linspace(0, 1, SAMPLES, dtype=torch.float64)
    place = place + 0.3 / SAMPLES * torch.sin(7.0 * math.pi * SAMPLES / 9.0 * place)
    columns = [ranges.get(inputs[0], (0.0, 0.0))[0] + SPAN_S * place]
    for count, name in enumerate(inputs[1:]):
        low, high = ranges.get(name, UNKNOWN)
        columns.append(low + (high - low) * (0.5 - 0.5 * torch.cos(2 * math.pi * (SWINGS + 0.37 * count) * place + 0.5 * count)))
    return torch.stack(columns, dim=-1)


@torch.no_grad()
def example_within(model: Model, ranges: Ranges) -> Tensor:
    """The same for a model, slower where its columns would move faster than in training: most of it lies within the ranges of rates, too.

    Args:
        model: whose `inputs` are made up.
        ranges: by column, rate and lag.
    """
    x, watched = example(model.inputs, ranges), Watched(model)
    shares = {}
    for slower in SLOWER:
        clock = x[0, 0] + slower * (x[:, :1] - x[0, 0])
        stretched = torch.cat([clock, x[:, 1:]], dim=1)
        shares[slower] = float((~outside(watched(stretched), watched.names, ranges)).all(1).double().mean()), stretched
        if shares[slower][0] > MOSTLY:
            break
    return max(shares.values(), key=lambda one: one[0])[1]


def deciding_inputs(model: Model, ranges: Ranges) -> list[str]:
    """The raw columns that a model's prediction depends on, the time aside, in its order.

    Tried on a made-up record, in which the true input takes both signs and the value 0, whatever it was in training: effects look at its sign.

    Args:
        model: trained.
        ranges: of its raw columns.
    """
    references = [name for name in model.inputs if name.startswith(REFERENCE)]
    sizes = {name: max(1.0, *map(abs, ranges.get(name, (0.0, 0.0)))) for name in references}
    tried = example(model.inputs, dict(ranges) | {name: (-size, size) for name, size in sizes.items()})
    like = next(chain(model.parameters(), model.buffers()), tried)
    return used_inputs(model, tried.to(like.device))


@torch.no_grad()
def used_inputs(model: Model, x: Tensor) -> list[str]:
    """The raw columns that a model's prediction depends on, the time aside.

    Args:
        model: trained.
        x: (T, C) raw columns of a record.
    """
    whole, used = model(x), []
    for place, name in enumerate(model.inputs[1:], start=1):
        moved = x.clone()
        moved[:, place] = 1.0 + 1.1 * moved[:, place].flip(0)
        if not torch.equal(model(moved), whole):
            used.append(name)
    return used
