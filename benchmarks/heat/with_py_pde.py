"""py-pde: 36 cells, its operators compiled, SciPy's LSODA: the fastest of its solvers here; its own implicit ones do not converge at 1 s."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heat.problem import CONDUCTIVITY, CONTACT, FILM, HEAT_CAPACITY, INNER_M, LAYERS, WIDTH_M
from pde import CallbackTracker, DiffusionPDE, PolarSymGrid, ScalarField


def py_pde(air: np.ndarray, tolerance: float = 1e-6) -> Callable[[int], np.ndarray]:
    """What runs for so many seconds, seen every second: (T, 36)."""
    faces = {side: _film(film / CONDUCTIVITY, np.append(air, air[-1])) for side, film in (("r-", CONTACT), ("r+", FILM))}
    start = ScalarField(PolarSymGrid((INNER_M, INNER_M + WIDTH_M), LAYERS), air[0])
    equation = DiffusionPDE(CONDUCTIVITY / HEAT_CAPACITY, bc=faces)
    settings = {"solver": "scipy", "method": "LSODA", "rtol": tolerance, "atol": tolerance, "backend": "numba"}

    def run(seconds: int) -> np.ndarray:
        found: list[np.ndarray] = []
        tracker = CallbackTracker(lambda state, time: found.append(state.data.copy()), interrupts=1.0)
        equation.solve(start, t_range=seconds, dt=1.0, tracker=[tracker], **settings)
        return np.array(found)

    return run


def _film(ratio: float, air: np.ndarray) -> dict[str, object]:
    """∂T/∂n + ratio·T = ratio·air."""

    def drawn(value: float, spacing: float, radius: float, time: float) -> float:
        k = int(time)
        return ratio * (air[k] + (time - k) * (air[k + 1] - air[k]))

    annotated: Callable[..., float] = drawn
    return {"type": "mixed_expression", "value": ratio, "const": annotated}
