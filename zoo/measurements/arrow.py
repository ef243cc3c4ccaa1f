"""From Arrow's memory to NumPy's."""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa


def numbers(column: pa.Array) -> np.ndarray:
    """(M,) float64 of a column of numbers; missing cells are NaN.

    Not ``column.to_numpy()``: that imports pandas, which takes half a second, and an interrupt in the meantime is lost.
    """
    plain = column.cast(pa.float64(), safe=False)
    filled = plain.fill_null(math.nan) if plain.null_count else plain
    return np.frombuffer(filled.buffers()[1], np.float64, len(filled), 8 * filled.offset)
