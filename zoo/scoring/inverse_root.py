"""The inverse root of a noise covariance, quick to multiply with.

Near its diagonal it is a matrix like any other; away from it, its rank is no higher than the noise has states. White noise with a chain of Markov
processes is semiseparable, and so is the inverse of its root (Vandebril, Van Barel & Mastronardi 2008, Matrix Computations and Semiseparable
Matrices): what the past tells of a block is told by the states that it leads to.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor

ROWS = 72
"""Of a band: half as many cost as much for their number, twice as many for the triangle on the diagonal."""
STATES = 16
"""Most states that are looked for."""
ROUNDING = 1e-12
"""Of the largest element: a band whose past is not of so low a rank within that is kept as it is."""


@dataclass(frozen=True, eq=False)
class _Band:
    """Rows of a triangular matrix: what is on its diagonal, and what is before that, as a product where its rank is low.

    Attributes:
        start: first row.
        end: behind the last row.
        here: (M, M) on the diagonal.
        states: (M, R) by which the past is known, or None.
        past: (R, start) what of the past they are; where there are none, (M, start) itself.
    """

    start: int
    end: int
    here: Tensor
    states: Tensor | None
    past: Tensor

    def product(self, columns: Tensor) -> Tensor:
        """(M, K) of columns (N, K)."""
        found = self.here @ columns[self.start : self.end]
        if not self.start:
            return found
        before = self.past @ columns[: self.start]
        return found.add_(before) if self.states is None else found.addmm_(self.states, before)

    def single(self) -> _Band:
        """The same in single precision."""
        return _Band(self.start, self.end, self.here.float(), None if self.states is None else self.states.float(), self.past.float())


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
        return bands[0].product(columns) if len(bands) == 1 else torch.cat([band.product(columns) for band in bands])

    @cached_property
    def _bands(self) -> list[_Band]:
        size = len(self.matrix)
        return [_band(self.matrix, start, min(start + ROWS, size)) for start in range(0, size, ROWS)]

    @cached_property
    def _single(self) -> list[_Band]:
        return [band.single() for band in self._bands]


def _band(matrix: Tensor, start: int, end: int) -> _Band:
    """Some rows; the states that their past leads to are found from what it makes of a few random columns (Halko et al. 2011, SIAM Rev. 53:217)."""
    here, past = matrix[start:end, start:end].contiguous(), matrix[start:end, :start]
    seen = torch.randn(start, STATES, generator=torch.Generator().manual_seed(0), dtype=matrix.dtype).to(matrix.device)
    ways, sizes = torch.linalg.qr(past @ seen)
    sizes = sizes.diagonal().abs()
    states = ways[:, sizes > ROUNDING * sizes.max()] if start else ways
    low = states.mT @ past
    if start and float((past - states @ low).abs().max()) > ROUNDING * float(matrix.abs().max()):
        return _Band(start, end, here, None, past.contiguous())
    return _Band(start, end, here, states.contiguous() if start else None, low.contiguous())
