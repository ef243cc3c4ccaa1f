"""The grey box's columns on the block means of several runs, whitened: what variable projection works on."""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import cache, cached_property, partial

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, spread
from zoo.effects.bounds import to_physical, to_unit
from zoo.errors import InputError, WorkError, in_brief
from zoo.fitting.prior import Prior
from zoo.fitting.projection import project
from zoo.fitting.remembered import Remembered
from zoo.fitting.stack import Stack, stacked
from zoo.measurements.run import Run
from zoo.models.graybox import GrayBox
from zoo.models.places import first_rates
from zoo.scoring.noise import Whitener

CHUNK_ELEMENTS = 2_000_000
Places = list[dict[str, History]]
"""What every place of each stack has been through."""
IN_TIME, OF_SHAPES = 0, 1
"""Axes of columns whose time goes first."""
COIL_TRIALS = 4
LAGS_S, ZEROS = (20.0, 60.0, 150.0, 400.0, 1000.0, 2500.0), (0.3, 1.0, 1.8, 3.0)
"""Of one thermometer: lags, and λ of the coil's zero over its lag; without a zero the lead does not matter, and a fit would not find back."""
LOW, HIGH = 0.35, 0.95
"""Part of a logarithmic range in which lags are tried: half a minute to two hours."""
CLOSE_LAGS, CLOSE_WEIGHTS, CLOSE_LEADS = 14, (0.1, 0.4, 0.7, 0.95), 25
SHORT_LAG_S = 60.0
"""Tried beside the lag that a model has, which may have been bent to smooth away what is missing."""
LAST_LEAD, FIRST_LEAD = -1500.0, 900.0
"""Leads that are looked at closely [s]: at 1 K/min, from 25 K behind the thermometer to 15 K ahead of it."""


