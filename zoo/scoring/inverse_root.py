"""The inverse root of a noise covariance, quick to multiply with.

Near its diagonal it is a matrix like any other; away from it, its rank is no higher than the noise has states. White noise with a chain of Markov
processes is semiseparable, and so is the inverse of its root (Vandebril, Van Barel & Mastronardi 2008, Matrix Computations and Semiseparable
Matrices): what the past tells of a block is told by the states that it leads to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor

ROWS = 48
"""Of a band, about: fewer make more of the states between bands, more of the triangles on the diagonal."""
STATES = 16
"""Most states that are looked for."""
WEAK = 1e-12
"""Size of a state over that of the largest from which on it may be rounding."""
ROUNDING = 1e-12
"""Of the largest element: a matrix that states do not give within that is multiplied as it is."""


@dataclass(frozen=True, eq=False)
class _Bands:
    """A triangular matrix in G bands of M rows each.

    Attributes:
        here: (G, M, M) on the diagonal.
        told: (G, R, M) what states a band leaves.
        between: (G·R, G·R) what these are for all later bands.
        states: (G, M, R) what the states before it make of a band.
    """

    here: Tensor
    told: Tensor
    between: Tensor
    states: Tensor

    def product(self, columns: Tensor) -> Tensor:
        """(G·M, K) of columns (G·M, K)."""
        split = columns.reshape(*self.here.shape[:2], -1)
        left = self.between @ torch.bmm(self.told, split).flatten(0, 1)
        return torch.bmm(self.here, split).baddbmm_(self.states, left.unflatten(0, (len(split), -1))).flatten(0, 1)

    def single(self) -> _Bands:
        """The same in single precision."""
        return _Bands(self.here.float(), self.told.float(), self.between.float(), self.states.float())


class InverseRoot:
    """The inverse of the lower triangular root of a covariance; the root of the first of its rows and columns is the first of it.

    Attributes:
        matrix: (N, N) lower triangular.
    """

    def __init__(self, covariance: Tensor) -> None:
        """Factorise once.

        Args:
            covariance: (N, N) of the block means of one run [unit²].
        """
        factor = torch.linalg.cholesky(covariance)
        unit = torch.eye(len(factor), dtype=factor.dtype, device=factor.device)
        self.matrix = torch.linalg.solve_triangular(factor, unit, upper=False)

    def __len__(self) -> int:
        """How many blocks it is for."""
        return len(self.matrix)

    def __matmul__(self, columns: Tensor) -> Tensor:
        """(N, K) of columns (N, K), in their precision."""
        bands = self._bands if columns.dtype == self.matrix.dtype else self._single
        if bands is None:
            return self.matrix.to(columns.dtype) @ columns
        more = bands.here.shape[0] * bands.here.shape[1] - len(columns)
        whole = torch.nn.functional.pad(columns, (0, 0, 0, more)) if more else columns
        return bands.product(whole)[: len(columns)]

    @cached_property
    def _bands(self) -> _Bands | None:
        return _bands(self.matrix)

    @cached_property
    def _single(self) -> _Bands | None:
        return self._bands and self._bands.single()


def _bands(matrix: Tensor) -> _Bands | None:
    """A lower triangular matrix in bands; None where no few states tell what is before them.

    The states of a band are found from what it makes of a few random columns (Halko et al. 2011, SIAM Rev. 53:217), those that it leaves from what
    all later ones make of it.
    """
    count = max(math.ceil(len(matrix) / ROWS), 1)
    rows = math.ceil(len(matrix) / count)
    more = count * rows - len(matrix)
    blocks = torch.nn.functional.pad(matrix, (0, more, 0, more)).reshape(count, rows, count, rows)
    here = torch.stack([blocks[i, :, i] for i in range(count)])
    past = blocks.clone()
    for i in range(count):
        past[i, :, i] = 0.0
    before = past.reshape(count * rows, count * rows)
    seen = torch.randn(count * rows, STATES, generator=torch.Generator().manual_seed(0), dtype=matrix.dtype).to(matrix.device)
    states, told = (_ways((one @ seen).reshape(count, rows, -1)) for one in (before, before.mT))
    between = torch.einsum("gmr,gmhn,hns->grhs", states, past, told)
    lost = past - torch.einsum("gmr,grhs,hns->gmhn", states, between, told)
    if float(lost.abs().max()) > ROUNDING * float(matrix.abs().max()):
        return None
    wide = between.reshape(count * states.shape[-1], count * told.shape[-1])
    return _Bands(here, told.mT.contiguous(), wide.contiguous(), states.contiguous())


def _ways(seen: Tensor) -> Tensor:
    """(G, M, R) orthonormal, along which what was seen (G, M, S) lies, in as many directions as any band has."""
    ways, sizes = torch.linalg.qr(seen)
    sizes = sizes.diagonal(dim1=-2, dim2=-1).abs()
    return ways[..., : int((sizes > WEAK * sizes.max()).sum(dim=-1).max())]
