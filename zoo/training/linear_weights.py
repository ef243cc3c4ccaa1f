"""The weights that a model is linear in, solved for wherever the others are: variable projection (Golub & Pereyra 1973)."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor
from torch.func import functional_call, jvp, vmap

from zoo.models.base import FeatureModel
from zoo.models.head import Head, as_parameters
from zoo.training.tape import Recorded

RIDGE = 1e-12
"""Over the mean square of the columns: nodes of a network may be alike, or always one."""


class LinearWeights:
    """Least squares for the parameters that a model names in `linear_in`, from where they are.

    A model whose buffers change afterwards needs new ones.

    Attributes:
        index: (K,) their places among the weights.
    """

    def __init__(self, model: FeatureModel) -> None:
        """Find them.

        Args:
            model: lends its structure and its buffers.
        """
        self.head = Head(model)
        linear = {self.head.prefix + name for name in model.linear_in}
        self.shapes = {name: shape for name, shape in self.head.shapes.items() if name in linear}
        every = torch.arange(self.head.size)
        places = as_parameters(every, self.head.shapes)
        self.index = torch.cat([every[:0], *(places[name].flatten() for name in self.shapes)])
        self.columns = Recorded(vmap(self._columns, in_dims=(0, None)))
        """(E, D) weights and (M, F) features -> (E, M) outputs and (E, K, M) what multiplies each linear weight, both in the output's unit."""

    def _columns(self, weights: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
        parameters = as_parameters(weights, self.head.shapes)

        def outputs(linear: dict[str, Tensor]) -> Tensor:
            found: Tensor = functional_call(self.head, parameters | linear, (features,))
            return found

        here = {name: parameters[name] for name in self.shapes}
        if not here:
            plain = outputs(here)
            return plain, plain.new_empty(0, len(plain))
        ways = as_parameters(torch.eye(len(self.index), dtype=weights.dtype, device=weights.device), self.shapes)
        # One evaluation of what is not linear serves all columns, as it does not depend on the way.
        both: Any = vmap(lambda way: jvp(outputs, (here,), (way,)))(ways)
        return both[0][0], both[1]

    def solved(self, weights: Tensor, square: Tensor, slope: Tensor, normal: Tensor) -> tuple[Tensor, Tensor]:
        """Weights with the linear ones solved for, and what is left.

        From a residual instead of from the target itself: the closer to the end, the less is lost in the differences.

        Args:
            weights: (E, D).
            square: (E,) squared length of the residual r there.
            slope: (E, K) Aᵀr with the columns A in the units of the residual.
            normal: (E, K, K) AᵀA.

        Returns:
            (E, D) weights and (E,) squared lengths of the residuals.
        """
        if not len(self.index):
            return weights, square
        floor = RIDGE * normal.diagonal(dim1=-2, dim2=-1).mean(-1, keepdim=True) + 1e-300
        triangle, failed = torch.linalg.cholesky_ex(normal + torch.diag_embed(floor.expand_as(slope)))
        step = torch.cholesky_solve(slope.unsqueeze(-1), triangle).squeeze(-1)
        left = square - (step * (2 * slope - (normal @ step.unsqueeze(-1)).squeeze(-1))).sum(-1)
        better = (left < square) & (failed == 0)
        moved = weights.index_add(1, self.index.to(weights.device), step)
        return torch.where(better.unsqueeze(-1), moved, weights), torch.where(better, left.clamp_min(0.0), square)
