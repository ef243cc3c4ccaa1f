"""Linear heat flow in its modes: exact for inputs that are linear between samples, many devices at once, only what is asked for computed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor
from torch.autograd.forward_ad import unpack_dual
from torch.nn.functional import pad

from zoo.physics.exponential import exponential_weights

CHUNK = 24
"""L, samples in a chunk of time; products of matrices with a multiple of 24 columns are the fast ones."""
WINDOW = 12
"""W, samples before a chunk whose inputs act on it directly."""
GONE = 40.0
"""A mode is forgotten where λ·t is larger: e^(−40)."""
STATES_AT_ONCE, OUTPUTS_AT_ONCE = 2**22, 3 * 2**17
"""Numbers computed before the next devices' turn, outputs by each thread; few enough to stay in the caches."""


@dataclass(frozen=True, eq=False)
class Modes:
    """dz/dt = −λ·z + b·u(t), y = c·z + d·u.

    Attributes:
        rate: (..., N) λ, not negative [1/s].
        drive: (..., N, U) b.
        observe: (..., O, N) c.
        direct: (..., O, U) d.
    """

    rate: Tensor
    drive: Tensor
    observe: Tensor
    direct: Tensor


def respond(modes: Modes, step_s: float, inputs: Tensor, start: Tensor | None = None) -> Tensor:
    """Outputs for inputs that are linear between evenly spaced samples, exact at any step.

    With a = e^(−λh), φ1 and φ2 as in an exponential integrator (Hochbruck & Ostermann 2010, Acta Numerica 19:209) and x = z − hφ2·b·u the state
    obeys x[k+1] = a·x[k] + g·u[k]. Time is cut into chunks. The inputs in a chunk and in a window before it act through a Toeplitz matrix, all
    earlier ones through the states of those modes that outlast the window; all of it in matrix products over chunks and devices.

    Args:
        modes: of B devices.
        step_s: h [s].
        inputs: (..., U, T), one for all devices or one each.
        start: (..., N) z at the first sample; where None, the steady state in the first inputs (every mode has to decay).

    Returns:
        (..., O, T).
    """
    if start is None:
        start = (modes.drive @ inputs[..., :1]).squeeze(-1) / modes.rate
    parts = [(modes.rate, 1), (modes.drive, 2), (modes.observe, 2), (modes.direct, 2), (start, 1)]
    batch = torch.broadcast_shapes(inputs.shape[:-2], *(part.shape[: part.dim() - tail] for part, tail in parts))
    flat = [_flat(part, batch, tail) for part, tail in parts]
    driving = _flat(inputs, () if inputs.shape[:-2].numel() == 1 else batch, 2)
    shape = (math.prod(batch), modes.observe.shape[-2], inputs.shape[-1])
    pieces = _pieces(Modes(*flat[:4]), step_s, driving, flat[4])
    if _is_followed(*flat, driving):
        answer = torch.cat([piece.flatten(-2)[..., : shape[-1]] for piece in pieces])
    else:
        answer = _written(pieces, _blank(shape, flat[0]))
    return answer.reshape(*batch, *shape[1:])


def _flat(part: Tensor, batch: tuple[int, ...], tail: int) -> Tensor:
    """(..., tail) -> (B, tail); an empty batch is one device."""
    shape = part.shape[part.dim() - tail :]
    return part.reshape(1, *shape) if not batch else part.expand(*batch, *shape).reshape(math.prod(batch), *shape)


def _is_followed(*parts: Tensor) -> bool:
    """Whether derivatives are asked for, backward or forward."""
    return torch.is_grad_enabled() and any(part.requires_grad or unpack_dual(part).tangent is not None for part in parts)


def _turns(total: int, size: int) -> Iterator[slice]:
    """So many of the devices after so many."""
    size = max(size, 1)
    return (slice(first, first + size) for first in range(0, total, size))


