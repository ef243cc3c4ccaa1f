"""Smooth functions of what a residual may depend on, whatever their physics: what an effect outside the catalogue would have to be like."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.workbench import Solved, Workbench

ORDER = 6
JOINT_ORDER = 3
TEMPERATURE, RATE = "the coil's temperature", "the coil's temperature rate"
FLAT = 1e-9


def free_functions(bench: Workbench, solved: Solved) -> dict[str, Tensor]:
    """Columns of a free function of each quantity, by what it depends on in words.

    One quantity: Chebyshev polynomials of order 1 to 6. Temperature and rate together: products of orders 1 to 3.

    Args:
        bench: the runs.
        solved: the model whose places the quantities are taken at.

    Returns:
        (N, 6) or (N, 9) block means each.
    """
    quantities = {words: values for words, values in _quantities(bench, solved).items() if float(values.max() - values.min()) > FLAT}
    functions = {words: _chebyshev(values, ORDER) for words, values in quantities.items()}
    if TEMPERATURE in quantities and RATE in quantities:
        pairs = _chebyshev(quantities[TEMPERATURE], JOINT_ORDER).unsqueeze(2) * _chebyshev(quantities[RATE], JOINT_ORDER).unsqueeze(1)
        functions["the coil's temperature and its rate together"] = pairs.flatten(1)
    return functions


def _quantities(bench: Workbench, solved: Solved) -> dict[str, Tensor]:
    """(N,) block means of each quantity."""
    parts: dict[str, list[Tensor]] = {}
    for run, place in zip(bench.runs, solved.design.histories(solved.fit.theta), strict=True):
        here = place["coil"]
        found = {
            TEMPERATURE: here.temperature,
            RATE: here.rate,
            "the size of the temperature rate, not its sign": here.rate.abs(),
            "the time since the run's start": here.time,
            "the highest temperature so far": torch.cummax(here.temperature, dim=-1).values,
            "the true input": here.reference,
        }
        for words, values in {**found, **{f"the column {name}": column for name, column in here.inputs.items()}}.items():
            parts.setdefault(words, []).append(run.block_mean(values))
    return {words: torch.cat(values) for words, values in parts.items()}


def _chebyshev(values: Tensor, order: int) -> Tensor:
    """(N, order) Chebyshev polynomials of order 1 and up of values scaled to −1…1."""
    low, high = values.min(), values.max()
    angle = torch.arccos((2 * (values - low) / (high - low) - 1).clamp(-1, 1))
    return torch.stack([torch.cos(k * angle) for k in range(1, order + 1)], dim=-1)
