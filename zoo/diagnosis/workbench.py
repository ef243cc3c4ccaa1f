"""Fits grey boxes with different sets of effects to the same runs under the same noise model."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor

from zoo.effects.base import Effect
from zoo.effects.bounds import to_unit
from zoo.fitting.projection import orthonormal, project
from zoo.fitting.variable_projection import Fit, fit
from zoo.measurements.run import Run
from zoo.models.design import Design
from zoo.models.graybox import GrayBox
from zoo.scoring.noise import NoiseModel, Whitener

COIL_TRIALS = 4


@dataclass(frozen=True, eq=False)
class Solved:
    """A fitted grey box.

    Attributes:
        names: its effects.
        model: holds the fitted values.
        design: its columns on the fitted runs.
        fit: the solution, in whitened block means.
    """

    names: tuple[str, ...]
    model: GrayBox
    design: Design
    fit: Fit

    @cached_property
    def basis(self) -> Tensor:
        """(N, R) orthonormal basis of everything the model can still absorb to first order: its columns and the tangents of θ."""
        return orthonormal(torch.cat([self.fit.columns, self.fit.tangent], dim=1))

    @cached_property
    def residual(self) -> Tensor:
        """(N,) block means of error − model [unit], runs one after the other."""
        plain = self.design.plain_columns(self.fit.theta.unsqueeze(0))[0]
        return self.design.error - plain @ self.fit.amplitudes

    @property
    def rms(self) -> float:
        """RMS of the residual over the fitted runs [unit]."""
        return float(self.residual.square().mean().sqrt())

    @property
    def freedom(self) -> int:
        """How many parameters were fitted."""
        return self.fit.columns.shape[1] + self.fit.theta.numel()


class Workbench:
    """The runs, their noise, and the effects that may be combined."""

    def __init__(self, runs: list[Run], effects: dict[str, Effect], noise: NoiseModel) -> None:
        """Keep what all fits share.

        Args:
            runs: R runs with the same columns.
            effects: every effect that may be named, freshly built.
            noise: of the block means.
        """
        self.runs, self.effects, self.noise = runs, effects, noise
        self.inputs = list(runs[0].columns)
        self.whitener = Whitener(noise, [run.block_mean(run.time) for run in runs], [run.block_share() for run in runs])
        self.span_s = max(float(run.time[-1] - run.time[0]) for run in runs)
        self.blocks = sum(run.blocks for run in runs)
        self._solved: dict[frozenset[str], Solved] = {}

    def available(self) -> list[str]:
        """Names of the effects whose needed columns the runs have."""
        return [name for name, effect in self.effects.items() if all(column in self.inputs for column in effect.needs)]

    def shapes(self, name: str) -> Tensor:
        """(G, S) physical shapes of an effect to start searches from."""
        return self.effects[name].shapes_to_try(self.span_s, len(self.runs))

    def design(self, names: tuple[str, ...]) -> Design:
        """The columns of a set of effects on the runs."""
        effects = {name: copy.deepcopy(self.effects[name]) for name in names}
        return Design(GrayBox(effects, self.inputs), self.runs, self.whitener)

    def solve(self, names: tuple[str, ...], starts: list[Tensor] | None = None) -> Solved:
        """Fit a set of effects, from the best of the given starts; solutions are remembered.

        Args:
            names: effects, in the order of the model.
            starts: θ (P,) in 0…1 to start from; by default a coarse grid over the coil's parameters.
        """
        key = frozenset(names)
        if key in self._solved and starts is None:
            return self._solved[key]
        design = self.design(names)
        trials = torch.stack(starts) if starts else self._coarse(design)
        costs = project(design.columns(trials), design.target).cost
        order = costs.argsort()[:1]
        fits = [fit(design.columns, design.target, trials[i]) for i in order]
        known = [self._solved[key].fit] if key in self._solved and self._solved[key].names == names else []
        best = min([*fits, *known], key=lambda found: found.cost)
        design.model.assign(best.theta, best.amplitudes)
        self._solved[key] = Solved(names, design.model, design, best)
        return self._solved[key]

    def extend(self, base: Solved, name: str, shape: Tensor) -> Solved:
        """Refit with one more effect, its shape (S,) started where screening found it.

        Starts from the base's coil and from a coarse grid over the coil's parameters, for a base that lacks an effect bends the coil to make up for it.
        """
        effect = self.effects[name]
        own = to_unit(shape, effect.shape)
        near = torch.cat([base.fit.theta, own])
        coarse = self._coarse(base.design, base.fit.theta)
        starts = [near, *torch.cat([coarse, own.expand(len(coarse), -1)], dim=1)]
        return self.solve((*base.names, name), starts)

    def known(self, names: tuple[str, ...]) -> Solved | None:
        """The solution of these effects, if it was found before."""
        return self._solved.get(frozenset(names))

    def add(self, base: Solved, name: str) -> Solved:
        """Refit with one more effect, its shape searched for."""
        from zoo.diagnosis.screening import screen  # screening works on a bench

        return self.extend(base, name, screen(self, base, [name])[0].shape)

    def peek(self, base: Solved, name: str, shape: Tensor) -> Solved:
        """One more effect without a refit of anything nonlinear."""
        design = self.design((*base.names, name))
        theta = torch.cat([base.fit.theta, to_unit(shape, self.effects[name].shape)])
        found = fit(design.columns, design.target, theta, iterations=0)
        design.model.assign(found.theta, found.amplitudes)
        return Solved((*base.names, name), design.model, design, found)

    def without(self, full: Solved, name: str) -> Solved:
        """Refit with one effect less, started from the full model's parameters."""
        owners = [owner for owner, _ in full.model.parameters_of_theta()]
        keep = torch.tensor([owner != name for owner in owners], dtype=torch.bool)
        return self.solve(tuple(other for other in full.names if other != name), [full.fit.theta[keep]])

    def _coarse(self, design: Design, around: Tensor | None = None) -> Tensor:
        """(G, P) a grid over the coil's parameters, everything else where it is."""
        theta = design.model.theta() if around is None else around
        declared = design.model.parameters_of_theta()
        size = len(design.model.coil_parameters)
        axis = (torch.arange(COIL_TRIALS, dtype=torch.float64) + 1.0) / (COIL_TRIALS + 1)
        axes = [0.35 + 0.6 * axis if declared[i][1].scale == "log" else axis for i in range(min(size, 3))]
        grid = torch.cartesian_prod(*axes).reshape(-1, len(axes))
        trials = theta.expand(len(grid), -1).clone()
        trials[:, : len(axes)] = grid
        return trials

    def evidence(self, less: Solved, more: Solved) -> float:
        """Half the drop of the penalised deviance when effects are added: ½Δχ²/s − ½·Δp·ln N, a log Bayes factor (Schwarz 1978).

        s ≥ 1 is the larger model's χ² per degree of freedom, so that a model which still misfits cannot boast of its gains.
        """
        scale = max(1.0, more.fit.cost / max(self.blocks - more.freedom, 1))
        return 0.5 * (less.fit.cost - more.fit.cost) / scale - 0.5 * (more.freedom - less.freedom) * math.log(self.blocks)
