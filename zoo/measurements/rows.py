"""Some rows of a file: as numbers, and as they stand there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa


@dataclass(frozen=True, eq=False)
class Rows:
    """Consecutive rows.

    Attributes:
        numbers: (M, C) float64 of the columns asked for; missing cells are NaN.
        kept: the same rows with all their columns, piece by piece: lines of text, or Arrow's batches; empty where nobody asked for them.
        share: how much of the file has been read with them, 0…1.
    """

    numbers: np.ndarray
    kept: tuple[bytes | pa.RecordBatch, ...]
    share: float

    def __add__(self, later: Rows) -> Rows:
        return Rows(np.concatenate([self.numbers, later.numbers]), (*self.kept, *later.kept), later.share)