class Design:
    """A grey box and the runs it is fitted to."""

    def __init__(self, model: GrayBox, runs: list[Run], whitener: Whitener, numbers: list[int] | None = None) -> None:
        """Keep the runs' tensors ready.

        Args:
            model: the grey box.
            runs: R runs with the model's inputs.
            whitener: for the block means of these runs, in this order.
            numbers: number of each run, from 1 (for effects that happen in one run).
        """
        self.model, self.runs, self.whitener = model.to(runs[0].table.device), runs, whitener
        self.numbers = numbers or list(range(1, len(runs) + 1))
        self.stacks, self._remembered = stacked(runs, self.numbers, self.model), Remembered()
        self.error = torch.cat([run.block_mean(run.error) for run in runs])
        self.target = whitener(self.error.unsqueeze(-1)).squeeze(-1)

    def of(self, model: GrayBox) -> Design:
        """The same runs and noise for another model of the same inputs, with all that was computed of them."""
        other = copy.copy(self)
        other.__dict__.pop("prior", None)
        other.model = model.to(self.error.device)
        return other

    def forgetful(self) -> Design:
        """The same with nothing remembered: of what is asked for once, the last digits are then the same whatever was asked for before."""
        other = copy.copy(self)
        other._remembered = Remembered()
        return other

    @cached_property
    def prior(self) -> Prior:
        """What is known of θ before."""
        return Prior.of([p for _, p in self.model.parameters_of_theta()])

    def cost(self, theta: Tensor) -> Tensor:
        """(G, P) in 0…1 -> (G,) χ² and what the prior adds to it."""
        return project(self.columns(theta), self.target).cost + self.prior.cost(theta)

    def columns(self, theta: Tensor) -> Tensor:
        """(B, P) in 0…1 -> whitened columns (B, N, K)."""
        return self.whitener(self.plain_columns(theta))

    def plain_columns(self, theta: Tensor) -> Tensor:
        """(B, P) in 0…1 -> block means of the columns (B, N, K) [unit per amplitude]."""
        samples = max(stack.samples for stack in self.stacks)
        width = sum(len(effect.amplitudes) for _, effect in self.model.named_effects())
        size = max(1, CHUNK_ELEMENTS // (samples * max(width, 1)))
        return torch.cat([self._some(part) for part in theta.split(size)])

    @torch.no_grad()
    def _some(self, theta: Tensor) -> Tensor:
        physical = to_physical(theta, [p for _, p in self.model.parameters_of_theta()])
        return torch.cat([self._of_stack(stack, physical) for stack in self.stacks], dim=-2)

    def _of_stack(self, stack: Stack, physical: Tensor) -> Tensor:
        """Block means of some runs; what several θ share (a Jacobian's steps mostly do) is computed once."""
        at = len(self.model.coil_parameters)
        coil, coil_index = torch.unique(physical[:, :at], dim=0, return_inverse=True)
        coils, places = [tuple(one) for one in coil.tolist()], cache(partial(stack.places, self.model, coil))
        parts = []
        for name, effect in self.model.named_effects():
            shape = physical[:, at : at + len(effect.shape)]
            at += len(effect.shape)
            where = coil_index if effect.place == "coil" else torch.zeros_like(coil_index)
            rows, index = torch.unique(torch.cat([where.unsqueeze(1).to(shape), shape], dim=1), dim=0, return_inverse=True)

            def made(new: list[int], effect: Effect = effect, rows: Tensor = rows) -> Tensor:
                own, place = rows[new], places()[effect.place]
                history = place.take(own[:, 0].long()) if effect.place == "coil" else place
                return stack.block_means(effect, history, partial(_columns, effect, own[:, 1:]), len(own))

            keys = [
                (stack, type(effect), effect.left_out, name, coils[int(at)] if effect.place == "coil" else (), *own) for at, *own in rows.tolist()
            ]
            parts.append(self._remembered.batch(keys, made)[index])
        return torch.cat(parts, dim=-1)

    def effect_columns_at_means(self, effect: Effect, places: Places, shapes: Tensor, whitener: Callable[[Tensor], Tensor] | None = None) -> Tensor:
        """The same with the means of each block taken for moments: faster, and near enough for a search; of an instant effect in single precision."""
        here = [means for stack, place in zip(self.stacks, places, strict=True) for means in stack.means(effect, place[effect.place])]
        shapes = shapes.to(here[0].temperature)
        return (whitener or self.whitener)(_joined([_distinct(effect, shapes, shapes, means) for means in here], IN_TIME))

    def histories(self, theta: Tensor) -> list[dict[str, History]]:
        """The places' histories of each run at one θ (P,)."""
        found = []
        for stack, places in zip(self.stacks, self.places(theta), strict=True):
            found += [dict(zip(places, run, strict=True)) for run in zip(*map(stack.apart, places.values()), strict=True)]
        return found

    def places(self, theta: Tensor) -> Places:
        """The same as `effect_columns` takes them."""
        return [stack.places(self.model, self._coil(theta)) for stack in self.stacks]

    def each_place(self, theta: Tensor) -> list[Places]:
        """The same at each of several θ (G, P), computed together."""
        together = [stack.places(self.model, self._coil(theta)) for stack in self.stacks]
        return [[stack.one_of(places, i) for stack, places in zip(self.stacks, together, strict=True)] for i in range(len(theta))]

    def _coil(self, theta: Tensor) -> Tensor:
        """(..., P) in 0…1 -> physical parameters of the coil."""
        return to_physical(theta, [p for _, p in self.model.parameters_of_theta()])[..., : len(self.model.coil_parameters)]

    def effect_columns(
        self, effect: Effect, places: Places, shapes: Tensor, whitener: Callable[[Tensor], Tensor] | None = None, distinct: bool = False
    ) -> Tensor:
        """Columns of one effect for many shapes at fixed histories.

        Args:
            effect: which.
            places: see there.
            shapes: (G, S) physical.
            whitener: by default the design's.
            distinct: whether columns that repeat another are left out, see `Effect.distinct_columns`.

        Returns:
            (G, N, K), where distinct fewer.
        """
        size = max(1, CHUNK_ELEMENTS // (max(stack.samples for stack in self.stacks) * len(effect.amplitudes)))
        shapes = shapes.to(self.error.device)
        found = []
        for part in shapes.split(size):
            columns = partial(_distinct, effect, part, shapes) if distinct else partial(_columns, effect, part)
            means = [stack.block_means(effect, place[effect.place], columns, len(part)) for stack, place in zip(self.stacks, places, strict=True)]
            found.append((whitener or self.whitener)(_joined(means, IN_TIME)))
        return _joined(found, OF_SHAPES)


def _columns(effect: Effect, shapes: Tensor, history: History) -> Tensor:
    return _made(effect, lambda: effect.columns(history, shapes), shapes, history)


def _distinct(effect: Effect, shapes: Tensor, tried: Tensor, history: History) -> Tensor:
    return _made(effect, lambda: effect.distinct_columns(history, shapes, tried), shapes, history)


def _made(effect: Effect, make: Callable[[], Tensor], shapes: Tensor, history: History) -> Tensor:
    """Columns, or whose they are that fail on these runs, if not on those that an effect from outside is tried on."""
    own = f"effect '{effect.name}': {type(effect).__name__}.columns"
    try:
        columns = spread(make(), shapes)
    except (InputError, WorkError):
        raise
    except Exception as error:
        raise WorkError(f"{own} fails on these runs: {in_brief(error)}") from error
    if columns.shape[-2] != len(history.time):
        raise WorkError(f"{own} returns {columns.shape[-2]} rows for {len(history.time)} samples")
    return columns


def _joined(parts: list[Tensor], along: int) -> Tensor:
    """Some (..., N, K) one after the other along an axis, time first in memory, as block means come and whiteners go through it."""
    return parts[0] if len(parts) == 1 else torch.cat([part.movedim(-2, 0) for part in parts], dim=along).movedim(0, -2)


def close_starts(design: Design, around: Tensor) -> Tensor:
    """(G, P) the coil's lag and weight, or its lead, as closely as an effect needs it that changes within a few kelvins; see `coarse_starts`."""
    declared = design.model.parameters_of_theta()
    if len(design.model.thermometers) == 1:
        lag, leads = declared[0][1], torch.linspace(LAST_LEAD, FIRST_LEAD, CLOSE_LEADS, dtype=torch.float64)
        short = to_unit(torch.tensor([[SHORT_LAG_S]], dtype=torch.float64), [lag]).squeeze(0)
        lags = torch.cat([around[:1].cpu(), short])
        places, values = [0, 1], torch.cartesian_prod(lags, to_unit(leads.unsqueeze(1), [declared[1][1]]).squeeze(1))
    else:
        lags = LOW + (HIGH - LOW) * torch.linspace(0.0, 1.0, CLOSE_LAGS, dtype=torch.float64)
        places, values = [0, 1], torch.cartesian_prod(lags, torch.tensor(CLOSE_WEIGHTS, dtype=torch.float64))
    trials = around.expand(len(values), -1).clone()
    trials[:, places] = values.to(around)
    return trials


def coarse_starts(design: Design, around: Tensor | None = None, thinned: bool = False) -> Tensor:
    """(G, P) a grid over the coil's parameters, everything else as in `around` (P,), by default the model's present values; all in 0…1.

    `thinned` takes the places of one colour, as on a chessboard.
    """
    theta = design.model.theta() if around is None else around
    axes = _axes(design.model)
    places = torch.cartesian_prod(*[torch.arange(len(axis), device=theta.device) for axis in axes]).reshape(-1, len(axes))
    if thinned:
        places = places[places.sum(dim=1) % 2 == 0]
    trials = theta.expand(len(places), -1).clone()
    trials[:, : len(axes)] = torch.stack([axis.to(theta)[places[:, i]] for i, axis in enumerate(axes)], dim=1)
    if len(design.model.thermometers) == 1:
        lag, _, second = to_physical(trials[:, :3], design.model.coil_parameters[:3]).split(1, dim=1)
        ratio = torch.tensor(ZEROS, dtype=theta.dtype, device=theta.device)[places[:, 1]].unsqueeze(1)
        lead = (ratio - 1.0 - second) * lag
        trials[:, 1:2] = to_unit(lead, design.model.coil_parameters[1:2]).clamp(0.0, 1.0)
    return trials


def _axes(model: GrayBox) -> list[Tensor]:
    """Values in 0…1 of the coil's lag and of its lead, or of the weights of the first thermometers."""
    count = min(max(len(model.thermometers), 2), 3)
    axes = [(torch.arange(COIL_TRIALS, dtype=torch.float64) + 1.0) / (COIL_TRIALS + 1)] * count
    axes[0] = LOW + (HIGH - LOW) * axes[0]
    if len(model.thermometers) == 1:
        axes[0] = to_unit(torch.tensor(LAGS_S, dtype=torch.float64).unsqueeze(1), model.coil_parameters[:1]).squeeze(1)
    return axes


def starts_in_motion(run: Run) -> bool:
    """Whether a record starts while its temperature moves already, so that the coil's first temperature is not the thermometer's."""
    return bool((first_rates(run.time - run.time[0], run.select(list(run.thermometers))) != 0).any())
