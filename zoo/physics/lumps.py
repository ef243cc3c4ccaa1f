"""Bodies of one temperature each, joined by conductances: the gyro around its winding."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Lumps:
    """C·dT/dt = −G·T + g·u(t) + P, batched over devices; textbook lumped conduction (Incropera, ch. 5).

    Attributes:
        capacity: (..., L) C, positive [J/K].
        link: (..., L, L) conductance between lumps, symmetric, zero on the diagonal [W/K].
        ambient: (..., L, A) g from each lump to each ambient temperature [W/K].
        power: (..., L) P, heat released in each lump [W].
    """

    capacity: Tensor
    link: Tensor
    ambient: Tensor
    power: Tensor

    def conductance(self) -> Tensor:
        """(..., L, L) the matrix G = diag(Σ_j K_ij + Σ_a g_ia) − K [W/K]."""
        return torch.diag_embed(self.link.sum(-1) + self.ambient.sum(-1)) - self.link
