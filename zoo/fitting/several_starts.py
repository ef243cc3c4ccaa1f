"""A fit from the best of several starts: where the coil lags far, or not at all, χ² has more than one minimum."""

from __future__ import annotations

from torch import Tensor

from zoo.fitting.design import Design
from zoo.fitting.variable_projection import Fit, fit
from zoo.side_by_side import side_by_side

FOLLOWED, STEPS, FINISHED = 8, 3, 3
"""How many of the starts are followed, for how many steps, and how many of these to the end."""
APART = 1e-3
"""Share by which two χ² must differ for their places to be two."""


def fit_from(design: Design, trials: Tensor, iterations: int = 30, tolerance: float = 1e-4) -> Fit:
    """The best of the fits from the most promising starts.

    Args:
        design: the columns on the runs.
        trials: (G, P) starts in 0…1.
        iterations: see `zoo.fitting.variable_projection.fit`.
        tolerance: see there.
    """

    def fitted(start: Tensor, steps: int) -> Fit:
        return fit(design.plain_columns, design.target, start, steps, tolerance, design.whitener, design.prior)

    order = design.cost(trials).argsort()
    followed = side_by_side(lambda start: fitted(start, STEPS), trials[order[:FOLLOWED]])
    finished = side_by_side(lambda one: fitted(one.theta, iterations), _different(followed)[:FINISHED])
    return min(finished, key=lambda found: found.total)


def cheapest(design: Design, trials: Tensor) -> Tensor:
    """The likeliest θ (P,) of several (G, P)."""
    return trials[0] if len(trials) == 1 else trials[design.cost(trials).argmin()]


def _different(fits: list[Fit]) -> list[Fit]:
    """The fits of different χ², the least first."""
    kept: list[Fit] = []
    for one in sorted(fits, key=lambda found: found.total):
        if not kept or one.total > (1.0 + APART) * kept[-1].total:
            kept.append(one)
    return kept
