"""SciPy's stiff solvers, as fast as they go: the right side as one small dense product, the Jacobian given, banded where the solver takes it so."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heat.problem import Body, Watched
from scipy.integrate import LSODA, odeint, solve_ivp


def lsoda(body: Body, air: np.ndarray, tolerance: float = 1e-6) -> np.ndarray:
    """(T, N) by the Fortran loop of `odeint`; tolerance relative, and absolute in K."""
    slope, band, time = _slope(body, air), _band(body.matrix), np.arange(len(air), dtype=float)
    start = np.full(len(body.capacity), air[0])
    return odeint(slope, start, time, Dfun=lambda nodes, t: band, ml=1, mu=1, rtol=tolerance, atol=tolerance, mxstep=100_000)


def lsoda_ivp(body: Body, air: np.ndarray, tolerance: float = 1e-6) -> np.ndarray:
    """(T, N) by `solve_ivp`."""
    band = _band(body.matrix)
    return _ivp(body, air, "LSODA", tolerance, jac=lambda t, nodes: band, lband=1, uband=1)


def lsoda_stacked(bodies: Body, air: np.ndarray, watched: Watched, tolerance: float = 1e-6) -> np.ndarray:
    """(B, O, T) of devices stacked into one system, with one sequence of steps; of each step's polynomial only the outputs are sampled."""
    count, size = bodies.ambient.shape
    below, middle, above = (np.diagonal(-bodies.conductance, beside, 1, 2) for beside in (-1, 0, 1))
    band = np.zeros((3, count, size))
    band[0, :, 1:], band[1], band[2, :, :-1] = above / bodies.capacity[:-1], middle / bodies.capacity, below / bodies.capacity[1:]
    band = band.reshape(3, -1)
    pull, samples, last = bodies.pull.ravel(), air.tolist(), len(air) - 2

    def slope(t: float, nodes: np.ndarray) -> np.ndarray:
        k = min(int(t), last)
        found = band[1] * nodes
        found[:-1] += band[0, 1:] * nodes[1:]
        found[1:] += band[2, :-1] * nodes[:-1]
        found += pull * (samples[k] + (t - k) * (samples[k + 1] - samples[k]))
        return found

    weights = watched.level + watched.rate @ bodies.matrix
    answer = (watched.rate @ bodies.pull[..., None]) * air
    solver = LSODA(slope, 0.0, np.full(count * size, air[0]), len(air) - 1.0, rtol=tolerance, atol=tolerance, jac=lambda t, y: band, lband=1, uband=1)
    answer[..., 0] += air[0] * weights.sum(-1)
    while solver.status == "running":
        solver.step()
        step = solver.dense_output()
        inside = np.arange(int(solver.t_old) + 1, int(solver.t) + 1)
        powers = ((inside - step.t) / step.h) ** step.p[:, None]
        answer[..., inside] += weights @ step.yh.reshape(count, size, -1) @ powers
    return answer


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