def _pieces(modes: Modes, step_s: float, inputs: Tensor, start: Tensor) -> Iterator[Tensor]:
    """(b, O, C, L) outputs in whole chunks, some devices after others; inputs (1 or B, U, T)."""
    windows = _windows(inputs[:1])
    for some in _turns(len(modes.rate), STATES_AT_ONCE // (windows.shape[1] * modes.rate.shape[-1])):
        devices = Modes(modes.rate[some], modes.drive[some], modes.observe[some], modes.direct[some])
        yield from _outputs(devices, step_s, windows if len(inputs) == 1 else _windows(inputs[some]), start[some])


def _windows(inputs: Tensor) -> Tensor:
    """(B, U, T) -> (B, 1 + C, U, W + L): each chunk with the window before it, after one that is empty; ⌊√C⌋ divides C."""
    chunks = -(-inputs.shape[-1] // CHUNK)
    chunks += -chunks % math.isqrt(chunks)
    padded = pad(inputs, (CHUNK + WINDOW, chunks * CHUNK - inputs.shape[-1]))
    return padded.unfold(-1, WINDOW + CHUNK, CHUNK).transpose(1, 2).contiguous()


def _outputs(modes: Modes, step_s: float, windows: Tensor, start: Tensor) -> Iterator[Tensor]:
    """As `_pieces`, of devices few enough for all their states."""
    depth = modes.rate * step_s
    late, gain = _weights(depth, step_s, modes.drive)
    power = torch.exp(-depth.unsqueeze(-1) * torch.arange(WINDOW + CHUNK + 1, dtype=depth.dtype, device=depth.device))
    begin = start - (late @ windows[:, 1, :, WINDOW].unsqueeze(-1)).squeeze(-1)
    slow = (depth.amin(0) * WINDOW < GONE).nonzero().squeeze(-1)
    states = _states(power[:, slow], gain[:, slow], windows[:, :-1, :, :CHUNK], begin[:, slow])
    at_once = (modes.observe @ late + modes.direct).unsqueeze(-1)
    later = (modes.observe.unsqueeze(-2) * gain.mT.unsqueeze(-3)) @ power[..., : WINDOW + CHUNK - 1].unsqueeze(-3)
    near = _toeplitz(torch.cat([at_once, later], -1))
    far = (modes.observe[..., slow].mT.unsqueeze(-1) * power[:, slow, WINDOW:-1].unsqueeze(-2)).flatten(-2)  # (B, N, O·L)
    free = ((modes.observe * begin.unsqueeze(-2)) @ power[..., :CHUNK]).flatten(-2)
    inputs = windows[:, 1:].flatten(-2).expand(len(depth), -1, -1)
    for some in _turns(len(depth), torch.get_num_threads() * (OUTPUTS_AT_ONCE // (inputs.shape[1] * near.shape[-1]))):
        outputs = torch.bmm(inputs[some], near[some]).baddbmm_(states[:, some].transpose(0, 1), far[some])
        outputs[:, 0] += free[some]
        yield outputs.unflatten(-1, (-1, CHUNK)).transpose(1, 2)


def _weights(depth: Tensor, step_s: float, drive: Tensor) -> tuple[Tensor, Tensor]:
    """(B, N, U) hφ2·b, what the input at a sample has added to z by then, and g, what it adds to x by the next one."""
    decay, phi_1, phi_2 = exponential_weights(depth)
    late = (step_s * phi_2).unsqueeze(-1) * drive
    return late, decay.unsqueeze(-1) * late + (step_s * (phi_1 - phi_2)).unsqueeze(-1) * drive


def _toeplitz(kernel: Tensor) -> Tensor:
    """(B, O, U, W + L) response by delay -> (B, U·(W + L), O·L) from the samples of a window and its chunk to those of the chunk."""
    shifted = pad(kernel, (CHUNK - 1, 0)).unfold(-1, CHUNK, 1).flip(-2)
    return shifted.permute(0, 2, 3, 1, 4).flatten(-2).flatten(1, 2)


def _states(power: Tensor, gain: Tensor, passed: Tensor, begin: Tensor) -> Tensor:
    """(C, B, N) x where each chunk's window begins, from the (B, C, U, L) inputs since the one before; nothing for the first chunk."""
    weights = (gain.unsqueeze(-1) * power[..., :CHUNK].flip(-1).unsqueeze(-2)).flatten(-2)  # (B, N, U·L)
    passed = passed.flatten(-2)
    shared = len(passed) == 1
    added = (passed[0] @ weights.flatten(0, 1).mT).unflatten(-1, begin.shape) if shared else (passed @ weights.mT).transpose(0, 1)
    added[1:2] += power[..., CHUNK - WINDOW] * begin
    return _decaying_sums(power[..., CHUNK], added)


def _decaying_sums(decay: Tensor, added: Tensor) -> Tensor:
    """(C, ...) x[k] = decay·x[k−1] + added[k]: in ⌊√C⌋ groups side by side, then from group to group; in place where nobody follows."""
    keep = _is_followed(decay, added)
    columns = added.unflatten(0, (-1, math.isqrt(len(added)))).unbind(1)
    sums = [columns[0]]
    for column in columns[1:]:
        sums.append(torch.addcmul(column, decay, sums[-1], out=None if keep else column))
    leap, before = decay ** len(columns), [torch.zeros_like(decay)]
    for last in sums[-1][:-1]:
        before.append(torch.addcmul(last, leap, before[-1]))
    entering, share = torch.stack(before), decay
    for place, own in enumerate(sums):
        sums[place] = torch.addcmul(own, share, entering, out=None if keep else own)
        share = share * decay
    return torch.stack(sums, 1).flatten(0, 1) if keep else added


def _blank(shape: tuple[int, ...], like: Tensor) -> Tensor:
    """Memory for the answer. NumPy asks the system for large pages and torch does not; writing it for the first time is three times as fast."""
    if like.device.type != "cpu":
        return like.new_empty(shape)
    return torch.from_numpy(np.empty(shape, like.new_empty(0).numpy().dtype))


def _written(pieces: Iterable[Tensor], answer: Tensor) -> Tensor:
    """The pieces one after another in the answer's memory."""
    first, whole = 0, answer.shape[-1] // CHUNK
    for piece in pieces:
        part, first = answer[first : first + len(piece)], first + len(piece)
        part[..., : whole * CHUNK].unflatten(-1, (whole, CHUNK)).copy_(piece[..., :whole, :])
        part[..., whole * CHUNK :] = piece[..., whole:, :].flatten(-2)[..., : answer.shape[-1] - whole * CHUNK]
    return answer
