"""Fitted values of a solved grey box."""

from __future__ import annotations

from zoo.diagnosis.workbench import Solved
from zoo.fitting.parameters import Fitted, parameters_of


def fitted_parameters(solved: Solved, unit: str) -> dict[str, Fitted]:
    """See `zoo.fitting.parameters.parameters_of`."""
    return parameters_of(solved.model, solved.fit, unit)
