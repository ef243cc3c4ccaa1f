"""Linear heat flow in its modes: exact for inputs that are linear between samples, many devices at once, only what is asked for computed.

With a = e^(−λh), φ1 and φ2 as in an exponential integrator (Hochbruck & Ostermann 2010, Acta Numerica 19:209) and x = z − hφ2·b·u the state obeys
x[k+1] = a·x[k] + g·u[k]. Time is cut into chunks. The inputs in a chunk and in a window before it act through a Toeplitz matrix, all earlier ones
through the states of those modes that outlast the window; all of it in matrix products over chunks and devices.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import pad

from zoo.physics.decaying_sums import decaying_sums, divisible
from zoo.physics.exponential import exponential_weights
from zoo.physics.pieces import OUTPUTS_AT_ONCE, STATES_AT_ONCE, flat, joined, turns

CHUNK = 24
"""L, samples in a chunk of time; products of matrices with a multiple of 24 columns are the fast ones."""
WINDOW = 12
"""W, samples before a chunk whose inputs act on it directly."""
GONE = 40.0
"""A mode is forgotten where λ·t is larger: e^(−40)."""


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

    def __getitem__(self, some: slice) -> Modes:
        """Some of the devices."""
        return Modes(self.rate[some], self.drive[some], self.observe[some], self.direct[some])


def respond(modes: Modes, step_s: float, inputs: Tensor, start: Tensor | None = None) -> Tensor:
    """Outputs for inputs that are linear between evenly spaced samples, exact at any step.

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
    *devices, begin = (flat(part, batch, tail) for part, tail in parts)
    driving = flat(inputs, () if inputs.shape[:-2].numel() == 1 else batch, 2)
    shape = (len(begin), modes.observe.shape[-2], inputs.shape[-1])
    return joined(_pieces(Modes(*devices), step_s, driving, begin), shape, *devices, begin, driving).reshape(*batch, *shape[1:])


def _pieces(modes: Modes, step_s: float, inputs: Tensor, start: Tensor) -> Iterator[Tensor]:
    """(b, O, C, L) outputs in whole chunks, some devices after others; inputs (1 or B, U, T)."""
    windows = _windows(inputs[:1])
    for some in turns(len(start), windows.shape[1] * start.shape[-1], STATES_AT_ONCE):
        yield from _terms(modes[some], step_s, windows if len(inputs) == 1 else _windows(inputs[some]), start[some]).summed()


def _windows(inputs: Tensor) -> Tensor:
    """(B, U, T) -> (B, 1 + C, U, W + L): each chunk with the window before it, after one that is empty; C is `divisible`."""
    chunks = divisible(-(-inputs.shape[-1] // CHUNK))
    padded = pad(inputs, (CHUNK + WINDOW, chunks * CHUNK - inputs.shape[-1]))
    return padded.unfold(-1, WINDOW + CHUNK, CHUNK).transpose(1, 2).contiguous()


@dataclass(frozen=True, eq=False)
class _Terms:
    """Outputs in chunks, y[i] = inputs·near + states·far, + free in the first chunk; i counts from where a chunk begins, its window from −W.

    Attributes:
        inputs: (B, C, U·(W + L)) u of each window and its chunk.
        near: (B, U·(W + L), O·L) what these do: inputs·near = (c·hφ2·b + d)·u[i] + Σ c·a^(j−1)·g·u[i−j] over j = 1…W+i.
        states: (B, C, N) x[−W] of the modes that outlast a window, 0 in the first chunk.
        far: (B, N, O·L) what is left of all before: states·far = c·a^(W+i)·x[−W].
        free: (B, O·L) what is left of the start: c·a^i·x[0].
    """

    inputs: Tensor
    near: Tensor
    states: Tensor
    far: Tensor
    free: Tensor

    def summed(self) -> Iterator[Tensor]:
        """(b, O, C, L) y, some devices after others."""
        devices, chunks, _ = self.inputs.shape
        for some in turns(devices, chunks * self.free.shape[-1], torch.get_num_threads() * OUTPUTS_AT_ONCE):
            outputs = torch.bmm(self.inputs[some], self.near[some]).baddbmm_(self.states[some], self.far[some])
            outputs[:, 0] += self.free[some]
            yield outputs.unflatten(-1, (-1, CHUNK)).transpose(1, 2)


def _terms(modes: Modes, step_s: float, windows: Tensor, start: Tensor) -> _Terms:
    """Of devices few enough for all their states; windows as `_windows` makes them, (1 or B, 1 + C, U, W + L)."""
    depth = modes.rate * step_s
    late, gain = _weights(depth, step_s, modes.drive)
    power = torch.exp(-depth.unsqueeze(-1) * torch.arange(WINDOW + CHUNK + 1, dtype=depth.dtype, device=depth.device))
    begin = start - (late @ windows[:, 1, :, WINDOW].unsqueeze(-1)).squeeze(-1)
    slow = (depth.amin(0) * WINDOW < GONE).nonzero().squeeze(-1)
    at_once = (modes.observe @ late + modes.direct).unsqueeze(-1)
    later = (modes.observe.unsqueeze(-2) * gain.mT.unsqueeze(-3)) @ power[..., : WINDOW + CHUNK - 1].unsqueeze(-3)
    return _Terms(
        inputs=windows[:, 1:].flatten(-2).expand(len(depth), -1, -1),
        near=_toeplitz(torch.cat([at_once, later], -1)),
        states=_states(power[:, slow], gain[:, slow], windows[:, :-1, :, :CHUNK].flatten(-2), begin[:, slow]),
        far=(modes.observe[..., slow].mT.unsqueeze(-1) * power[:, slow, WINDOW:-1].unsqueeze(-2)).flatten(-2),
        free=((modes.observe * begin.unsqueeze(-2)) @ power[..., :CHUNK]).flatten(-2),
    )


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
    """(B, C, N) x where each chunk's window begins, from the (B, C, U·L) inputs since the one before; nothing for the first chunk."""
    weights = (gain.unsqueeze(-1) * power[..., :CHUNK].flip(-1).unsqueeze(-2)).flatten(-2)  # (B, N, U·L)
    shared = len(passed) == 1
    added = (passed[0] @ weights.flatten(0, 1).mT).unflatten(-1, begin.shape) if shared else (passed @ weights.mT).transpose(0, 1)
    added[1:2] += power[..., CHUNK - WINDOW] * begin
    return decaying_sums(power[..., CHUNK], added).transpose(0, 1)
