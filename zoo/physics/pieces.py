"""Answers for many devices, computed some devices after others, so that what lies between stays in the caches, and put together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
import torch
from torch import Tensor
from torch.autograd.forward_ad import unpack_dual

STATES_AT_ONCE, OUTPUTS_AT_ONCE = 2**22, 3 * 2**17
"""Numbers computed before the next devices' turn, outputs by each thread; few enough to stay in the caches."""


def flat(part: Tensor, batch: tuple[int, ...], tail: int) -> Tensor:
    """(..., tail) -> (B, tail), all devices in one row; an empty batch is one device."""
    shape = part.shape[part.dim() - tail :]
    return part.reshape(1, *shape) if not batch else part.expand(*batch, *shape).reshape(math.prod(batch), *shape)


def turns(devices: int, numbers: int, at_once: int) -> Iterator[slice]:
    """Some of the devices after others: as many as make no more than so many numbers at once, so many each; one device at least."""
    size = max(at_once // max(numbers, 1), 1)
    return (slice(first, first + size) for first in range(0, devices, size))


def is_followed(*parts: Tensor) -> bool:
    """Whether derivatives with respect to one of them are asked for, backward or forward, so that nothing may be overwritten."""
    return torch.is_grad_enabled() and any(part.requires_grad or unpack_dual(part).tangent is not None for part in parts)


def joined(pieces: Iterable[Tensor], shape: tuple[int, int, int], *parts: Tensor) -> Tensor:
    """The answer that is made of pieces; where no derivatives are asked for, each piece is forgotten when the next one comes.

    Args:
        pieces: (b, O, C, L) of some devices after others: C chunks of L samples, the last of them longer than asked for.
        shape: of the answer, B, O and T.
        *parts: what the answer is computed from.

    Returns:
        (B, O, T).
    """
    if is_followed(*parts):
        return torch.cat([piece.flatten(-2)[..., : shape[-1]] for piece in pieces])
    return _written(pieces, _blank(shape, parts[0]))


def _blank(shape: tuple[int, int, int], like: Tensor) -> Tensor:
    """Memory for the answer. NumPy asks the system for large pages and torch does not; writing it for the first time is three times as fast."""
    if like.device.type != "cpu":
        return like.new_empty(shape)
    return torch.from_numpy(np.empty(shape, like.new_empty(0).numpy().dtype))


def _written(pieces: Iterable[Tensor], answer: Tensor) -> Tensor:
    """(B, O, T) the pieces one after another in the answer's memory."""
    first = 0
    for piece in pieces:
        part = answer[first : first + len(piece)]
        chunks, rest = divmod(part.shape[-1], piece.shape[-1])
        whole, last = part.split([part.shape[-1] - rest, rest], -1)
        whole.unflatten(-1, (chunks, piece.shape[-1])).copy_(piece[..., :chunks, :])
        last.copy_(piece[..., chunks:, :].flatten(-2)[..., :rest])
        first += len(piece)
    return answer
