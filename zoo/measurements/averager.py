"""Means over the blocks of a record, as the product with a sparse matrix."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property

import torch
from torch import Tensor

NARROW = 100
"""Columns up to which torch is faster with a matrix by rows (twenty times with one), and beyond with one by places (twice)."""


class Averager:
    """Takes weighted means over N blocks of T samples, some of which may belong to none.

    Attributes:
        block: (K,) block of each sample that belongs to one, block by block.
        sample: (K,) its place.
        share: (K,) its share in the block.
        blocks: N.
        samples: T.
    """

    def __init__(self, block: Tensor, sample: Tensor, share: Tensor, blocks: int, samples: int) -> None:
        order = block.argsort(stable=True)
        self.block, self.sample, self.share = block[order], sample[order], share[order]
        self.blocks, self.samples = blocks, samples

    @classmethod
    def weighted(cls, block: Tensor, weight: Tensor) -> Averager:
        """By weights.

        Args:
            block: (T,) block of each sample; -1 for none.
            weight: (T,) weight of each sample in the mean.
        """
        kept = torch.nonzero(block >= 0).squeeze(-1)
        index, own = block[kept], weight[kept]
        blocks = int(block.max()) + 1 if block.numel() else 0
        total = torch.zeros(blocks, dtype=own.dtype, device=own.device).index_add(0, index, own)
        return cls(index, kept, own / total[index], blocks, block.numel())

    @classmethod
    def joined(cls, several: list[Averager], samples: int) -> Averager:
        """Those of several records one after the other, each padded to so many samples."""
        starts = torch.tensor([one.blocks for one in several]).cumsum(0).tolist()
        block = torch.cat([one.block + start - one.blocks for one, start in zip(several, starts, strict=True)])
        sample = torch.cat([one.sample + i * samples for i, one in enumerate(several)])
        return cls(block, sample, torch.cat([one.share for one in several]), starts[-1], len(several) * samples)

    def __call__(self, value: Tensor) -> Tensor:
        """(T, ...) -> (N, ...), in the precision of what it is given."""
        wide = value.reshape(self.samples, -1)
        matrix = self._by_rows if wide.shape[1] <= NARROW else self._by_places
        means: Tensor = torch.sparse.mm(matrix if value.dtype == self.share.dtype else matrix.to(value.dtype), wide)
        return means.reshape(self.blocks, *value.shape[1:])

    @cached_property
    def _by_places(self) -> Tensor:
        """(N, T)."""
        size = (self.blocks, self.samples)
        with _without_remarks():
            return torch.sparse_coo_tensor(torch.stack([self.block, self.sample]), self.share, size, check_invariants=True).coalesce()

    @cached_property
    def _by_rows(self) -> Tensor:
        """(N, T)."""
        with _without_remarks():
            return self._by_places.to_sparse_csr()


@contextmanager
def _without_remarks() -> Iterator[None]:
    """Torch calls all its sparse matrices a beta, and some of its versions remark on a check of them that is asked for here."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Sparse", UserWarning)
        yield
