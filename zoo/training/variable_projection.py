"""Fits a grey box by itself: amplitudes projected out, the rest by Levenberg–Marquardt from a coarse grid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from torch import Generator

from zoo.errors import InputError
from zoo.fitting.design import Design, coarse_starts
from zoo.fitting.noise import blocks_of, noise_of
from zoo.fitting.parameters import parameters_of
from zoo.fitting.several_starts import fit_from
from zoo.fitting.variable_projection import Fit
from zoo.given import check_number
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.graybox import GrayBox
from zoo.scoring.noise import Whitener
from zoo.training.first_shapes import first_theta


class VariableProjection:
    """Optimizer of models that are sums of effects."""

    follows_device = True

    def __init__(self, iterations: int = 30) -> None:
        """Remember.

        Args:
            iterations: most Gauss–Newton steps.
        """
        check_number("optimizer.iterations", iterations, 1, whole=True)
        self.iterations = iterations
        self.solution: tuple[GrayBox, Fit] | None = None

    def fit(self, model: Model, runs: Sequence[Run], generator: Generator) -> int:
        """Fit in place; draws nothing.

        Returns:
            Steps taken.

        Raises:
            InputError: the model is no grey box, or has no effect.
        """
        del generator
        if not isinstance(model, GrayBox):
            raise InputError(f"optimizer=variable_projection fits sums of effects (model=graybox), not {type(model).__name__}; leave optimizer=auto")
        if not dict(model.named_effects()):
            raise InputError("effects=[] leaves nothing to fit; start from effects=[static_bias,shupe,mohr]")
        whitener = Whitener(noise_of(list(runs)), blocks_of(list(runs)))
        design = Design(model, list(runs), whitener)
        starts = torch.cat([coarse_starts(design), first_theta(design).unsqueeze(0)])
        found = fit_from(design, starts, iterations=self.iterations)
        with torch.no_grad():
            model.assign(found.theta, found.amplitudes)
        self.solution = model, found
        return found.iterations

    def physical(self, unit: str) -> dict[str, Any]:
        """Value and standard error of every parameter.

        Args:
            unit: suffix of the output's unit.
        """
        return {} if self.solution is None else parameters_of(*self.solution, unit)
