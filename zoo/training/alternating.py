"""Fits a network and physical effects together, without the network eating the effects."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Generator, Tensor

from zoo.errors import InputError, WorkError
from zoo.fitting.design import Design
from zoo.fitting.noise import blocks_of, noise_of
from zoo.fitting.parameters import parameters_of
from zoo.fitting.variable_projection import Fit, fit
from zoo.given import check_number, check_switch
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.trained import Trained
from zoo.scoring.noise import Whitener
from zoo.training.damped_steps import descend
from zoo.training.fine_blocks import rows_of, samples_of, seen
from zoo.training.first_shapes import first_theta
from zoo.training.weights import reset

SETTLED = 1e-4
"""Share of χ² by which a round must lower it to be followed by another."""
POSSIBLE = "networks with weights, such as bp, polynomial or takagi_sugeno"


Solution = tuple[GrayBox, Fit]
"""The effects beside the linearised network, and their fit."""


class Alternating:
    """Optimizer of hybrids: in turns the effects, with all that the network could become projected out, and the network on what they leave.

    A turn of the effects is one fit of network + effects by variable projection (Golub & Pereyra 1973), the network linearised in its weights
    (Kaufman 1975): the size of an effect is decided by what the network cannot represent, so that the network has no start over it. A turn of the
    network is Levenberg–Marquardt from where its weights are. Both lower the same χ², that of the block means under the runs' noise.
    """

    follows_device = True

    def __init__(self, rounds: int = 20, steps: int = 50, first_steps: int = 200, draw: bool = True) -> None:
        """Remember.

        Args:
            rounds: most turns of each.
            steps: most steps in a turn of the network.
            first_steps: the same before the first turn of the effects.
            draw: whether the network's weights are drawn at random and the effects' shapes searched for; else both go on from what they are.
        """
        for name, value in (("rounds", rounds), ("steps", steps), ("first_steps", first_steps)):
            check_number(f"optimizer.{name}", value, 1, whole=True)
        check_switch("optimizer.draw", draw)
        self.rounds, self.steps, self.first_steps, self.draw = rounds, steps, first_steps, draw
        self.solution: Solution | None = None

    def fit(self, model: Model, runs: Sequence[Run], generator: Generator) -> int:
        """Fit in place.

        Args:
            model: a `Hybrid` whose network is a static map of features.
            runs: fitted.
            generator: source of chance of the network's weights.

        Returns:
            Turns of the effects.

        Raises:
            InputError: the model is no such hybrid.
            WorkError: the network diverged.
        """
        if not isinstance(model, Hybrid):
            raise InputError(f"optimizer=alternating fits a network with effects (model=hybrid), not {type(model).__name__}; leave optimizer=auto")
        task = _Task(model, list(runs))
        if self.draw:
            task.whole.standardise(task.rows, task.error)
            reset(task.network, generator)
            task.train_network(task.error, self.first_steps)
        return self._alternate(task)

    def _alternate(self, task: _Task) -> int:
        """Turns until a round no longer matters; the round that left least stays, where a later one is worse or breaks down."""
        start, turns, best = None if self.draw else task.model.physics.theta(), 0, _Best()
        while turns < self.rounds:
            try:
                solution, theirs = task.fit_effects(start)
                left = task.train_network(task.error - theirs, self.steps)
            except (WorkError, torch.linalg.LinAlgError) as error:  # type: ignore[attr-defined]
                if best.solution is None:
                    raise WorkError(f"training diverged: {type(task.network).__name__} beside effects ({error})") from error
                break
            start, turns = solution[1].theta, turns + 1
            goes_on = turns < 2 or left < (1.0 - SETTLED) * best.left
            if left < best.left:
                best = _Best(left, solution, copy.deepcopy(task.model.state_dict()))
            if not goes_on:
                break
        task.model.load_state_dict(best.weights)
        self.solution = best.solution
        return turns

    def physical(self, unit: str) -> dict[str, Any]:
        """Value and standard error of the coil's and the effects' parameters, with what the network as it stands could take over allowed for.

        From other weights the network may have taken another share of an effect that it can draw by itself: several seeds show by how much.

        Args:
            unit: suffix of the output's unit.
        """
        if self.solution is None:
            return {}
        return {owner: values for owner, values in parameters_of(*self.solution, unit).items() if owner != Trained.name}


@dataclass(frozen=True)
class _Best:
    """The round that has left least.

    Attributes:
        left: χ² at its end.
        solution: its turn of the effects.
        weights: the hybrid's state at its end.
    """

    left: float = math.inf
    solution: Solution | None = None
    weights: dict[str, Tensor] = field(default_factory=dict)


class _Task:
    """A hybrid and the runs it is fitted to."""

    def __init__(self, model: Hybrid, runs: list[Run]) -> None:
        if not isinstance(model.network, FeatureModel):
            raise InputError(f"model.network: {type(model.network).__name__} is no map of features; possible: {POSSIBLE}")
        if not any(parameter.numel() for parameter in model.network.parameters()):
            raise InputError(f"model.network: {type(model.network).__name__} has no weights to train beside effects; possible: {POSSIBLE}")
        self.model, self.network, self.runs = model, model.network, runs
        self.whitener = Whitener(noise_of(runs), blocks_of(runs))
        samples = samples_of(runs)
        self.whole, self.rows = seen(self.network, samples), torch.cat([rows_of(self.network, samples)(run) for run in runs])
        self.error = torch.cat([run.block_mean(run.error) for run in runs])

    def fit_effects(self, start: Tensor | None) -> tuple[Solution, Tensor]:
        """One turn of the effects, from θ (P,) or from where a search finds it; also their share (N,) of the error [unit]."""
        physics = self.model.physics
        effects = dict(physics.named_effects())
        beside = Trained(Trained.name, self.network, self.runs)
        both = GrayBox({Trained.name: beside, **effects}, physics.inputs, physics.in_motion)
        design = Design(both, self.runs, self.whitener)
        found = fit(design.plain_columns, design.target, first_theta(design) if start is None else start, weigh=self.whitener, prior=design.prior)
        own = len(beside.amplitudes)
        physics.assign(found.theta, found.amplitudes[own:])
        return (both, found), found.plain[:, own : found.columns.shape[1]] @ found.amplitudes[own:]

    def train_network(self, target: Tensor, steps: int) -> float:
        """One turn of the network on block means (N,) [unit]; χ² that it leaves."""
        left = descend(self.whole, self.rows, target, self.whitener, steps)
        if not math.isfinite(left):
            raise WorkError(f"training diverged: the network {type(self.network).__name__} leaves χ² = {left}")
        return left
