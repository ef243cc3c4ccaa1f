"""Recurrences along time, evaluated for a whole batch at once by prefix doubling.

A first-order lag is a chain of affine maps, a play operator is a chain of clamps; both kinds are closed under composition, so that all T states
follow in log2(T) vectorised passes instead of T steps (Blelloch 1990, "Prefix sums and their applications"). Exact for any sampling step.
"""

from __future__ import annotations

import torch
from torch import Tensor


def affine(gain: Tensor, offset: Tensor, start: Tensor) -> Tensor:
    """States of x[k] = gain[k]·x[k−1] + offset[k] with x[−1] = start.

    Args:
        gain: (..., T).
        offset: (..., T).
        start: (...), the state before the first sample.

    Returns:
        (..., T).
    """
    gain, offset = torch.broadcast_tensors(gain, offset)
    step, total = 1, offset.shape[-1]
    while step < total:
        offset = torch.cat([offset[..., :step], offset[..., step:] + gain[..., step:] * offset[..., :-step]], dim=-1)
        gain = torch.cat([gain[..., :step], gain[..., step:] * gain[..., :-step]], dim=-1)
        step *= 2
    return offset + gain * start.unsqueeze(-1)


def clamped(low: Tensor, high: Tensor, start: Tensor) -> Tensor:
    """States of x[k] = min(max(x[k−1], low[k]), high[k]) with x[−1] = start.

    Args:
        low: (..., T) lower bounds.
        high: (..., T) upper bounds, nowhere below `low`.
        start: (...), the state before the first sample.

    Returns:
        (..., T).
    """
    low, high = torch.broadcast_tensors(low, high)
    step, total = 1, low.shape[-1]
    while step < total:
        before_low, before_high = low[..., :-step], high[..., :-step]
        now_low, now_high = low[..., step:], high[..., step:]
        low = torch.cat([low[..., :step], torch.minimum(torch.maximum(before_low, now_low), now_high)], dim=-1)
        high = torch.cat([high[..., :step], torch.minimum(torch.maximum(before_high, now_low), now_high)], dim=-1)
        step *= 2
    return torch.minimum(torch.maximum(start.unsqueeze(-1), low), high)
