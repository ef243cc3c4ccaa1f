"""The modes of zoo.physics, for one device or many."""

from __future__ import annotations

import numpy as np
import torch
from heat.problem import Body, Watched
from torch import Tensor

from zoo.physics.modes import Modes, respond


def ours(body: Body, air: np.ndarray, watched: Watched) -> Tensor:
    """(..., O, T), from the matrices to the outputs."""
    root = torch.from_numpy(body.capacity).sqrt()
    decay, vectors = torch.linalg.eigh(torch.from_numpy(body.conductance) / torch.outer(root, root))
    drive = vectors.mT @ (torch.from_numpy(body.ambient) / root).unsqueeze(-1)
    level, rate = ((torch.from_numpy(weight) / root) @ vectors for weight in (watched.level, watched.rate))
    return respond(Modes(decay, drive, level - rate * decay.unsqueeze(-2), rate @ drive), 1.0, torch.from_numpy(air).unsqueeze(0))
