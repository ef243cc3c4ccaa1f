"""Initial weights drawn at random."""

from __future__ import annotations

import copy

import torch
from torch import Tensor

from zoo.given import check_seed
from zoo.training.init import Init, Log
from zoo.training.problem import Problem
from zoo.training.weights import reset, weight_vector


class RandomInit(Init):
    """Drawn from the given seed alone, see `zoo.training.weights.reset`."""

    def __init__(self, seed: int = 1) -> None:
        check_seed("init.seed", seed)
        self.seed = seed

    def weights(self, problem: Problem, members: int, log: Log) -> Tensor:
        """See `Init.weights`."""
        model, drawn = copy.deepcopy(problem.model), []
        for seed in range(self.seed, self.seed + members):
            reset(model, torch.Generator().manual_seed(seed))
            drawn.append(weight_vector(model))
        return torch.stack(drawn)
