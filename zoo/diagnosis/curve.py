"""A free function of one quantity drawn as a curve, with how well the runs determine it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from zoo.diagnosis.free_functions import FreeFunction
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.projection import complement, orthonormal, project

GRID, BINS, FEW = 41, 24, 3
"""Points of a curve; bins of what is drawn beside it; fewer blocks than so many are no bin."""
DETERMINED = 0.2
"""Sine of the angle to what the model has already below which a direction of the function is left to the model."""
TEMPERATURES = (0.1, 0.5, 0.9)
"""Quantiles of the temperature at which a function of two is drawn."""
SIGMAS = 2.0


@dataclass(frozen=True, eq=False)
class FreeFit:
    """A free function fitted beside a model, in the directions in which the runs tell it from the model.

    Attributes:
        free: the function.
        weights: (K,) of its columns [unit].
        root: (K, R) whose product with its transpose is their covariance [unit²].
        left: (N,) residual of both together [unit].
        before: (N,) residual of the model [unit].
    """

    free: FreeFunction
    weights: Tensor
    root: Tensor
    left: Tensor
    before: Tensor

    def explained(self, blocks: list[int]) -> list[float]:
        """Share of the residual's variance that it takes away, run by run."""
        pairs = zip(self.left.split(blocks), self.before.split(blocks), strict=True)
        return [1.0 - float(after.square().sum() / before.square().sum()) for after, before in pairs]

    def curves(self) -> list[dict[str, Any]]:
        """The function as curves: one, or of two quantities one for each of three temperatures; ready for JSON.

        A quantity's zero is the curve's zero where it means something, elsewhere the curve's mean over the runs: a constant is the model's.
        Points are means over bins of what the model leaves, less what the function explains elsewhere, with their standard errors.
        """
        free = self.free
        if free.beside is None:
            return [self._curve(torch.ones_like(free.axis.means, dtype=torch.bool), None)]
        means = free.beside.means
        places = [float(means.quantile(share)) for share in TEMPERATURES]
        nearest = torch.stack([(means - place).abs() for place in places]).argmin(dim=0)
        return [self._curve(nearest == i, place) for i, place in enumerate(places)]

    def _curve(self, here: Tensor, temperature: float | None) -> dict[str, Any]:
        values = self.free.axis.means
        grid = torch.linspace(float(values.min()), float(values.max()), GRID, dtype=values.dtype, device=values.device)
        columns = self._at(grid, temperature) - self._origin(temperature)
        y, spread = columns @ self.weights, SIGMAS * (columns @ self.root).norm(dim=1)
        found = {"x": grid, "y": y, "low": y - spread, "high": y + spread}
        own = (self.free.columns[here] - self._origin(temperature)) @ self.weights + self.left[here]
        label = "" if temperature is None else f"at {temperature:.0f} °C".replace("-", "−")
        return {"label": label, **{key: _plain(value) for key, value in found.items()}, "points": _binned(values[here], own, grid)}

    def _at(self, values: Tensor, temperature: float | None) -> Tensor:
        return self.free.at(values, None if temperature is None else torch.full_like(values, temperature))

    def _origin(self, temperature: float | None) -> Tensor:
        """(K,) the columns where the curve is put to zero."""
        values = self.free.axis.means
        if self.free.of.signed and float(values.min()) < 0 < float(values.max()):
            return self._at(torch.zeros_like(values[:1]), temperature)[0]
        return self._at(values, temperature).mean(dim=0)


def fitted(bench: Workbench, solved: Solved, free: FreeFunction) -> FreeFit:
    """Fit a free function beside a model, under the noise that is likeliest with both.

    Where the model could take over a direction of the function (a constant; the rate itself, which is Mohr's effect) that direction is left to it,
    or the curve would wander off as far as the model can follow.

    Args:
        bench: the runs.
        solved: the model.
        free: the function.
    """
    plain, target, own = solved.fit.plain, solved.design.error, free.columns
    place = bench.mixtures.most_likely(torch.cat([plain, own], dim=1), target, solved.likely.place).place
    whitener = bench.mixtures.whitener(place)[1]
    white = whitener(torch.cat([plain, own, target.unsqueeze(1)], dim=1))
    known, mine, aim = white[:, : plain.shape[1]], white[:, plain.shape[1] : -1], white[:, -1:]
    frame, triangle = torch.linalg.qr(mine)
    left, sines, right = torch.linalg.svd(complement(frame, orthonormal(known)), full_matrices=False)
    clear = sines > DETERMINED
    back = torch.linalg.pinv(triangle) @ right[clear].mT / sines[clear]
    weights = back @ (left[:, clear].mT @ aim).squeeze(1)
    amplitudes = project(known, (aim - mine @ weights.unsqueeze(1)).squeeze(1)).amplitudes
    return FreeFit(free, weights, back, target - own @ weights - plain @ amplitudes, solved.residual)


def _binned(values: Tensor, residual: Tensor, grid: Tensor) -> dict[str, list[float]]:
    """Means over bins of a quantity, with their standard errors."""
    edges = torch.linspace(float(grid[0]), float(grid[-1]), BINS + 1, dtype=grid.dtype, device=grid.device)
    number = torch.bucketize(values, edges[1:-1])
    parts = [(values[number == i], residual[number == i]) for i in range(BINS) if int((number == i).sum()) >= FEW]
    found = {
        "x": [float(x.mean()) for x, _ in parts],
        "y": [float(y.mean()) for _, y in parts],
        "error": [float(y.std() / len(y) ** 0.5) for _, y in parts],
    }
    return {key: _plain(torch.tensor(value, dtype=torch.float64)) for key, value in found.items()}


def _plain(values: Tensor) -> list[float]:
    """Six digits are enough to draw."""
    return [float(f"{value:.6g}") for value in values.tolist()]
