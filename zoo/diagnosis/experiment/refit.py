"""The last word on a pair of explanations: one refitted in full to what the other says of the old runs and the new one."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from zoo.diagnosis.experiment.evidence import Answer, Old, Told, energy, nearest_place
from zoo.diagnosis.experiment.prediction import Predicted
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.design import Design
from zoo.fitting.variable_projection import fit
from zoo.models.graybox import UNSEEN

ITERATIONS = 6


def told_by_refit(bench: Workbench, old: Old, new: Predicted, answers: Sequence[Sequence[Answer]], truth: int, other: int) -> Told:
    """As `told_apart` for one ordered pair, with the other's nonlinear parameters fitted as far as they go."""
    place = nearest_place(old, answers, truth, other)
    start = old.rivals[other][place]
    true = old.rivals[truth][0]
    target = torch.cat([true.fit.columns @ true.fit.amplitudes, answers[truth][0].signal])
    left = _cost(bench, new, start, target) - float(old.reduced[other][0].outside[truth]) ** 2
    chi2 = max(left, 0.0)
    return Told(0.5 * chi2, chi2 / max(energy(old, truth, answers[truth][0]), 1e-300))


def _cost(bench: Workbench, new: Predicted, start: Solved, target: Tensor) -> float:
    """χ² that an explanation leaves of a signal on all runs, refitted from where it stands."""
    design = Design(start.model, [new.run], new.whitener, [UNSEEN])

    def columns(theta: Tensor) -> Tensor:
        return torch.cat([start.design.plain_columns(theta), design.plain_columns(theta)], dim=-2)

    def weigh(columns: Tensor) -> Tensor:
        before, after = columns.split([bench.blocks, new.run.blocks], dim=-2)
        return torch.cat([bench.whitener(before), new.whitener(after)], dim=-2)

    return fit(columns, target, start.fit.theta, ITERATIONS, weigh=weigh).cost
