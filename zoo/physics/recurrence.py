"""Recurrences along time, evaluated for a whole batch at once, by prefix doubling or, where every step is the same, group by group.

A first-order lag is a chain of affine maps, a play operator is a chain of clamps; both kinds are closed under composition, so that all T states
follow in log2(T) vectorised passes instead of T steps (Blelloch 1990, "Prefix sums and their applications"). Exact for any sampling step.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.physics.carry import left, resumed


def affine(gain: Tensor, offset: Tensor, start: Tensor) -> Tensor:
    """States of x[k] = gain[k]·x[k−1] + offset[k] with x[−1] = start.

    Args:
        gain: (..., T).
        offset: (..., T).
        start: (...), the state before the first sample.

    Returns:
        (..., T).
    """
    start = resumed(start)
    gain, offset = torch.broadcast_tensors(gain, offset)
    step, total = 1, offset.shape[-1]
    while step < total:
        offset = torch.cat([offset[..., :step], offset[..., step:] + gain[..., step:] * offset[..., :-step]], dim=-1)
        gain = torch.cat([gain[..., :step], gain[..., step:] * gain[..., :-step]], dim=-1)
        step *= 2
    return left(offset + gain * start.unsqueeze(-1), start)


def geometric(rate: Tensor, offset: Tensor, start: Tensor) -> Tensor:
    """States of x[k] = e^(−rate)·x[k−1] + offset[k] with x[−1] = start: `affine` for one gain at all steps, as two products with small matrices.

    Groups of about √T steps are summed from 0 on, side by side; then what enters a group from all before it.

    Args:
        rate: (...), not negative.
        offset: (..., T).
        start: (...), the state before the first sample.

    Returns:
        (..., T).
    """
    start, steps = resumed(start), offset.shape[-1]
    size = max(int(math.sqrt(steps)), 1)
    groups = torch.nn.functional.pad(offset, (0, -steps % size)).unflatten(-1, (-1, size))
    within = groups @ _powers(rate, size).mT
    entering = torch.cat([start.expand(within.shape[:-2]).unsqueeze(-1), within[..., :-1, -1]], dim=-1)
    entering = (_powers(rate * size, entering.shape[-1]) @ entering.unsqueeze(-1)).squeeze(-1)
    ahead = torch.exp(-rate.unsqueeze(-1) * torch.arange(1, size + 1, dtype=rate.dtype, device=rate.device))
    return left(torch.addcmul(within, entering.unsqueeze(-1), ahead.unsqueeze(-2)).flatten(-2)[..., :steps], start)


def _powers(rate: Tensor, size: int) -> Tensor:
    """(..., S, S) e^(−rate·(i − j)) on and below the diagonal, 0 above it."""
    place = torch.arange(size, dtype=rate.dtype, device=rate.device)
    apart = place.unsqueeze(1) - place
    return torch.exp(-rate.unsqueeze(-1).unsqueeze(-1) * apart.clamp_min(0.0)).tril()


def clamped(low: Tensor, high: Tensor, start: Tensor) -> Tensor:
    """States of x[k] = min(max(x[k−1], low[k]), high[k]) with x[−1] = start.

    Args:
        low: (..., T) lower bounds.
        high: (..., T) upper bounds, nowhere below `low`.
        start: (...), the state before the first sample.

    Returns:
        (..., T).
    """
    start = resumed(start)
    low, high = torch.broadcast_tensors(low, high)
    step, total = 1, low.shape[-1]
    while step < total:
        before_low, before_high = low[..., :-step], high[..., :-step]
        now_low, now_high = low[..., step:], high[..., step:]
        low = torch.cat([low[..., :step], torch.minimum(torch.maximum(before_low, now_low), now_high)], dim=-1)
        high = torch.cat([high[..., :step], torch.minimum(torch.maximum(before_high, now_low), now_high)], dim=-1)
        step *= 2
    return left(torch.minimum(torch.maximum(start.unsqueeze(-1), low), high), start)
