"""Answers for many devices, computed some devices after others, so that what lies between stays in the caches, and put together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

import numpy as np
import torch
from torch import Tensor
from torch.autograd.forward_ad import unpack_dual


def turns(devices: int, at_once: int) -> Iterator[slice]:
    """So many of the devices after so many, one at least."""
    size = max(at_once, 1)
    return (slice(first, first + size) for first in range(0, devices, size))


def is_followed(value: Tensor) -> bool:
    """Whether derivatives of it are asked for, backward or forward, so that nothing that led to it may be overwritten."""
    return torch.is_grad_enabled() and (value.requires_grad or unpack_dual(value).tangent is not None)


def joined(pieces: Iterator[Tensor], shape: tuple[int, int, int]) -> Tensor:
    """The answer that is made of pieces; where no derivatives are asked for, each piece may be forgotten when the next one comes.

    Args:
        pieces: (b, O, C, L) of some devices after others: C chunks of L samples, the last of them longer than asked for.
        shape: of the answer, B, O and T.

    Returns:
        (B, O, T).
    """
    piece = next(pieces)
    if is_followed(piece):
        return torch.cat([one.flatten(-2)[..., : shape[-1]] for one in chain([piece], pieces)])
    return _written(chain([piece], pieces), _blank(shape, piece))


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
        whole.unflatten(-1, (chunks, -1)).copy_(piece[..., :chunks, :])
        last.copy_(piece[..., chunks:, :].flatten(-2)[..., :rest])
        first += len(piece)
    return answer
