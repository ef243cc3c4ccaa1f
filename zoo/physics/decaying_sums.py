"""Sums that decay from step to step, x[k] = decay·x[k−1] + added[k] from x[−1] = 0, in twice √C operations on many series at once instead of C."""

from __future__ import annotations

import math
from itertools import pairwise

import torch
from torch import Tensor

from zoo.physics.pieces import is_followed


def divisible(steps: int) -> int:
    """C, the next number of steps that can be summed: one that ⌊√C⌋ divides."""
    return steps + -steps % math.isqrt(steps)


def decaying_sums(decay: Tensor, added: Tensor) -> Tensor:
    """Groups of ⌊√C⌋ steps side by side, each from 0 on; then what enters a group from all before it.

    Args:
        decay: (...), the same at every step.
        added: (C, ...); overwritten where nobody asks for derivatives.

    Returns:
        (C, ...) x.
    """
    groups = added.unflatten(0, (-1, math.isqrt(len(added))))
    sums = _pure(decay, groups) if is_followed(decay, added) else _in_place(decay, groups)
    shares = decay.expand(sums.shape[1:]).cumprod(0)
    entering = [torch.zeros_like(decay)]
    for last in sums[:-1, -1].unbind():
        entering.append(torch.addcmul(last, shares[-1], entering[-1]))
    return sums.addcmul_(shares, torch.stack(entering).unsqueeze(1)).flatten(0, 1)


def _pure(decay: Tensor, added: Tensor) -> Tensor:
    """(G, C, ...) sums over the steps of each group, which derivatives go through."""
    first, *others = added.unbind(1)
    sums = [first]
    for one in others:
        sums.append(torch.addcmul(one, decay, sums[-1]))
    return torch.stack(sums, 1)


def _in_place(decay: Tensor, added: Tensor) -> Tensor:
    """The same in the memory of what is added, which is faster."""
    for before, one in pairwise(added.unbind(1)):
        one.addcmul_(decay, before)
    return added
