"""FiPy: 36 cells, backward Euler, the direct solver of SciPy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from fipy import CellVariable, CylindricalGrid1D, DiffusionTerm, FaceVariable, ImplicitSourceTerm, TransientTerm, Variable
from fipy.solvers import LinearLUSolver
from heat.problem import CONDUCTIVITY, CONTACT, FILM, HEAT_CAPACITY, INNER_M, LAYERS, PITCH_M


def fipy(air: np.ndarray) -> Callable[[int], np.ndarray]:
    """What runs for so many seconds in steps of 1 s: (T, 36)."""
    mesh = CylindricalGrid1D(nr=LAYERS, dr=PITCH_M, origin=(INNER_M,))
    temperature, ambient = CellVariable(mesh=mesh), Variable(value=air[0])
    inside, through = FaceVariable(mesh=mesh, value=CONDUCTIVITY), FaceVariable(mesh=mesh, value=0.0)
    inside.setValue(0.0, where=mesh.exteriorFaces)
    for film, face in ((CONTACT, mesh.facesLeft), (FILM, mesh.facesRight)):
        through.setValue(1 / (1 / film + PITCH_M / 2 / CONDUCTIVITY), where=face)
    lost = (through * mesh.faceNormals).divergence
    balance = TransientTerm(coeff=HEAT_CAPACITY) == DiffusionTerm(coeff=inside) + lost * ambient - ImplicitSourceTerm(coeff=lost)
    solver = LinearLUSolver(tolerance=1e-12, iterations=5)

    def run(seconds: int) -> np.ndarray:
        temperature.setValue(air[0])
        found = [temperature.value.copy()]
        for now in air[1 : seconds + 1]:
            ambient.value = now
            balance.solve(var=temperature, dt=1.0, solver=solver)
            found.append(temperature.value.copy())
        return np.array(found)

    return run
