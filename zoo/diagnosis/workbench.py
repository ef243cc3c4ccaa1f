"""Fits grey boxes with different sets of effects to the same runs under the same noise model."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor

from zoo.diagnosis.noise_likelihood import START, NoiseMixtures, Place, gain
from zoo.diagnosis.preparation import reference_varies, without_outliers
from zoo.diagnosis.shape_search import Beside, apart, has_options, says_what_is_near, unusual
from zoo.diagnosis.solved import Solved
from zoo.effects.base import Effect
from zoo.effects.bounds import to_physical, to_unit
from zoo.effects.earlier import before_each
from zoo.effects.repeated import kind, with_times
from zoo.fitting.design import Design, coarse_starts, starts_in_motion
from zoo.fitting.noise import assumed
from zoo.fitting.projection import orthonormal
from zoo.fitting.several_starts import cheapest, fit_from
from zoo.fitting.variable_projection import Fit, fit
from zoo.measurements.run import Run
from zoo.models.graybox import GrayBox
from zoo.scoring.noise import NoiseModel, Whitener, effective_samples
from zoo.side_by_side import side_by_side

FAR = 1.5
"""RMS of a residual over the white noise above which a base is taken to have its coil in the wrong place."""
QUIET = 0.7
"""Ratio of a residual's RMS to the white noise below which there is nothing left to explain."""
VARIED_REFERENCE = "a reference that changes"
WORTH_RESHAPING, RESHAPED = 2.0, 2
"""χ² that another shape must gain for the fit to start from there once more, and how often it may."""
WORTH_A_FIT = 0.7
"""Share of the gain of the best start that one of another shape must have to be fitted from as well: the better of two may lead to the worse of two
minima."""
COARSE, FINE = 1e-3, 1e-5
"""Tolerance of the fit of a candidate, which decides by evidence of 5 and more, and of a model that is kept."""


@dataclass(frozen=True, eq=False)
class Guess:
    """Where one more effect may be.

    Attributes:
        name: of the effect.
        shape: (S,) physical.
        start: θ (P+S,) elsewhere, where it is known.
        looked: θ (K, P+S) elsewhere, where all shapes were tried there already.
        far: whether other shapes are tried, elsewhere as well where the model leaves much.
        others: θ (P,) of the model where all but this effect may be as well: it is fitted from there too.
    """

    name: str
    shape: Tensor
    start: Tensor | None = None
    looked: Tensor | None = None
    far: bool = True
    others: Tensor | None = None


