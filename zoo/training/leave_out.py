"""The dual system of a least-squares support vector machine, and what it would predict for samples that are left out, in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Dual:
    """[[0, 1ᵀ], [1, K + I/γ]]·[b; α] = [0; y] for any number G of γ at once (Suykens & Vandewalle 1999, eq. 14).

    One eigendecomposition K = U·diag(λ)·Uᵀ serves all γ: with H = K + I/γ and h = H⁻¹·1, the lower right block of the whole inverse is
    P = H⁻¹ − h·hᵀ/(1ᵀh), and α = P·y. A left-out set B of samples is missed by e_B = P_BB⁻¹·α_B, exactly, as if the rest had been fitted without it
    (Cawley & Talbot 2004, Neural Networks 17:1467, for one sample; An, Liu & Venkatesh 2007, Pattern Recognition 40:2154, for sets).

    Attributes:
        kernel: (M, M) K.
        target: (M,) y.
        gamma: (G,) γ, the weight of the squared errors beside the squared norm: 1/γ is the noise's variance where the kernel's is 1.
    """

    kernel: Tensor
    target: Tensor
    gamma: Tensor

    @cached_property
    def _eigen(self) -> tuple[Tensor, Tensor]:
        """(M, G) eigenvalues of H⁻¹ and (M, M) U."""
        values, vectors = torch.linalg.eigh(self.kernel)
        return 1.0 / (values.clamp_min(0.0).unsqueeze(-1) + 1.0 / self.gamma), vectors

    def _inverse_times(self, vector: Tensor) -> Tensor:
        """(M,) v -> (M, G) H⁻¹·v."""
        inverse, vectors = self._eigen
        return vectors @ (inverse * (vectors.mT @ vector).unsqueeze(-1))

    @cached_property
    def _ones(self) -> Tensor:
        """(M, G) h."""
        return self._inverse_times(torch.ones_like(self.target))

    @cached_property
    def solution(self) -> tuple[Tensor, Tensor]:
        """(M, G) α and (G,) b."""
        free = self._inverse_times(self.target)
        bias = free.sum(0) / self._ones.sum(0)
        return free - bias * self._ones, bias

    def left_out_errors(self, folds: Tensor | None = None) -> Tensor:
        """What each sample is missed by when the samples of its fold are not fitted.

        Args:
            folds: (M,) number of the fold; None for each sample by itself.

        Returns:
            (M, G); infinite where rounding leaves nothing to be told.
        """
        weight = self.solution[0]
        if folds is None:
            inverse, vectors = self._eigen
            return weight / (vectors.square() @ inverse - self._ones.square() / self._ones.sum(0))
        errors = torch.empty_like(weight)
        for fold in torch.unique(folds):
            index = torch.nonzero(folds == fold).squeeze(-1)
            errors[index] = self._fold_errors(index)
        return errors

    def _fold_errors(self, index: Tensor) -> Tensor:
        """(m, G) errors of one fold (m,)."""
        (inverse, vectors), weight, ones = self._eigen, self.solution[0][index], self._ones[index]
        own, total = vectors[index], self._ones.sum(0)
        block = (own * inverse.mT.unsqueeze(1)) @ own.mT - ones.mT.unsqueeze(2) * ones.mT.unsqueeze(1) / total[:, None, None]
        factor, failed = torch.linalg.cholesky_ex(block)
        missed = torch.cholesky_solve(weight.mT.unsqueeze(-1), factor).squeeze(-1)
        return torch.where(failed.unsqueeze(-1) > 0, torch.inf, missed).mT
