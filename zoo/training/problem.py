"""The weights of a network as the unknowns of a standardised least-squares problem: what searches, steps and ensembles all work on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial

import torch
from torch import Tensor
from torch.linalg import vector_norm

from zoo.measurements.run import Run
from zoo.models.base import FeatureModel
from zoo.models.scaler import spread
from zoo.training.fine_blocks import FineBlocks, samples_in, standardised
from zoo.training.linear_weights import LinearWeights
from zoo.training.population import Population, even
from zoo.training.tape import Recorded
from zoo.training.weights import ROWS_OF_COLUMNS, derivatives, weight_vector

Columns = Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]
"""(E, D) weights and (M, F) features -> (E, M) outputs and (E, K, M) derivatives."""

MOST_OF_A_DESIGN = 4_000_000
"""Numbers in the design matrix of a model that is linear in its weights, up to which it is kept."""


class Problem:
    """Loss of a network as a function of its weights: squared error over the error's variance.

    Attributes:
        model: lends its structure and its buffers, standardised already.
        features: (M, F).
        error: (M,) [output's unit].
        scale: the error's standard deviation [output's unit]; 1 where it never changes.
        size: D, number of weights.
        places: (S, D/S) the groups of weights of which each sample sees one, see `FeatureModel.parts`.
        member: (M, S) 1 where a sample belongs to a group.
    """

    def __init__(self, model: FeatureModel, features: Tensor, error: Tensor) -> None:
        self.model, self.features, self.error = model, features, error
        self.scale = float(spread(error))
        self.size = len(weight_vector(model))
        self.population, self.linear = Population(model, features), LinearWeights(model)
        self._derivatives = Recorded(partial(derivatives, model))
        self.places, part = model.parts(features)
        self.member = torch.nn.functional.one_hot(part, len(self.places)).to(error)
        self.design = self.population.affine() if len(self.linear.index) == self.size and len(features) * self.size <= MOST_OF_A_DESIGN else None

    @classmethod
    def of_runs(cls, model: FeatureModel, runs: Sequence[Run], device: str = "cpu") -> Problem:
        """The block means of some runs as a problem on a device, where the model is standardised on them and moved to.

        Raises:
            InputError: no block to fit.
        """
        whole, rows, error = standardised(model, runs)
        return cls(whole.to(device), rows.to(device), error.to(device))

    @cached_property
    def of_means(self) -> Problem:
        """The same of the blocks' mean features, for what wants each block to be one point."""
        return Problem(self.model.model, self.model.means(self.features), self.error) if isinstance(self.model, FineBlocks) else self

    def _costs(self, weights: Tensor, cost: Callable[[Tensor], Tensor]) -> Tensor:
        """(P, D) weights -> (P, ...), see `Population.costs`; one product where the model is linear in all its weights."""
        if self.design is None:
            return self.population.costs(weights, cost)
        constant, columns = self.design
        pieces = weights.split(max(ROWS_OF_COLUMNS // len(self.error), 1))
        return torch.cat([cost(torch.addmm(constant, some, columns)) for some in pieces])

    def losses(self, weights: Tensor) -> Tensor:
        """(..., D) weights -> (...) losses; memory does not grow with their number."""
        lengths = self._costs(weights.reshape(-1, self.size), lambda some: vector_norm(self.error - some, dim=-1)) / self.scale
        return (lengths.square() / len(self.error)).view(weights.shape[:-1])

    def losses_of_parts(self, weights: Tensor) -> Tensor:
        """What the samples of each group of weights add to the loss, so that the groups can be searched for side by side.

        Of several groups the blocks' mean features count: a block's fine samples could belong to two of them.

        Args:
            weights: (..., S, P, D/S), group by group.

        Returns:
            (..., S, P).
        """
        joined = torch.empty((*weights.shape[:-3], weights.shape[-2], self.size), dtype=weights.dtype, device=weights.device)
        joined[..., self.places] = weights.movedim(-3, -2)
        if len(self.places) == 1:
            return self.losses(joined).unsqueeze(-2)
        squares = self.of_means._costs(joined.reshape(-1, self.size), lambda some: ((self.error - some) / self.scale).square() @ self.member)
        return (squares / len(self.error)).view(*joined.shape[:-1], -1).movedim(-1, -2)

    def normal_equations(self, weights: Tensor) -> tuple[Tensor, Tensor]:
        """JᵀJ and Jᵀr of the mean squared residual, so that they go with `losses`; in bounded memory.

        Args:
            weights: (E, D).

        Returns:
            (E, D, D) and (E, D), J being the derivative of the outputs and r the residual, both in units of the error's spread and over √M.
        """
        normal, slope, _ = self._summed(weights, self._derivatives, self.size)
        return normal, slope

    def solved(self, weights: Tensor) -> tuple[Tensor, Tensor]:
        """Weights with those that the model is linear in solved for, see `zoo.training.linear_weights`; in bounded memory.

        Args:
            weights: (E, D).

        Returns:
            (E, D) weights and (E,) losses.
        """
        linear = len(self.linear.index)
        if not linear:
            return weights, self.losses(weights)
        normal, slope, square = self._summed(weights, self.linear.columns, linear)
        return self.linear.solved(weights, square, slope, normal)

    def _summed(self, weights: Tensor, columns: Columns, size: int) -> tuple[Tensor, Tensor, Tensor]:
        """(E, K, K) AᵀA, (E, K) Aᵀr and (E,) rᵀr of the residual r and some of its columns A, in units of the error's spread and over √M."""
        most = max(ROWS_OF_COLUMNS // samples_in(self.model), 1)
        rows = even(len(self.features), most)
        members = max(most // rows, 1)
        found = []
        for some in weights.split(even(len(weights), members)):
            normal, slope, square = some.new_zeros(len(some), size, size), some.new_zeros(len(some), size), some.new_zeros(len(some))
            for features, error in zip(self.features.split(rows), self.error.split(rows), strict=True):
                outputs, ways = columns(some, features)
                residual = (error - outputs).unsqueeze(-1)
                normal += ways @ ways.mT
                slope += (ways @ residual).squeeze(-1)
                square += residual.square().sum((-2, -1))
            found.append((normal, slope, square))
        normal, slope, square = (torch.cat(parts) / (self.scale**2 * len(self.error)) for parts in zip(*found, strict=True))
        return normal, slope, square
