"""PySINDy at its fairest: the base taken out first, columns scaled, the threshold by a run that was held out."""

from __future__ import annotations

import warnings

import numpy as np
import pysindy
from hidden_effects.body import Array
from hidden_effects.peers.columns import Library

THRESHOLDS = np.array([*np.geomspace(0.05, 1.5, 16), 1e9])
"""The last keeps nothing. Of a coefficient over the residual's standard deviation, for columns of unit standard deviation."""


def sindy(given: Library) -> list[str]:
    """Effects of the columns that sequentially thresholded least squares keeps (Brunton, Proctor and Kutz 2016, PNAS 113:3932).

    The threshold is the largest that loses no more than a standard error of that loss, block by block, against the best one on the run held out,
    the last one or the last third of a single one; then all runs are fitted with it.
    """
    last = given.run == given.run.max() if given.run.max() else np.arange(len(given.run)) >= 2 * len(given.run) // 3
    columns, target = _without_base(given, ~last)
    columns, target = columns / columns[~last].std(0).clip(1e-12), target / target[~last].std()
    errors = [(target[last] - columns[last] @ _kept(columns[~last], target[~last], size)) ** 2 for size in THRESHOLDS]
    best = min(errors, key=np.mean)
    worse = [error - best for error in errors]
    size = max(size for size, loss in zip(THRESHOLDS, worse, strict=True) if loss.mean() <= loss.std() / np.sqrt(len(loss)))
    columns, target = _without_base(given, np.ones_like(last))
    return given.named(_kept(columns / columns.std(0).clip(1e-12), target / target.std(), size) != 0)


def _without_base(given: Library, rows: Array) -> tuple[Array, Array]:
    """Columns and error less what the base explains of them, fitted to some rows (Frisch, Waugh and Lovell)."""
    joined = np.column_stack([given.columns, given.error])
    weights = np.linalg.lstsq(given.base[rows] / (scale := np.abs(given.base).max(0)), joined[rows], rcond=1e-10)[0]
    left = joined - given.base / scale @ weights
    return left[:, :-1], left[:, -1]


def _kept(columns: Array, target: Array, threshold: float) -> Array:
    """(K,) coefficients."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it warns of every threshold that keeps nothing
        optimizer = pysindy.STLSQ(threshold=threshold, alpha=1e-3)
        model = pysindy.SINDy(optimizer=optimizer, feature_library=pysindy.IdentityLibrary())
        model.fit(columns, t=1.0, x_dot=target[:, None])
    return np.asarray(model.coefficients()[0])
