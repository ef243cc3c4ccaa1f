"""A grey box as fitted to some runs, and what follows from the fit."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import torch
from torch import Tensor

from zoo.diagnosis.elsewhere import Elsewhere
from zoo.diagnosis.noise_likelihood import START, Likelihood, Likely, NoiseMixtures, Place, with_rows
from zoo.diagnosis.occam import AGAIN, price_of_excess, price_of_shape, price_of_size
from zoo.diagnosis.trimming import trimmed
from zoo.effects.base import physical_value
from zoo.effects.repeated import kinds
from zoo.fitting.design import Design
from zoo.fitting.projection import orthonormal, project
from zoo.fitting.variable_projection import Fit
from zoo.models.graybox import GrayBox
from zoo.scoring.stages import rms
from zoo.units import UNITS, convert_parameter


class Freed(NamedTuple):
    """What a free function of one quantity is worth beside a model.

    Attributes:
        evidence: log Bayes factor over none, of the order that the runs call for.
        gain: of the log likelihood, which the evidence is less what the function's parameters cost.
        whole: log Bayes factor of all orders.
    """

    evidence: float
    gain: float
    whole: float


@dataclass(frozen=True, eq=False)
class Solved:
    """A fitted grey box.

    Attributes:
        names: its effects.
        model: holds the fitted values.
        design: its columns on the fitted runs.
        fit: the solution, in whitened block means.
        mixtures: the noise that the gyro may have.
        near: the mixture to start from in the search for the likeliest.
        prices: what its parameters cost in evidence, by the effects that were not trimmed, as far as it was asked for.
        freed: what free functions are worth beside it, those that were tried, by what they depend on.
        formed: evidence of the best of their forms with everything refitted, likewise.
        described: the bench of forms and the best form of all, see `zoo.diagnosis.form_search.best_form`; empty until somebody asks.
    """

    names: tuple[str, ...]
    model: GrayBox
    design: Design
    fit: Fit
    mixtures: NoiseMixtures
    near: Place = START
    prices: dict[frozenset[str], float] = field(default_factory=dict)
    freed: dict[str, Freed] = field(default_factory=dict)
    formed: dict[str, float] = field(default_factory=dict)
    described: list[tuple[Any, Any]] = field(default_factory=list)

    @cached_property
    def basis(self) -> Tensor:
        """(N, R) orthonormal basis of everything the model can still absorb to first order: its columns and the tangents of θ."""
        return orthonormal(torch.cat([self.fit.columns, self.fit.tangent], dim=1))

    @cached_property
    def likelihood(self) -> Likelihood:
        """Of its columns and tangents, under any mixture."""
        return Likelihood(self.mixtures, self.fit.plain, self.design.error, self.fit.held, self.near)

    @cached_property
    def likely(self) -> Likely:
        """The noise mixture under which the residual is most likely, see `NoiseMixtures.most_likely`."""
        return self.likelihood.likely

    @cached_property
    def residual(self) -> Tensor:
        """(N,) block means of error − model [unit], runs one after the other."""
        return self.design.error - self.plain_columns @ self.fit.amplitudes

    def places(self) -> dict[str, list[int]]:
        """Which columns are whose."""
        found, at = {}, 0
        for name, effect in self.model.named_effects():
            found[name] = list(range(at, at + len(effect.amplitudes)))
            at += len(effect.amplitudes)
        return found

    def shape_of(self, name: str) -> Tensor:
        """(S,) an effect's shape as it was fitted, physical."""
        return dict(self.model.named_effects())[name].shape_value.detach()

    def price(self, effects: dict[str, list[int]], each: float) -> float:
        """What the parameters cost in evidence, when the columns of some effects are trimmed under the likeliest noise, with the χ² lost by that.

        Those effects cost what `zoo.diagnosis.occam` says of their sizes and shapes, and of a whole number the logarithm of its choices. Any other
        parameter costs half of `each`, whether anything depends on it where the fit put it or not, for it is there in the other model as well; and so
        does a whole number that nearly every gyro has alike. What happens once more is cheaper, by `AGAIN`.

        Args:
            effects: places of their amplitudes.
            each: χ² that a parameter must be worth.
        """
        if not effects:
            return 0.5 * self._others(effects) * each + self._price_of_whole(effects, each)
        plain, edge, level = self.fit.plain, self.fit.plain_edge, self.mixtures.white / self.likely.noise.white
        whitened = self.mixtures.whitener(self.likely.place)[1](torch.cat([plain, self.design.error.unsqueeze(1), edge], dim=1))
        white, edge = (level * whitened).split([plain.shape[1] + 1, edge.shape[1]], dim=1)
        every = white[:, :-1] + torch.nn.functional.pad(edge, (plain.shape[1] - edge.shape[1], 0))
        white = torch.cat([white, level * with_rows(self.fit.held, white)])
        found = trimmed(white[:, :-1], white[:, -1], self.fit.moves, list(effects.values()), each, self._spare)
        shapes, blocks = self._shapes(effects, found.left)
        fixed = [place for place in found.left if place not in shapes]
        sizes = [[place for place in places if place in found.left] for places in effects.values()]
        occam = sum(float(price_of_size(len(own), _explained(white, own, fixed))) for own in sizes)
        occam += self._price_of_excess(white, sorted(place for own in sizes for place in own), fixed)
        occam += price_of_shape(every[:, shapes], every[:, fixed], blocks.to(every)) + self._price_of_whole(effects, each)
        return 0.5 * found.gain + found.choices + 0.5 * self._others(effects) * each + occam - AGAIN * self._times(effects)

    def _times(self, names: Collection[str]) -> int:
        """How many of some effects are something once more."""
        every = dict(self.model.named_effects())
        rest = {name: effect for name, effect in every.items() if name not in names}
        return len(names) - len(kinds(every, every)) + len(kinds(rest, rest))

    def _price_of_excess(self, white: Tensor, own: list[int], fixed: list[int]) -> float:
        """What amplitudes beyond their bounds cost, as they are where only some columns, whitened with the target behind them, are left."""
        largest = self._largest.to(white)[own]
        if not bool((self.fit.amplitudes[own].abs() > largest).any()):
            return 0.0
        refitted = project(white[:, fixed], white[:, -1]).amplitudes
        return float(price_of_excess(refitted[[fixed.index(place) for place in own]], largest))

    @cached_property
    def _largest(self) -> Tensor:
        """(K,) the largest size that each amplitude may have [output's unit]; infinite where that is no rate, or its unit no power of it."""
        unit = self.design.runs[0].unit
        declared = [one for _, effect in self.model.named_effects() for one in effect.amplitudes]
        if UNITS[unit].quantity != "rate":
            return torch.full((len(declared),), torch.inf, dtype=torch.float64)
        sizes = [convert_parameter(max(abs(one.low), abs(one.high)), one.unit, "dph", unit) for one in declared]
        return torch.tensor(sizes, dtype=torch.float64).nan_to_num(nan=torch.inf)

    @property
    def _spare(self) -> list[int]:
        """Places of the amplitudes that make no effect by themselves."""
        declared = [one for _, effect in self.model.named_effects() for one in effect.amplitudes]
        return [place for place, one in enumerate(declared) if one.spare]

    def _others(self, effects: Collection[str]) -> int:
        """How many parameters there are that are neither theirs nor whole numbers."""
        amplitudes = sum(len(places) for name, places in self.places().items() if name not in effects)
        return amplitudes + sum(owner not in effects and one.scale != "index" for owner, one in self.model.parameters_of_theta())

    def _shapes(self, effects: dict[str, list[int]], left: list[int]) -> tuple[list[int], Tensor]:
        """Places of the tangents of some effects, of those that are left, and blocks that each passes that is a moment."""
        amplitudes, average_s = len(self.fit.amplitudes), self.design.runs[0].average_s
        owners = [owner for owner, _ in self.model.parameters_of_theta()]
        blocks = torch.zeros(len(owners), dtype=torch.float64)
        for name, effect in self.model.named_effects():
            blocks[[i for i, owner in enumerate(owners) if owner == name]] = effect.blocks_of_moments(average_s)
        places = [i for i, owner in enumerate(owners) if owner in effects and amplitudes + i in left]
        return [amplitudes + i for i in places], blocks[places]

    def _price_of_whole(self, effects: dict[str, list[int]], each: float) -> float:
        """What whole numbers cost."""
        found = 0.0
        for name, effect in self.model.named_effects():
            for place, one in enumerate(effect.shape):
                if (name, one.name) in self.whole:
                    found += math.log(effect.choices(place, len(self.design.runs))) if name in effects and not one.usual else 0.5 * each
        return found

    @property
    def plain_columns(self) -> Tensor:
        """(N, K) block means of its columns, not whitened."""
        return self.fit.plain[:, : self.fit.columns.shape[1]]

    @cached_property
    def elsewhere(self) -> Elsewhere:
        """The model at other coils."""
        return Elsewhere(self.design, self.fit.theta)

    @property
    def rms(self) -> float:
        """RMS of the residual over the fitted runs [unit]."""
        return rms(self.residual)

    @property
    def freedom(self) -> int:
        """How many parameters were fitted that matter: without those on which nothing depends in these runs, such as a past of none."""
        return self.fit.columns.shape[1] + int(self.fit.moves.any(dim=1).sum()) + len(self.whole)

    @property
    def whole(self) -> list[tuple[str, str]]:
        """Whose whole numbers there are and which, to which nothing has a slope; those that nearly every gyro has do not count."""
        declared = zip(self.model.parameters_of_theta(), self.fit.theta, self.fit.moves, strict=True)
        numbers = [(owner, one, place) for (owner, one), place, moves in declared if one.scale == "index" and not bool(moves.any())]
        return [(owner, one.name) for owner, one, place in numbers if not (one.usual and float(physical_value(place, one)) == one.default)]


def _explained(white: Tensor, own: list[int], fixed: list[int]) -> Tensor:
    """χ² that some columns explain beside others, all whitened, the target last."""
    less = project(white[:, [place for place in fixed if place not in own]], white[:, -1]).cost
    return less - project(white[:, fixed], white[:, -1]).cost
