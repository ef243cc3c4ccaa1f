"""Recurrences along time, evaluated for a whole batch at once, by prefix doubling or, of what only decays, by sums.

A first-order lag is a chain of affine maps, a play operator is a chain of clamps; both kinds are closed under composition, so that all T states
follow in log2(T) vectorised passes instead of T steps (Blelloch 1990, "Prefix sums and their applications"). Exact for any sampling step. What is
large is first gone through in groups of a few steps, all groups side by side, which reads it once instead of once a pass. A lag, whose gains are
exponentials, needs one sum for as many steps as an exponential has room for.
"""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.physics.carry import is_carried, left, resumed

GROUP = 16
"""Steps in a group."""
LARGE = 1 << 14
"""Number of elements from which groups are worth it."""
SHORT = 256
"""Steps of a chunk up to which two sums over triangles of what decays, of the steps of a group and of all groups, take the place of doubling."""
LONGEST = 4096
"""Steps in one sum of what decays, at most: its rounding grows with them."""


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


def decaying(rate: Tensor, offset: Tensor, start: Tensor) -> Tensor:
    """States of x[k] = e^(−rate[k])·x[k−1] + offset[k] with x[−1] = start: `affine` without the doubling, as sums.

    With c[k] the sum of rates up to k, x[k]·e^c[k] is start plus the sum of offset[j]·e^c[j], whose rounding decays as the states do: what stays is
    that of c, a few hundred eps. Where e^c would be too large, or the sum too long, groups of steps are summed from 0 on, side by side; what enters a
    group is left by all before it, a recurrence over the groups. How large they are depends on the rates, which vmap forbids.

    Args:
        rate: (..., T), not negative.
        offset: (..., T).
        start: (...), the state before the first sample.

    Returns:
        (..., T).
    """
    if is_carried() or rate.is_cuda:  # What is traced for chunks may not ask how large its numbers are; a GPU's long sums are not the same twice.
        return _at_once(rate, offset, start) if _are_few(rate, offset) else affine(torch.exp(-rate), offset, start)
    far = 500.0 if offset.dtype == rate.dtype == torch.float64 else 40.0  # summed rates whose exponential there is room for
    gone = far / 2  # leaves nothing of a state
    rates, parts, ahead = rate.clamp_max(gone), [offset], [offset]
    size = _steps_within(rates, far)
    while size < rates.shape[-1]:
        sums = _filled_up(rates, size).cumsum(-1)
        grown = torch.exp(sums)
        parts[-1] = (_filled_up(parts[-1], size) * grown).cumsum(-1) / grown
        ahead[-1] = grown
        parts.append(parts[-1][..., -1])
        ahead.append(offset)
        rates = sums[..., -1].clamp_max(gone)
        size = _steps_within(rates, far)
    grown = torch.exp(rates.cumsum(-1))
    states = ((parts[-1] * grown).cumsum(-1) + start.unsqueeze(-1)) / grown
    for k in range(len(parts) - 2, -1, -1):
        entering = _entering(start, states[..., : parts[k].shape[-2]]).unsqueeze(-1)
        states = (parts[k] + entering / ahead[k]).flatten(-2)
    return states[..., : offset.shape[-1]]


def _are_few(rate: Tensor, offset: Tensor, most: int = SHORT) -> bool:
    """Whether these are the steps of a chunk that go at once."""
    alike = rate.dtype == offset.dtype == torch.float64 and rate.shape[-1] == offset.shape[-1]
    return is_carried() and alike and 1 < rate.shape[-1] <= most


def _at_once(rate: Tensor, offset: Tensor, start: Tensor, size: int = GROUP) -> Tensor:
    """The same of a few steps in groups, in far fewer operations, of which a graph is made one by one."""
    start = resumed(start)
    sums, own = _from_nothing(_filled_up(rate, size), _filled_up(offset, size))
    over, ends = _from_nothing(sums[..., -1], own[..., -1])
    entering = _entering(start, ends + torch.exp(-over) * start.unsqueeze(-1))
    return left((own + torch.exp(-sums) * entering.unsqueeze(-1)).flatten(-2)[..., : rate.shape[-1]], start)


def _from_nothing(rate: Tensor, offset: Tensor) -> tuple[Tensor, Tensor]:
    """(..., T) the summed rates, and the states of what starts at 0: what each offset is worth at each later step, T² numbers."""
    total = rate.clamp_max(40.0).cumsum(-1)  # e⁻⁴⁰ leaves nothing of a state
    worth = torch.exp((total.unsqueeze(-2) - total.unsqueeze(-1)).clamp_max(0.0))
    return total, (worth * offset.unsqueeze(-2)).tril().sum(-1)


def _steps_within(rates: Tensor, far: float, most: int = LONGEST) -> int:
    """How many steps, whichever they are, have rates that sum up to no more; two at least. What is no number concerns its own row alone."""
    largest = float(rates.detach().nan_to_num(0.0).max()) if rates.numel() else 0.0
    return min(max(int(far / max(largest, 1e-9)), 2), most)


def _filled_up(values: Tensor, size: int) -> Tensor:
    """(..., T) -> (..., G, S) groups, the last filled up with zeros."""
    return torch.nn.functional.pad(values, (0, -values.shape[-1] % size)).unflatten(-1, (-1, size))


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
