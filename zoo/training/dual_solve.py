"""Fits a least-squares support vector machine: γ and widths by leaving out, then one linear system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.given import check_number
from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.ls_svm import VALUES_AT_ONCE, LsSvm, gaussians
from zoo.models.prediction import block_features
from zoo.progress import progress
from zoo.training.kernel_search import MOST, WIDTHS, Kernel, search
from zoo.training.nystrom import landmarks, nystrom_solve

FOLDS = ("auto", "sample", "block", "run")
BLOCK = 10
"""Neighbours left out together under ``folds="block"``."""
COVERED = 0.3
"""Share of each run's blocks that must lie in the range of the others for whole runs to be left out under ``folds="auto"``; a run where the others
have nothing asks for a function that extrapolates."""


class DualSolve:
    """Optimizer of least-squares support vector machines.

    γ and widths are those with which left-out samples are predicted best, on at most `tuned_on` samples; γ is a ratio of variances, so that it does
    not depend on how many samples there are. What is left out together matters: the neighbours of a block mean tell most of it, so that leaving
    out one at a time asks for too rough a function; who leaves out a whole run that alone was so cold asks for one that extrapolates.

    Attributes:
        kernel: what was chosen, after a fit.
    """

    follows_device = True

    def __init__(self, folds: str = "auto", tuned_on: int = 1000, exact_to: int = 20_000, landmarks: int = 1000) -> None:
        """Remember.

        Args:
            folds: what is left out together: ``"sample"``, ``"block"`` (ten neighbours), ``"run"`` (for runs that all cover the same range), or
                ``"auto"``: runs where they do, else blocks.
            tuned_on: samples at most that γ and widths are chosen on, evenly thinned.
            exact_to: samples up to which each is a support point.
            landmarks: support points where there are more.
        """
        if folds not in FOLDS:
            raise InputError(f"optimizer.folds={folds}: possible: {', '.join(FOLDS)}")
        for name, value, least in (("tuned_on", tuned_on, 2 * BLOCK), ("exact_to", exact_to, 1), ("landmarks", landmarks, 1)):
            check_number(f"optimizer.{name}", value, least, whole=True)
        self.folds, self.tuned_on, self.exact_to, self.landmarks = folds, tuned_on, exact_to, landmarks
        self.kernel: Kernel | None = None
        self._names: list[str] = []

    def fit(self, model: Model, runs: Sequence[Run], generator: Generator) -> int:
        """Fit in place.

        Args:
            model: an `LsSvm`.
            runs: fitted.
            generator: source of chance of the landmarks; nothing is drawn where every sample is a support point.

        Returns:
            Kernels tried.

        Raises:
            InputError: the model is none, or there is too little to leave out.
        """
        if not isinstance(model, LsSvm):
            raise InputError(f"optimizer=dual_solve fits model=ls_svm, not {type(model).__name__}; leave optimizer=auto")
        features, error = RunsDataModule(runs, [], lambda run: block_features(model, run)).fitted
        sizes = [run.blocks for run in runs]
        folds = _folds(("run" if _alike(features, sizes) else "block") if self.folds == "auto" else self.folds, sizes)
        model.to(features.device).standardise(features, error)
        points, target = model.scaler(features), (error - model.scaler.error_centre) / model.scaler.error_scale
        self.kernel, tried = self._tune(points, target, folds)
        self._names = model.extract.names
        width, gamma = 2.0**self.kernel.width, 2.0**self.kernel.gamma
        if len(points) <= self.exact_to:
            model.assign(points, *exact_solve(points / width, target, gamma), width)
        else:
            some = points[:: _every(points, self.exact_to)]
            support = some[landmarks(some, self.landmarks, generator)]
            model.assign(support, *nystrom_solve(points / width, target, support / width, gamma), width)
        return tried

    def _tune(self, points: Tensor, target: Tensor, folds: Tensor | None) -> tuple[Kernel, int]:
        every, tried = _every(points, self.tuned_on), 0
        with progress("kernels", len(WIDTHS) + MOST + 1) as advance:

            def count() -> None:
                nonlocal tried
                tried += 1
                advance()

            thinned = None if folds is None else folds[::every].to(points.device)
            if thinned is not None and len(thinned.unique()) < 2:
                few = f"of {len(points)} samples the {len(thinned)} that are tuned on are of one run"
                raise InputError(f"optimizer.folds={self.folds}: {few}; raise optimizer.tuned_on")
            return search(points[::every], target[::every], thinned, count), tried

    def physical(self, unit: str) -> dict[str, Any]:
        """What was chosen: γ and each feature's width [standard deviations].

        Args:
            unit: suffix of the output's unit.
        """
        del unit
        if self.kernel is None:
            return {}
        widths = {f"width_{name}": value for name, value in zip(self._names, (2.0**self.kernel.width).tolist(), strict=True)}
        return {"kernel": {name: {"value": value, "unit": "1"} for name, value in {"gamma": 2.0**self.kernel.gamma, **widths}.items()}}


def exact_solve(points: Tensor, target: Tensor, gamma: float) -> tuple[Tensor, Tensor]:
    """The dual system with all samples as support points, by Cholesky.

    Args:
        points: (M, F) in widths.
        target: (M,).
        gamma: γ.

    Returns:
        (M,) weights and () bias.
    """
    kernel = points.new_empty(len(points), len(points))
    rows = max(VALUES_AT_ONCE // len(points), 1)
    for into, part in zip(kernel.split(rows), points.split(rows), strict=True):
        into.copy_(gaussians(part, points))
    kernel.diagonal().add_(1.0 / gamma)
    both = torch.stack([torch.ones_like(target), target], dim=-1)
    ones, free = torch.cholesky_solve(both, torch.linalg.cholesky(kernel)).unbind(-1)
    bias = free.sum() / ones.sum()
    return free - bias * ones, bias


def _every(points: Tensor, most: int) -> int:
    """Of how many samples one is taken so that at most so many are left."""
    return -(-len(points) // most)


def _alike(points: Tensor, sizes: list[int]) -> bool:
    """Whether there are several runs of these sizes, and enough of the points (M, F) of each lie in the range of the others."""
    parts = [part for part in points.split(sizes) if len(part)]
    for place, part in enumerate(parts):
        others = parts[:place] + parts[place + 1 :]
        if not others:
            return False
        rest = torch.cat(others)
        inside = ((part >= rest.amin(0)) & (part <= rest.amax(0))).all(-1)
        if float(inside.double().mean()) < COVERED:
            return False
    return len(parts) > 1


def _folds(kind: str, sizes: list[int]) -> Tensor | None:
    """(M,) number of each sample's fold for runs of these sizes; None where each sample is one, as where there is a single block."""
    if kind == "sample":
        return None
    if kind == "run" and sum(size > 0 for size in sizes) < 2:
        raise InputError("optimizer.folds=run: at least 2 runs are needed; possible: sample, block")
    if kind == "block" and sum(-(-size // BLOCK) for size in sizes) < 2:
        return None  # all would be left out at once
    starts = [sum(sizes[:run]) for run in range(len(sizes))]
    length = max(sizes) if kind == "run" else BLOCK
    return torch.cat([start + torch.arange(size) // length for start, size in zip(starts, sizes, strict=True)])
