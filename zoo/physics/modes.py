"""Linear heat flow in its modes: exact for inputs that are linear between samples, many devices at once, only what is asked for computed."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.physics.network import exponential_weights

CHUNK = 128


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
    obeys x[k+1] = a·x[k] + g·u[k]. Time is cut into chunks: within one the outputs are a Toeplitz product with the inputs, from one to the next the
    states step; all of it in matrix products over chunks and devices.

    Args:
        modes: of B devices.
        step_s: h [s].
        inputs: (..., U, T), one for all devices or one each.
        start: (..., N) z at the first sample; where None, the steady state in the first inputs (every mode has to decay).

    Returns:
        (..., O, T).
    """
    total = inputs.shape[-1]
    length = min(CHUNK, total)
    pieces = (total + length - 1) // length
    depth = modes.rate * step_s
    decay, phi_1, phi_2 = exponential_weights(depth)
    late = (step_s * phi_2).unsqueeze(-1) * modes.drive
    gain = decay.unsqueeze(-1) * late + (step_s * (phi_1 - phi_2)).unsqueeze(-1) * modes.drive
    first = inputs[..., 0]
    begin = (modes.drive @ first.unsqueeze(-1)).squeeze(-1) / modes.rate if start is None else start
    state = begin - (late @ first.unsqueeze(-1)).squeeze(-1)
    power = torch.exp(-depth.unsqueeze(-1) * torch.arange(length + 1, dtype=depth.dtype, device=depth.device))
    padded = torch.nn.functional.pad(inputs, (0, pieces * length - total))
    chunks = padded.unflatten(-1, (pieces, length))  # (..., U, C, L)
    entering = _entering(power, gain, chunks, state)
    own = _toeplitz(modes.observe, power, gain) @ _stacked(chunks)  # (..., O·L, C)
    carried = (modes.observe.unsqueeze(-2) * power[..., :-1].mT.unsqueeze(-3)).flatten(-3, -2) @ entering
    through = (modes.observe @ late + modes.direct) @ inputs
    outputs = (own + carried).unflatten(-2, (modes.observe.shape[-2], length)).transpose(-1, -2).flatten(-2)
    return outputs[..., :total] + through


def _stacked(chunks: Tensor) -> Tensor:
    """(..., U, C, L) -> (..., U·L, C)."""
    return chunks.transpose(-1, -2).flatten(-3, -2)


def _entering(power: Tensor, gain: Tensor, chunks: Tensor, state: Tensor) -> Tensor:
    """(..., N, C) the state with which each chunk begins."""
    length = chunks.shape[-1]
    weights = gain.unsqueeze(-1) * power[..., :-1].flip(-1).unsqueeze(-2)  # (..., N, U, L)
    added = weights.flatten(-2) @ _stacked(chunks)
    leap = power[..., length]
    states = [state + torch.zeros_like(added[..., 0])]
    for piece in range(chunks.shape[-2] - 1):
        states.append(leap * states[-1] + added[..., piece])
    return torch.stack(states, dim=-1)


def _toeplitz(observe: Tensor, power: Tensor, gain: Tensor) -> Tensor:
    """(..., O·L, U·L) response at one sample of a chunk to the input at an earlier one."""
    length = power.shape[-1] - 1
    kernel = torch.einsum("...on,...nl,...nu->...oul", observe, power[..., :length], gain)
    kernel = torch.cat([torch.zeros_like(kernel[..., :1]), kernel[..., :-1]], dim=-1)  # nothing at once, c·g one sample later
    late = torch.arange(length, device=power.device)
    lag = late.unsqueeze(1) - late.unsqueeze(0)
    matrix = torch.where(lag > 0, kernel[..., lag.clamp_min(0)], 0.0)  # (..., O, U, L, L)
    return matrix.transpose(-3, -2).flatten(-2).flatten(-3, -2)