class Workbench:
    """The runs, their noise, and the effects that may be combined."""

    def __init__(self, runs: list[Run], effects: dict[str, Effect], noise: NoiseModel, mixtures: NoiseMixtures, scatter: float = 0.0) -> None:
        """Keep what all fits share.

        Args:
            runs: R runs with the same columns.
            effects: every effect that may be named, freshly built.
            noise: of the block means, what fits are weighted with.
            mixtures: what it may be.
            scatter: RMS of what thermometers drawn smooth still make of a model's output, a part of the white noise [unit].
        """
        self.runs, self.noise, self.mixtures, self.scatter = runs, noise, mixtures, scatter
        self.stirred = scatter  # RMS of what readings make of a model's output, drawn smooth or not; see `zoo.diagnosis.readings`
        self.inputs = list(runs[0].columns)
        self.whitener = Whitener(noise, mixtures.runs)
        self.in_motion = any(starts_in_motion(run) for run in runs)
        self.varied_reference = reference_varies(runs)
        self.span_s = max(float(run.time[-1] - run.time[0]) for run in runs)
        before = before_each([(run.time, run.temperature) for run in runs])
        largest = max(float(run.table[:, -1].abs().max()) for run in runs)
        self.effects = {name: effect.seen_over(self.span_s).driven_to(largest).after(before) for name, effect in with_times(effects).items()}
        self.blocks = sum(run.blocks for run in runs)
        self._solved: dict[frozenset[str], Solved] = {}
        self._earlier: dict[tuple[str, ...], Tensor] = {}

    def available(self) -> list[str]:
        """Names in the catalogue of the effects that the runs can show."""
        return [name for name, effect in self.effects.items() if name == kind(name, effect) and not self.lacking(name)]

    def lacking(self, name: str) -> list[str]:
        """What an effect would need that the runs do not have: its columns, or a reference that changes."""
        effect = self.effects[name]
        if any(column not in self.inputs for column in effect.needs):
            return list(effect.needs)
        return [VARIED_REFERENCE] if effect.needs_varied_reference and not self.varied_reference else []

    def look_alikes(self, name: str) -> set[str]:
        """Names of the effects that are easily confused with one, by what either says."""
        return {other for other, effect in self.effects.items() if other in self.effects[name].confused_with or name in effect.confused_with}

    def shapes(self, name: str) -> Tensor:
        """(G, S) physical shapes of an effect to start searches from."""
        return self.effects[name].shapes_to_try(self.span_s, len(self.runs))

    def design(self, names: tuple[str, ...]) -> Design:
        """The columns of a set of effects on the runs."""
        return self._bare.of(GrayBox({name: copy.deepcopy(self.effects[name].beside(names)) for name in names}, self.inputs, self.in_motion))

    @cached_property
    def _bare(self) -> Design:
        """Of no effects; it keeps what all share."""
        return Design(GrayBox({}, self.inputs, self.in_motion), self.runs, self.whitener)

    def solve(self, names: tuple[str, ...], starts: list[Tensor] | None = None, near: Place = START, tolerance: float = FINE) -> Solved:
        """Fit a set of effects, from the best of the given starts or from several of a grid; solutions are remembered.

        Args:
            names: effects, in the order of the model.
            starts: θ (P,) in 0…1 to start from; by default a coarse grid over the coil's parameters.
            near: the noise of a similar model.
            tolerance: see `zoo.fitting.variable_projection.fit`.
        """
        known = self.known(names)
        if known is not None and starts is None:
            return known
        return self.taken(names, self.fitted(names, starts, tolerance), near)

    def fitted(self, names: tuple[str, ...], starts: list[Tensor] | None = None, tolerance: float = FINE) -> Fit:
        """The same without anything being kept of it, as side by side with others; see `taken`."""
        design, earlier = self.design(names), [self._earlier[names]] if names in self._earlier else []
        if not starts:
            return fit_from(design, torch.cat([coarse_starts(design), *(one.unsqueeze(0) for one in earlier)]), tolerance=tolerance)
        start = cheapest(design, torch.stack([*starts, *earlier]))
        return fit(design.plain_columns, design.target, start, tolerance=tolerance, weigh=self.whitener, prior=design.prior)

    def taken(self, names: tuple[str, ...], found: Fit, near: Place = START) -> Solved:
        """Remember a solution, unless a better one of the same effects is known."""
        known = self.known(names)
        best = found if known is None or known.names != names else min(found, known.fit, key=lambda one: one.total)
        self._solved[frozenset(names)] = self.placed(names, best, near)
        return self._solved[frozenset(names)]

    def placed(self, names: tuple[str, ...], found: Fit, near: Place = START) -> Solved:
        """A model with these effects where a fit put it."""
        design = self.design(names)
        design.model.assign(found.theta, found.amplitudes)
        return Solved(names, design.model, design, found, self.mixtures, near)

    def begin(self, names: tuple[str, ...]) -> Solved:
        """Fit the model as it stands.

        Effects whose shapes no step finds from where they are declared are put in last, each with its shapes searched for beside the others; those
        of a trained model are where they are given.

        Args:
            names: effects, in the order of the model.
        """
        hidden = [name for name in names if self.effects[name].sharp or len(self.effects[name].shape) > 1]
        plain = tuple(name for name in names if name not in hidden)
        if not hidden or not plain or self.known(names):
            return self.solve(names)
        solved = self.solve(plain)
        for name in hidden:
            solved = self.add(solved, name)
        return self.solve(solved.names, [self.design(solved.names).model.theta()], solved.likely.place)

    def extend(self, base: Solved, name: str, shape: Tensor, start: Tensor | None = None) -> Solved:
        """Refit, coarsely, with one more effect, its shape started where screening found it.

        Starts from the base's coil, or from elsewhere where the effect explains more there.

        Args:
            base: the model before.
            name: of the effect.
            shape: (S,) physical.
            start: θ (P+S,) elsewhere, where it is known.
        """
        return self.taken((*base.names, name), self.extended(base, [Guess(name, shape, start)])[0], base.likely.place)

    def extended(self, base: Solved, guesses: list[Guess]) -> list[Fit]:
        """The same of several effects, each by itself, without anything being kept of it, see `fitted`."""
        starts = [(i, one) for i, found in enumerate(side_by_side(lambda guess: self._starts(base, guess), guesses)) for one in found]
        fits = side_by_side(lambda start: self.fitted((*base.names, guesses[start[0]].name), [start[1]], COARSE), starts)
        own = [[found for (owner, _), found in zip(starts, fits, strict=True) if owner == i] for i in range(len(guesses))]
        return [min(found, key=lambda one: one.total) for found in own]

    def _starts(self, base: Solved, guess: Guess) -> list[Tensor]:
        """Where to fit a model with one more effect from."""
        effect, shape = self.effects[guess.name], guess.shape.unsqueeze(0)
        widely = guess.far and base.rms > FAR * self.mixtures.white
        elsewhere = guess.looked if widely or guess.start is not None else None
        if elsewhere is None and guess.start is not None:
            elsewhere = guess.start.unsqueeze(0)
        if elsewhere is None:
            elsewhere = base.elsewhere.look(effect, self.shapes(guess.name) if widely else shape, self.span_s)
        starts = self._apart(base, guess.name, torch.cat([self._with_shapes(base.fit.theta, effect, shape), elsewhere]), guess.far)
        return starts if guess.others is None else [*starts, self._with_shapes(guess.others, effect, shape)[0]]

    def _apart(self, base: Solved, name: str, starts: Tensor, far: bool) -> list[Tensor]:
        """The cheapest of some θ (G, P+S) of a model with one more effect.

        Of several, unless the effect says itself where a fit would not find its way, all shapes of its grid are among them, and of those that are
        apart the cheapest of others that gain nearly as much are taken as well.
        """
        effect, design = self.effects[name], self.design((*base.names, name))
        if not far or says_what_is_near(effect) or not effect.shape:
            return [cheapest(design, starts)]
        starts = torch.cat([starts, self._with_shapes(base.fit.theta, effect, self.shapes(name))])
        costs = design.cost(starts)
        shapes, least = to_physical(starts[:, len(base.fit.theta) :], effect.shape), float(costs.min())
        most = least + (1 - WORTH_A_FIT) * (base.fit.total - least)
        return [starts[one] for one in apart(effect, shapes, costs, self.span_s) if float(costs[one]) <= most]

    def _with_shapes(self, theta: Tensor, effect: Effect, shapes: Tensor) -> Tensor:
        """(G, P+S) θ of a model (P,) with one more effect of some physical shapes (G, S), all else as it is."""
        return torch.cat([theta.expand(len(shapes), -1), to_unit(shapes, effect.shape).to(theta)], dim=1)

    def finish(self, solved: Solved, added: tuple[str, ...] = ()) -> Solved:
        """Fit on from a coarse solution, and again from wherever the shape of an added effect is better beside all the others as they are now.

        What had been pressed against a bound while the added effects were missing is let go once, to the middle of its range.
        """
        start, released = solved.fit.theta, _released(solved, added)
        both = [start, released] if added and bool((released != start).any()) else [start]
        fits = side_by_side(lambda one: self.fitted(solved.names, [one]), both)
        fine = self.taken(solved.names, min(fits, key=lambda one: one.total), solved.likely.place)
        for _ in range(RESHAPED):
            starts = [start for name in added for start in self._reshaped(fine, name, anywhere=len(added) > 1)]
            if not starts:
                break
            fine = self.solve(fine.names, starts, fine.likely.place)
        return fine

    def _reshaped(self, solved: Solved, name: str, anywhere: bool) -> list[Tensor]:
        """θ with another shape for one effect, where its surroundings have a better one, or its grid has: others may have been missing before."""
        effect, own = self.effects[name], solved.places()[name]
        declared = solved.model.parameters_of_theta()
        at = [i for i, (owner, _) in enumerate(declared) if owner == name]
        if not at:
            return []
        others = solved.fit.columns[:, [i for i in range(solved.fit.columns.shape[1]) if i not in own]]
        beside = Beside.whitened(solved.design, solved.fit.theta, others, self.span_s)
        shape = to_physical(solved.fit.theta[at], effect.shape)
        now = solved.fit.cost + float(unusual(effect, shape.unsqueeze(0)))
        grids = [beside.searched(effect, self.shapes(name))] if anywhere else []
        cost, better = min([beside.closer(effect, now, shape), *grids], key=lambda found: found[0])
        if cost > now - WORTH_RESHAPING:
            return []
        theta = solved.fit.theta.clone()
        theta[at] = to_unit(better, effect.shape).to(theta)
        return [theta]

    def known(self, names: tuple[str, ...]) -> Solved | None:
        """The solution of these effects, if it was found before."""
        return self._solved.get(frozenset(names))

    def add(self, base: Solved, name: str, added: tuple[str, ...] = ()) -> Solved:
        """Refit with one more effect, its shape searched for; `added` are those whose shapes are searched for once more then, see `finish`."""
        from zoo.diagnosis.screening import screen  # screening works on a bench

        found = screen(self, base, [name])[0]
        return self.finish(self.extend(base, name, found.shape, start=found.start), added)

    def peek(self, base: Solved, name: str, shape: Tensor, start: Tensor | None = None) -> Solved:
        """One more effect without a refit of anything nonlinear: at the base's coil, or at θ (P+S,) elsewhere."""
        names, design = (*base.names, name), self.design((*base.names, name))
        theta = torch.cat([base.fit.theta, to_unit(shape, self.effects[name].shape).to(base.fit.theta)]) if start is None else start
        found = fit(design.plain_columns, design.target, theta, iterations=0, weigh=self.whitener, prior=design.prior)
        return self.placed(names, found, base.likely.place)

    def moved(self, solved: Solved, theta: Tensor) -> Solved:
        """The same effects at other nonlinear parameters (P,), their amplitudes fitted; the fitted values of the model stay."""
        found = fit(solved.design.plain_columns, solved.design.target, theta, iterations=0, weigh=self.whitener, prior=solved.design.prior)
        return Solved(solved.names, solved.model, solved.design, found, self.mixtures, solved.likely.place)

    def without(self, full: Solved, name: str) -> Solved:
        """Refit with one effect less, started from the full model's parameters; a solution that is known already stays where that start is worse.

        What the one had made up for, another may do with an option that it did not need beside it.
        """
        names, start = tuple(other for other in full.names if other != name), theta_without(full, name)
        known = self.known(names)
        if known is not None and known.names == names and float(known.design.cost(start.unsqueeze(0))) >= known.fit.total:
            return known
        less = self.solve(names, [start], full.likely.place)
        others = [one for other in names if has_options(self.effects[other]) for one in self._reshaped(less, other, anywhere=False)]
        return self.solve(names, others, full.likely.place) if others else less

    @cached_property
    def effective_samples(self) -> float:
        """How many independent block means the runs are worth under the noise that gyros usually have.

        A parameter costs the same whatever noise a search comes to: with that of a gyro that walks, six hundred blocks would count as six, and what
        chance explains of them would be cheap.
        """
        return effective_samples(assumed(self.mixtures.white, self.runs), self.mixtures.runs)

    def evidence(self, less: Solved, more: Solved) -> float:
        """Log Bayes factor of one model over another, usually a smaller one, each under the noise that suits it best, see `gain`.

        A slow residual may be an effect or flicker: the noise mixture is part of either hypothesis, so that an effect must beat the noise that would
        do without it. That a slow column takes some of the noise away is no merit, see `NoiseMixtures.most_likely`.

        An effect that only one of them has is judged by those of its amplitudes that the runs call for, and costs what its sizes and shapes do, see
        `zoo.diagnosis.occam`; any other parameter costs half the logarithm of the effective number of samples (Schwarz 1978). What filters the
        thermometers' readings must explain more than their scatter, which the rest of the model turns into a noise that is not quite white.
        """
        return gain(less.likelihood, more.likelihood) - (self._cost(more, less.names) - self._cost(less, more.names))

    def _cost(self, solved: Solved, common: tuple[str, ...]) -> float:
        """What a model's parameters cost, and that they have moved, with effects that are not among the common ones trimmed."""
        key = frozenset(common)
        if key not in solved.prices:
            optional = {name: places for name, places in solved.places().items() if name not in common}
            solved.prices[key] = 0.5 * solved.fit.moved + solved.price(optional, math.log(self.effective_samples)) + self._of_readings(solved, key)
        return solved.prices[key]

    def _of_readings(self, solved: Solved, common: frozenset[str]) -> float:
        """What an effect that filters the readings may explain of their scatter: gain of the log likelihood if it took that all away."""
        filters = any(effect.filters for name, effect in solved.model.named_effects() if name not in common)
        return 0.5 * self.blocks * (self.stirred / self.mixtures.white) ** 2 if filters else 0.0

    def noise_floor(self, solved: Solved) -> float:
        """RMS that the residual would have if it were the likeliest noise mixture: its variance less what the model's freedom absorbs [unit]."""
        noise = solved.likely.noise
        basis = orthonormal(solved.fit.plain)
        kept, at = 0.0, 0
        for blocks in self.mixtures.runs:
            covariance = noise.covariance(blocks)
            part = basis[at : at + len(covariance)]
            kept += float(covariance.trace()) - float(((covariance @ part) * part).sum())
            at += len(covariance)
        return math.sqrt(max(kept, 0.0) / self.blocks)

    def reached_floor(self, solved: Solved) -> float:
        """The same, but no more than the model leaves where that noise walks as few gyros do: then what is slow was taken for too much of a walk."""
        expected = self.noise_floor(solved)
        return min(expected, solved.rms) if self.mixtures.much_walk(solved.likely.noise) else expected

    def with_white(self, white: float) -> Workbench:
        """The same runs with another level of white noise [unit]."""
        return self.with_runs(self.runs, white, self.scatter)

    def without_outliers(self, solved: Solved) -> Workbench:
        """The runs without the few isolated blocks that a model leaves far off; the same bench where there are none."""
        runs = without_outliers(self.runs, list(solved.residual.split([run.blocks for run in self.runs])), solved.likely.noise.white)
        return self if runs is self.runs else self.with_runs(runs, self.mixtures.white, self.scatter)

    def with_runs(self, runs: list[Run], white: float, scatter: float) -> Workbench:
        """Nearly the same runs with another level of white noise, or another part of it that is the readings' [unit]."""
        noise = assumed(white, runs)
        return self._before(Workbench(runs, self.effects, noise, NoiseMixtures(runs, noise.white), scatter))

    @property
    def steadied(self) -> bool:
        """Whether the thermometers were drawn smooth, see `zoo.diagnosis.readings`."""
        return any(run.read is not None for run in self.runs)

    def as_read(self) -> Workbench:
        """The same runs with their thermometers as they were read."""
        return self._before(Workbench([run.as_read for run in self.runs], self.effects, self.noise, self.mixtures))

    def with_noise(self, noise: NoiseModel) -> Workbench:
        """The same runs, fits weighted with another noise model."""
        return self._before(Workbench(self.runs, self.effects, noise, self.mixtures, self.scatter))

    def _before(self, other: Workbench) -> Workbench:
        """Another bench on the same or nearly the same runs, with what this one found of effects that are the same to start from as well."""
        found = self._earlier | {solved.names: solved.fit.theta for solved in self._solved.values()}
        other.stirred = other.scatter or self.stirred
        shared = {name for name, effect in self.effects.items() if other.effects.get(name) is effect}
        other._earlier = {names: theta for names, theta in found.items() if shared.issuperset(names)}
        return other

    def with_effects(self, effects: dict[str, Effect]) -> Workbench:
        """The same runs and noise, with other effects to name; what was solved of those that are the same is known."""
        other = self._before(Workbench(self.runs, effects, self.noise, self.mixtures, self.scatter))
        other._solved = {names: solved for names, solved in self._solved.items() if solved.names in other._earlier}
        return other


def theta_without(full: Solved, name: str) -> Tensor:
    """θ (P,) of a model without that of one effect."""
    owners = [owner for owner, _ in full.model.parameters_of_theta()]
    return full.fit.theta[torch.tensor([owner != name for owner in owners], dtype=torch.bool, device=full.fit.theta.device)]


def _released(solved: Solved, added: tuple[str, ...]) -> Tensor:
    """θ (P,) with what rests on a bound in the middle between both, but for the effects that were added, for whole numbers, and where a prior pulls
    it back."""
    older = [owner not in added and not one.within and one.scale != "index" for owner, one in solved.model.parameters_of_theta()]
    resting = (solved.fit.theta <= 0.0) | (solved.fit.theta >= 1.0)
    return torch.where(resting & torch.tensor(older, device=resting.device), 0.5, solved.fit.theta)
