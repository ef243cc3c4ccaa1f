"""The exact solution of a semi-discrete body by its matrix exponential, second by second: what the others are measured against."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from heat.problem import Body
from scipy.linalg import expm


def exact(body: Body, air: np.ndarray) -> np.ndarray:
    """(T, N) temperatures at every second, the air being linear between."""
    count = len(body.capacity)
    with_air = np.zeros((count + 2, count + 2))
    with_air[:count, :count], with_air[:count, count], with_air[count, count + 1] = body.matrix, body.pull, 1.0
    step = expm(with_air)
    stay = np.ascontiguousarray(step[:count, :count])
    nodes = np.outer(np.append(air[0], air[:-1]), step[:count, count]) + np.outer(np.append(0, np.diff(air)), step[:count, count + 1])
    nodes[0] = air[0]
    for before, now in pairwise(nodes):
        np.add(now, stay.dot(before), out=now)
    return nodes
