"""The plain ranking: each effect of the catalogue at the thermometer's temperature, its shape from a grid, the best by BIC."""

from __future__ import annotations

import math

import torch
from hidden_effects.recipe import BASE
from torch import Tensor

from zoo.diagnosis.preparation import reference_varies
from zoo.effects.base import Effect, History
from zoo.fitting.projection import complement, orthonormal, project
from zoo.measurements.run import Run
from zoo.physics.lag import lagged_rate

SMOOTHED_S = 60.0
AT_ONCE = 40
"""Shapes computed together."""


def ranking(runs: list[Run], catalogue: dict[str, Effect]) -> list[str]:
    """The effect with the least BIC (Schwarz 1978, Ann. Stat. 6:461), or none where none of them is below the base's."""
    error = torch.cat([run.block_mean(run.error) for run in runs])
    base = orthonormal(torch.cat([_means(catalogue[name], runs, _shapes(catalogue[name], runs)[:1])[0] for name in BASE], dim=-1))
    residual = complement(error.unsqueeze(-1), base).squeeze(-1)
    size = len(error)
    found = {"": size * math.log(float(residual.square().sum()) / size)}
    for name, effect in catalogue.items():
        if name not in BASE and _usable(effect, runs):
            cost, used = _best(effect, runs, base, residual)
            found[name] = size * math.log(cost / size) + (used + len(effect.shape)) * math.log(size)
    best = min(found, key=lambda name: found[name])
    return [best] if best else []


def _usable(effect: Effect, runs: list[Run]) -> bool:
    return set(effect.needs) <= set(runs[0].columns) and (not effect.needs_varied_reference or reference_varies(runs))


def _shapes(effect: Effect, runs: list[Run]) -> Tensor:
    return effect.shapes_to_try(max(float(run.time[-1] - run.time[0]) for run in runs), len(runs))


def _best(effect: Effect, runs: list[Run], base: Tensor, residual: Tensor) -> tuple[float, int]:
    """Sum of squares that the best shape leaves, and how many of its columns are any."""
    found = []
    for shapes in _shapes(effect, runs).split(AT_ONCE):
        columns = complement(_means(effect, runs, shapes), base)
        cost, best = project(columns, residual).cost.min(dim=0)
        found.append((float(cost), int((columns[best].norm(dim=0) > 1e-9).sum())))
    return min(found)


def _means(effect: Effect, runs: list[Run], shapes: Tensor) -> Tensor:
    """(G, N, K) block means of an effect's columns for shapes (G, S)."""
    parts = [run.block_mean_columns(effect.columns(_history(run, number), shapes)) for number, run in enumerate(runs, 1)]
    return torch.cat([part.expand(len(shapes), *part.shape[-2:]) for part in parts], dim=-2).detach()


def _history(run: Run, number: int) -> History:
    """What the thermometers tell, taken for the temperature of every place."""
    time, main = run.time - run.time[0], run.temperature
    rate = 60.0 * lagged_rate(time, main, torch.tensor(SMOOTHED_S, dtype=main.dtype))
    inputs = {name: run.column(name) for name in run.columns[1:-1]}
    return History(time, main, rate, run.column(run.thermometers[-1]) - main, main, run.table[:, -1], inputs, number)
