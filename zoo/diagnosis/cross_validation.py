"""What a model costs on data that its amplitudes were not fitted to."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.workbench import Solved, Workbench
from zoo.fitting.projection import project

SEGMENTS, OF_A_RUN = 8, 3
"""Consecutive pieces that are left out one at a time, and how many of one run at least, so that every run keeps most of its blocks. Fewer and longer
ones ask for more: neighbours of a short piece give its misfit away."""
ENOUGH = 5
"""Blocks for each amplitude that other runs must have to predict one."""


def segment_cost(bench: Workbench, solved: Solved) -> float:
    """Sum of squared whitened errors on pieces of the runs, each predicted with amplitudes from all the others."""
    return float(_left_out(solved.fit.columns, solved.design.target, _folds(bench)).square().sum())


def rms_by_run(bench: Workbench, solved: Solved) -> float:
    """RMS [unit] over runs, each predicted with amplitudes from the others; over eight pieces or more where the others are too few or too short.

    The nonlinear parameters stay as fitted to all runs.
    """
    sizes = [run.blocks for run in bench.runs]
    enough = bench.blocks - max(sizes) >= ENOUGH * solved.plain_columns.shape[1]
    parts = list(torch.arange(bench.blocks).split(sizes)) if enough else _folds(bench)
    return float(_left_out(solved.plain_columns, solved.design.error, parts).square().mean().sqrt())


def _folds(bench: Workbench) -> list[Tensor]:
    count = max(OF_A_RUN, -(-SEGMENTS // len(bench.runs)))
    runs = torch.arange(bench.blocks).split([run.blocks for run in bench.runs])
    return [piece for run in runs for piece in run.tensor_split(count) if len(piece)]


def _left_out(columns: Tensor, target: Tensor, parts: list[Tensor]) -> Tensor:
    errors = []
    for part in parts:
        keep = torch.ones(len(target), dtype=torch.bool, device=target.device)
        keep[part] = False
        amplitudes = project(columns[keep], target[keep]).amplitudes
        errors.append(target[part] - columns[part] @ amplitudes)
    return torch.cat(errors)
