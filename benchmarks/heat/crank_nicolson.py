"""Crank–Nicolson in steps of 1 s, prefactored, three ways: (C + hG/2)·T₁ = (C − hG/2)·T₀ + hg·(u₀ + u₁)/2."""

from __future__ import annotations

from itertools import pairwise

import numba
import numpy as np
from heat.problem import Body
from scipy.linalg.lapack import dpttrf, dpttrs


def propagated(body: Body, air: np.ndarray) -> np.ndarray:
    """(T, N) with the whole step as one dense matrix; for so few nodes the fastest in NumPy."""
    inverse = np.linalg.inv(np.diag(body.capacity) + body.conductance / 2)
    step = inverse @ (np.diag(body.capacity) - body.conductance / 2)
    nodes = np.outer(np.append(0, air[1:] + air[:-1]), inverse @ body.ambient / 2)
    nodes[0] = air[0]
    for before, now in pairwise(nodes):
        np.add(now, step.dot(before), out=now)
    return nodes


def tridiagonal(body: Body, air: np.ndarray) -> np.ndarray:
    """(T, N) with LAPACK's factors: T₁ = 2(C + hG/2)⁻¹(C·T₀ + hg·(u₀ + u₁)/4) − T₀."""
    diagonal, beside, _ = dpttrf(body.capacity + np.diag(body.conductance) / 2, np.diag(body.conductance, 1) / 2)
    nodes = np.outer(np.append(0, air[1:] + air[:-1]), body.ambient / 4)
    nodes[0] = air[0]
    for before, now in pairwise(nodes):
        solved = dpttrs(diagonal, beside, now + body.capacity * before)[0]
        np.subtract(2 * solved, before, out=now)
    return nodes


def compiled(body: Body, air: np.ndarray) -> np.ndarray:
    """(T, N) with Thomas's algorithm in a compiled loop (Numba, which py-pde brings along)."""
    diagonal, beside = np.diag(body.conductance).copy(), np.diag(body.conductance, 1).copy()
    return _thomas(air, body.capacity, diagonal, beside, body.ambient)


@numba.njit(fastmath=True)
def _thomas(air, capacity, diagonal, beside, ambient):
    count = len(capacity)
    pivot, factor = capacity + diagonal / 2, beside / 2
    for i in range(count - 1):
        factor[i] /= pivot[i]
        pivot[i + 1] -= factor[i] * beside[i] / 2
    inverse, solved = 1 / pivot, np.empty(count)
    nodes = np.empty((len(air), count))
    nodes[0] = air[0]
    for k in range(len(air) - 1):
        drawn = (air[k] + air[k + 1]) / 4
        solved[0] = capacity[0] * nodes[k, 0] + drawn * ambient[0]
        for i in range(1, count):
            solved[i] = capacity[i] * nodes[k, i] + drawn * ambient[i] - factor[i - 1] * solved[i - 1]
        solved[-1] *= inverse[-1]
        for i in range(count - 2, -1, -1):
            solved[i] = solved[i] * inverse[i] - factor[i] * solved[i + 1]
        for i in range(count):
            nodes[k + 1, i] = 2 * solved[i] - nodes[k, i]
    return nodes
