"""Forward and backward regression by p-values on the same columns."""

from __future__ import annotations

import numpy as np
from hidden_effects.body import Array
from hidden_effects.peers.columns import Library
from statsmodels.regression.linear_model import OLS

LEVEL = 0.01
"""Of significance, shared among the columns (Bonferroni)."""
MOST = 12


def stepwise(given: Library) -> list[str]:
    """Effects of the columns that stay: the most significant is added, the least is dropped when it no longer is, until nothing changes."""
    level, chosen = LEVEL / len(given.effects), list[int]()
    while len(chosen) < MOST:
        best = _most_correlated(given, chosen)
        if best in chosen or _p_values(given, [*chosen, best])[-1] > level:
            break
        chosen.append(best)
        p = _p_values(given, chosen)
        chosen = [one for one, value in zip(chosen, p, strict=True) if value <= level]
    return given.named(np.isin(np.arange(len(given.effects)), chosen))


def _design(given: Library, chosen: list[int]) -> Array:
    joined = np.column_stack([given.base, given.columns[:, chosen]])
    return np.asarray(joined / np.abs(joined).max(0))


def _p_values(given: Library, chosen: list[int]) -> Array:
    """P-value of each chosen column."""
    return np.asarray(OLS(given.error, _design(given, chosen)).fit().pvalues[given.base.shape[1] :])


def _most_correlated(given: Library, chosen: list[int]) -> int:
    """Which column has the largest partial correlation with the error, and so the least p-value."""
    basis, _ = np.linalg.qr(_design(given, chosen))
    joined = np.column_stack([given.columns / np.linalg.norm(given.columns, axis=0), given.error])
    left = joined - basis @ (basis.T @ joined)
    norm = np.linalg.norm(left[:, :-1], axis=0)
    return int((np.abs(left[:, :-1].T @ left[:, -1]) / np.where(norm > 1e-6, norm, np.inf)).argmax())
