"""What every swarm does with its box (..., D): draws in it, walls that reflect, costs that can be compared, the best of many."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.given import check_number

Chance = Generator | Sequence[Generator]
"""One source for all, or one for each swarm along the first axis, which then takes the path that it would take alone."""


def place(low: Tensor, high: Tensor, particles: int, generator: Chance) -> Tensor:
    """(..., P, D) positions drawn uniformly in a box.

    Args:
        low: (..., D) lower bounds.
        high: (..., D) upper bounds, above `low`.
        particles: P.
        generator: source of chance.

    Raises:
        InputError: an empty swarm or box.
    """
    check_number("particles", particles, 1, whole=True)
    if not bool((high > low).all()):
        raise InputError("a swarm's box needs high > low in every dimension")
    drawn = uniform((*low.shape[:-1], particles, low.shape[-1]), low, generator)
    return torch.addcmul(low.unsqueeze(-2), (high - low).unsqueeze(-2), drawn)


def reflected(position: Tensor, low: Tensor, high: Tensor) -> Tensor:
    """(..., P, D) positions mirrored at the walls that they passed.

    Particles clamped to a wall would make it the best of all and never leave it. Who comes back beyond the wall opposite stays at it.
    """
    # A single box is as wide as its positions without another axis.
    bottom, top = (low, high) if low.dim() == 1 else (low.unsqueeze(-2), high.unsqueeze(-2))
    nearest = position.clamp(bottom, top)
    # As far again beyond the nearest point of the box, which in the box is the position itself.
    return torch.lerp(position, nearest, 2.0).clamp_(bottom, top)


def comparable(cost: Tensor, like: Tensor) -> Tensor:
    """(..., P) costs with the type and device of `like`, without a gradient; NaN counts as infinitely bad."""
    return cost.detach().to(like).nan_to_num(torch.inf, torch.inf, -torch.inf)


def best_of(position: Tensor, cost: Tensor) -> tuple[Tensor, Tensor]:
    """(..., D) the cheapest of (..., P, D) positions and (...) its cost."""
    least, which = cost.min(dim=-1)
    return picked(position, which.unsqueeze(-1)).squeeze(-2), least


def picked(position: Tensor, which: Tensor) -> Tensor:
    """(..., N, D) those of (..., P, D) positions that (..., N) indices name."""
    if position.dim() == 2:
        return position.index_select(0, which)  # half the time of the general way
    return position.gather(-2, which.unsqueeze(-1).expand(*which.shape, position.shape[-1]))


def uniform(shape: tuple[int, ...] | torch.Size, like: Tensor, generator: Chance) -> Tensor:
    """Numbers in [0, 1), drawn on the generator's device, so that a CPU generator gives a CUDA swarm the same path."""
    return _drawn(torch.rand, shape, like, generator)


def normal(shape: tuple[int, ...] | torch.Size, like: Tensor, generator: Chance) -> Tensor:
    """Standard normal numbers, drawn on the generator's device as well."""
    return _drawn(torch.randn, shape, like, generator)


def _drawn(draw: Callable[..., Tensor], shape: tuple[int, ...] | torch.Size, like: Tensor, generator: Chance) -> Tensor:
    if isinstance(generator, Generator):
        return draw(shape, generator=generator, dtype=like.dtype, device=generator.device).to(like.device)
    numbers = torch.empty(shape, dtype=like.dtype, device=generator[0].device)
    for own, one in zip(numbers, generator, strict=True):
        draw(own.shape, generator=one, out=own)
    return numbers.to(like.device)
