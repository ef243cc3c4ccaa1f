"""SciPy's stiff solvers, as fast as they go: the right side as one small dense product, the Jacobian given, banded where the solver takes it so."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heat.problem import Body
from scipy.integrate import odeint, solve_ivp


def lsoda(body: Body, air: np.ndarray, tolerance: float = 1e-6) -> np.ndarray:
    """(T, N) by the Fortran loop of `odeint`; tolerance relative, and absolute in K."""
    slope, band, time = _slope(body, air), _band(body.matrix), np.arange(len(air), dtype=float)
    start = np.full(len(body.capacity), air[0])
    return odeint(slope, start, time, Dfun=lambda nodes, t: band, ml=1, mu=1, rtol=tolerance, atol=tolerance, mxstep=100_000)


def lsoda_ivp(body: Body, air: np.ndarray, tolerance: float = 1e-6) -> np.ndarray:
    """(T, N) by `solve_ivp`."""
    band = _band(body.matrix)
    return _ivp(body, air, "LSODA", tolerance, jac=lambda t, nodes: band, lband=1, uband=1)


def radau(body: Body, air: np.ndarray, tolerance: float = 1e-6) -> np.ndarray:
    """(T, N) by `solve_ivp`."""
    return _ivp(body, air, "Radau", tolerance, jac=body.matrix)


def _ivp(body: Body, air: np.ndarray, method: str, tolerance: float, **jacobian: object) -> np.ndarray:
    slope, time = _slope(body, air), np.arange(len(air), dtype=float)
    start = np.full(len(body.capacity), air[0])
    found = solve_ivp(lambda t, nodes: slope(nodes, t), (0, time[-1]), start, method, t_eval=time, rtol=tolerance, atol=tolerance, **jacobian)
    return found.y.T


def _slope(body: Body, air: np.ndarray) -> Callable[[np.ndarray, float], np.ndarray]:
    matrix, pull, samples, last = body.matrix, body.pull, air.tolist(), len(air) - 2

    def slope(nodes: np.ndarray, t: float) -> np.ndarray:
        k = min(int(t), last)
        return matrix.dot(nodes) + pull * (samples[k] + (t - k) * (samples[k + 1] - samples[k]))

    return slope


def _band(matrix: np.ndarray) -> np.ndarray:
    band = np.zeros((3, len(matrix)))
    band[0, 1:], band[1], band[2, :-1] = np.diag(matrix, 1), np.diag(matrix), np.diag(matrix, -1)
    return band
