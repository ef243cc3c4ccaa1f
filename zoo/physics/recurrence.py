"""Recurrences along time, evaluated for a whole batch at once, by prefix doubling or, where every step is the same, by products.

A first-order lag is a chain of affine maps, a play operator is a chain of clamps; both kinds are closed under composition, so that all T states
follow in log2(T) vectorised passes instead of T steps (Blelloch 1990, "Prefix sums and their applications"). Exact for any sampling step. What is
large is first gone through in groups of a few steps, all groups side by side, which reads it once instead of once a pass.
"""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.physics.carry import left, resumed

GROUP = 16
"""Steps in a group."""
LARGE = 1 << 14
"""Number of elements from which groups are worth it."""
AT_ONCE, SUMMED = 64, 24
"""Steps up to which one product with their matrix is fastest, and how many make a group where there are more."""


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
    if _is_small(offset):
        gain, offset = _affine_chained(gain, offset)
        return left(offset + gain * start.unsqueeze(-1), start)
    gains, offsets = _grouped(gain), _grouped(offset)
    total, added = [gains[..., 0, :]], [offsets[..., 0, :]]
    for k in range(1, gains.shape[-2]):
        added.append(torch.addcmul(offsets[..., k, :], gains[..., k, :], added[-1]))
        total.append(gains[..., k, :] * total[-1])
    over, after = _affine_chained(total[-1], added[-1])
    entering = _entering(start, torch.addcmul(after, over, start.unsqueeze(-1)))
    for k in range(len(added)):
        added[k] = torch.addcmul(added[k], total[k], entering)
    return left(_in_a_row(added, offset.shape[-1]), start)


def _affine_chained(gain: Tensor, offset: Tensor) -> tuple[Tensor, Tensor]:
    """(..., T) each, the maps from before the first step to after each."""
    step, total = 1, offset.shape[-1]
    while step < total:
        offset = torch.cat([offset[..., :step], offset[..., step:] + gain[..., step:] * offset[..., :-step]], dim=-1)
        gain = torch.cat([gain[..., :step], gain[..., step:] * gain[..., :-step]], dim=-1)
        step *= 2
    return gain, offset


def _is_small(values: Tensor, large: int = LARGE) -> bool:
    """Whether doubling alone is as fast."""
    return values.numel() < large


def _grouped(values: Tensor, size: int = GROUP) -> Tensor:
    """(..., T) -> (..., S, G), G groups of S steps, the last filled up with what nothing comes after."""
    return _filled_up(values, size).transpose(-1, -2).contiguous()


def _in_a_row(states: list[Tensor], steps: int) -> Tensor:
    """(..., T) from what each step of all groups leads to, S of (..., G)."""
    return torch.stack(states, dim=-1).flatten(-2)[..., :steps]


def _entering(start: Tensor, after: Tensor) -> Tensor:
    """(..., G) what enters each group, from the states after each (..., G) and the one before the first."""
    return torch.cat([start.expand(after.shape[:-1]).unsqueeze(-1), after[..., :-1]], dim=-1)


def geometric(rate: Tensor, offset: Tensor, start: Tensor) -> Tensor:
    """States of x[k] = e^(−rate)·x[k−1] + offset[k] with x[−1] = start: `affine` for one gain at all steps, as products with small matrices.

    Groups of a few steps are summed from 0 on, side by side; what enters a group is left by all before it, a recurrence over the groups.

    Args:
        rate: (...), not negative.
        offset: (..., T).
        start: (...), the state before the first sample.

    Returns:
        (..., T).
    """
    start = resumed(start)
    rates, groups = [rate], [offset]
    while not _is_short(groups[-1]):
        within = _from_nothing(rates[-1], _filled_up(groups[-1]))
        groups[-1] = within
        groups.append(within[..., -1])
        rates.append(rates[-1] * within.shape[-1])
    last = _from_nothing(rates[-1], groups[-1].unsqueeze(-2)).squeeze(-2)
    states = torch.addcmul(last, start.unsqueeze(-1), _ahead(rates[-1], last.shape[-1]))
    for k in range(len(groups) - 2, -1, -1):
        number, size = groups[k].shape[-2], groups[k].shape[-1]
        entering = _entering(start, states[..., :number]).unsqueeze(-1)
        states = torch.addcmul(groups[k], entering, _ahead(rates[k], size).unsqueeze(-2)).flatten(-2)
    return left(states[..., : offset.shape[-1]], start)


def _is_short(values: Tensor, most: int = AT_ONCE) -> bool:
    return values.shape[-1] <= most


def _filled_up(values: Tensor, size: int = SUMMED) -> Tensor:
    """(..., T) -> (..., G, S) groups, the last filled up with zeros."""
    return torch.nn.functional.pad(values, (0, -values.shape[-1] % size)).unflatten(-1, (-1, size))


def _from_nothing(rate: Tensor, offset: Tensor) -> Tensor:
    """(..., G, S) sums within each group."""
    return offset @ _powers(rate, offset.shape[-1]).mT


def _ahead(rate: Tensor, size: int) -> Tensor:
    """(..., S) what is left of a state after each step of a group."""
    return torch.exp(-rate.unsqueeze(-1) * torch.arange(1, size + 1, dtype=rate.dtype, device=rate.device))


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
    if _is_small(low):
        low, high = _clamps_chained(low, high)
        return left(_within(start.unsqueeze(-1), low, high), start)
    lows, highs = _grouped(low), _grouped(high)
    least, most = [lows[..., 0, :]], [highs[..., 0, :]]
    for k in range(1, lows.shape[-2]):
        least.append(_within(least[-1], lows[..., k, :], highs[..., k, :]))
        most.append(_within(most[-1], lows[..., k, :], highs[..., k, :]))
    entering = _entering(start, _within(start.unsqueeze(-1), *_clamps_chained(least[-1], most[-1])))
    return left(_in_a_row([_within(entering, bottom, top) for bottom, top in zip(least, most, strict=True)], low.shape[-1]), start)


def _clamps_chained(low: Tensor, high: Tensor) -> tuple[Tensor, Tensor]:
    """(..., T) each, the bounds from before the first step to after each."""
    step, total = 1, low.shape[-1]
    while step < total:
        now_low, now_high = low[..., step:], high[..., step:]
        before_low, before_high = low[..., :-step], high[..., :-step]
        low = torch.cat([low[..., :step], _within(before_low, now_low, now_high)], dim=-1)
        high = torch.cat([high[..., :step], _within(before_high, now_low, now_high)], dim=-1)
        step *= 2
    return low, high


def _within(values: Tensor, low: Tensor, high: Tensor) -> Tensor:
    return torch.minimum(torch.maximum(values, low), high)
