"""A body that conducts heat as one linear system, however finely it was cut, and its modes."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.physics.modes import Modes, respond


@dataclass(frozen=True, eq=False)
class System:
    """dx/dt = −S·x + D·u in coordinates of unit mass; the inputs are the ambient temperatures and, last, the share of the heating power.

    Temperatures are Φ·x + Ψ·dx/dt; Ψ is what cells too fast to follow by themselves are late in a ramp.

    Attributes:
        stiffness: (..., X, X) S, symmetric, positive definite where heat can leave from everywhere [1/s].
        drive: (..., X, U) D.
        lumps: (..., L, X) Φ of the lumps.
        winding: (..., R·C, X) Φ of the winding's cells, row by row from the inside; turns from the bottom.
        late: (..., R·C, X) Ψ of the winding's cells [s].
        cut: R rows across the winding and C columns along its axis that it was cut into.
    """

    stiffness: Tensor
    drive: Tensor
    lumps: Tensor
    winding: Tensor
    late: Tensor
    cut: tuple[int, int]

    def gathered(self, weights: Tensor) -> Tensor:
        """Weights of the turns, (..., layers, turns), to weights of the cells, (..., R·C)."""
        rows = weights if self.cut[0] > 1 else weights.sum(-2, keepdim=True)
        return (rows if self.cut[1] > 1 else rows.sum(-1, keepdim=True)).flatten(-2)


@dataclass(frozen=True, eq=False)
class Watched:
    """What is asked of a body: sums of temperatures, or of their rates.

    Attributes:
        lumps: (..., O, L) weight of each lump.
        turns: (..., O, layers, turns) weight of each turn of the winding.
        is_rate: O times whether the sum is of dT/dt instead of T.
    """

    lumps: Tensor
    turns: Tensor
    is_rate: tuple[bool, ...]


def modes(system: System, watched: Watched) -> Modes:
    """The system in its modes: S = V·Λ·Vᵀ, z = Vᵀ·x.

    Differentiable; the gradient of an eigenvector needs distinct eigenvalues, which a body of unequal parts has.
    """
    decay, vectors = torch.linalg.eigh(system.stiffness)
    cells = system.gathered(watched.turns)
    seen = (watched.lumps @ system.lumps + cells @ system.winding) @ vectors
    late = cells @ system.late @ vectors
    drive = vectors.mT @ system.drive
    rate = torch.tensor(watched.is_rate, device=decay.device).unsqueeze(-1)
    # T = Φx + Ψẋ with ẋ = −Λz + Du; of a rate only Φẋ is kept, exact in a steady ramp.
    falling = -decay.unsqueeze(-2)
    observe = torch.where(rate, falling * seen, seen + falling * late)
    direct = torch.where(rate, seen @ drive, late @ drive)
    return Modes(decay, drive, observe, direct)


def field(system: System, step_s: float, inputs: Tensor, samples: Tensor, start: Tensor | None = None) -> Tensor:
    """Temperatures of all cells of the winding at chosen samples.

    Args:
        system: of one or more devices.
        step_s: from sample to sample [s].
        inputs: (..., U, T) ambient temperatures [°C] and, last, the share of the heating power.
        samples: (K,) which of the T samples.
        start: (..., X) amplitudes of the system's modes at the first sample; None for the steady state in the first inputs.

    Returns:
        (..., K, R, C) [°C].
    """
    decay, vectors = torch.linalg.eigh(system.stiffness)
    drive = vectors.mT @ system.drive
    each = torch.eye(decay.shape[-1], dtype=decay.dtype, device=decay.device)
    states = respond(Modes(decay, drive, each, torch.zeros_like(drive)), step_s, inputs, start)[..., samples]
    rates = drive @ inputs[..., samples] - decay.unsqueeze(-1) * states
    cells = system.winding @ (vectors @ states) + system.late @ (vectors @ rates)
    return cells.mT.unflatten(-1, system.cut)
