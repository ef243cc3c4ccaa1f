"""How likely a residual is under noise alone, whatever mixture of white, flicker and random walk it may be."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cache, cached_property

import torch
from torch import Tensor

from zoo.fitting.noise import blocks_of
from zoo.fitting.projection import log_volume, project
from zoo.measurements.run import Run
from zoo.scoring.noise import NoiseModel, Whitener

FLICKER_SHARES = (0.035, 0.18, 0.42, 0.85, 1.4)
"""Bias instability over the white noise of a block: medium and tactical gyros have 0.05 to 1.7."""
WALK_SHARES = (0.0, 0.1, 0.3, 0.5, 0.8, 1.6)
"""Rate random walk per √h over the white noise of a block: medium gyros have 0.02 to 0.8, tactical ones up to 1.7."""
MUCH_WALK = 0.8
"""Share from which a walk is looked at more closely."""
LEVEL_SPREAD = 0.05
"""How well the white level is known, as a share."""
LEVELS = tuple(1.0 + 0.02 * i for i in range(-5, 6))
"""Factors on the level of a mixture: twice that spread either way and no more, or an excess would be taken for a louder noise."""
START = (1, 1)
Place = tuple[int, int]
TYPICAL_FLICKER, TYPICAL_WALK, FACTOR = 0.18, 0.1, 2.5
"""Log-normal prior of both shares; no walk at all is as likely as the typical one."""


@dataclass(frozen=True, eq=False)
class Likely:
    """The most likely noise for one model.

    Attributes:
        logarithm: log likelihood, prior of the noise included.
        restricted: the same of what the model's columns do not reach, see `NoiseMixtures.most_likely`.
        noise: the mixture.
        cost: χ² of the residual under it, the level's factor taken out, with what moving along held tangents costs.
        place: on the grid of mixtures.
    """

    logarithm: float
    restricted: float
    noise: NoiseModel
    cost: float
    place: Place


class NoiseMixtures:
    """The mixtures that a gyro may have, each with its whitener."""

    def __init__(self, runs: list[Run], white: float) -> None:
        """Keep the runs' blocks.

        Args:
            runs: the fitted runs.
            white: RMS of the white noise of a block mean [unit].
        """
        self.runs = blocks_of(runs)
        self.white = white
        self._made: dict[Place, tuple[NoiseModel, Whitener]] = {}

    def whitener(self, place: Place) -> tuple[NoiseModel, Whitener]:
        """The mixture at a place of the grid flicker × walk, and its whitener, made at first use."""
        if place not in self._made:
            flicker, walk = FLICKER_SHARES[place[0]], WALK_SHARES[place[1]]
            noise = NoiseModel(self.white, flicker * self.white, walk * self.white)
            self._made[place] = (noise, Whitener(noise, self.runs))
        return self._made[place]

    def much_walk(self, noise: NoiseModel) -> bool:
        """Whether a mixture walks as few gyros do, so that something else may be taken for a walk."""
        return noise.walk >= 0.99 * MUCH_WALK * noise.white

    def most_likely(self, columns: Tensor, target: Tensor, start: Place = START, held: Tensor | None = None, plain: bool = False) -> Likely:
        """Climb to the likeliest mixture, the amplitudes fitted under each.

        A slow column takes some of the slow noise away, so that the likelihood of what is left finds less of it than there is. The restricted
        likelihood, of that part of the target which no column reaches, reckons with it (Patterson & Thompson 1971, Biometrika 58:545); where
        hardly any slow noise is left to be seen, the prior of the mixtures decides.

        Args:
            columns: (N, K) block means of a model's columns, its tangents included [unit].
            target: (N,) block means of what they are fitted to [unit].
            start: where to climb from; by default the typical mixture.
            held: (P, L+1) rows of the first L columns and the target that hold tangents back, see `zoo.fitting.variable_projection.Fit.held`.
            plain: whether it is the likelihood of the residual that is made greatest, as against what does without this noise.
        """
        joined = torch.cat([columns, target.unsqueeze(1)], dim=1)
        at = cache(lambda place: self._joined(place, joined, held))
        height = cache(lambda place: at(place).logarithm if plain else at(place).restricted)
        place = start
        while True:
            best = max(_neighbours(place), key=height)
            if best == place:
                return at(place)
            step = best[0] - place[0], best[1] - place[1]
            place, ahead = best, (best[0] + step[0], best[1] + step[1])
            while ahead in _neighbours(place) and height(ahead) > height(place):
                place, ahead = ahead, (ahead[0] + step[0], ahead[1] + step[1])

    def at(self, place: Place, columns: Tensor, target: Tensor, held: Tensor | None = None) -> Likely:
        """One mixture, see `most_likely`."""
        return self._joined(place, torch.cat([columns, target.unsqueeze(1)], dim=1), held)

    def _joined(self, place: Place, joined: Tensor, held: Tensor | None = None) -> Likely:
        noise, whitener = self.whitener(place)
        white = whitener(joined)
        cost = held_cost(white, held)
        walk = WALK_SHARES[place[1]] or TYPICAL_WALK
        prior = _log_prior(FLICKER_SHARES[place[0]], TYPICAL_FLICKER) + _log_prior(walk, TYPICAL_WALK)
        absorbed, reached = log_volume(_with_held(white, held)[:, :-1] * self.white, joined[:, :-1])
        known = prior - 0.5 * whitener.log_determinant
        factor, restricted = _best_level(cost, len(joined) - reached)
        scaled = replace(noise, white=noise.white * factor, flicker=noise.flicker * factor, walk=noise.walk * factor)
        return Likely(_best_level(cost, len(joined))[1] + known, restricted - 0.5 * absorbed + known, scaled, cost / factor**2, place)


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Of a model's columns and what they are fitted to, under any mixture.

    Attributes:
        mixtures: that the noise may be.
        columns: (N, K) block means of the model's columns, its tangents included [unit].
        target: (N,) block means of what they are fitted to [unit].
        held: rows that hold tangents back, see `NoiseMixtures.most_likely`.
        near: the mixture to start from in the search for the likeliest.
    """

    mixtures: NoiseMixtures
    columns: Tensor
    target: Tensor
    held: Tensor | None = None
    near: Place = START
    _found: dict[Place, Likely] = field(init=False, repr=False, default_factory=dict)

    def of(self, columns: Tensor) -> Likelihood:
        """The same of other columns (N, L), the likeliest mixture searched for from here."""
        return replace(self, columns=columns, near=self.likely.place)

    @cached_property
    def likely(self) -> Likely:
        """The likeliest mixture."""
        found = self.mixtures.most_likely(self.columns, self.target, self.near, self.held)
        self._found[found.place] = found
        return found

    def under(self, place: Place) -> Likely:
        """One mixture."""
        if place not in self._found:
            self._found[place] = self.mixtures.at(place, self.columns, self.target, self.held)
        return self._found[place]


def gain(less: Likelihood, more: Likelihood) -> float:
    """Log likelihood of one model over another's, each under its own likeliest noise or the other's, whichever suits it better.

    The mixtures are few: beside a column more the likeliest may be the next one, and the step from one to the other is no evidence.
    """
    places = less.likely.place, more.likely.place
    worse, better = (max(one.under(place).logarithm for place in places) for one in (less, more))
    return better - worse


def _with_held(white: Tensor, held: Tensor | None) -> Tensor:
    """Whitened columns (N, K+1), above the rows that hold some of them back."""
    return white if held is None else torch.cat([white, with_rows(held, white)])


def held_cost(white: Tensor, held: Tensor | None = None) -> float:
    """χ² that columns leave of the last of them, all whitened, with what moving along tangents costs beyond what where they start from does.

    Args:
        white: (N, K+1).
        held: (P, L+1) rows of the first L columns and of the last, see `zoo.fitting.variable_projection.Fit.held`.
    """
    if held is None:
        return float(project(white[:, :-1], white[:, -1]).cost)
    joined = _with_held(white, held)
    return float(project(joined[:, :-1], joined[:, -1]).cost - held[:, -1].square().sum())


def with_rows(held: Tensor, white: Tensor) -> Tensor:
    """(P, K+1) rows that hold tangents back, as wide as the columns (N, K+1) that they go below."""
    return torch.cat([held[:, :-1], held.new_zeros(len(held), white.shape[1] - held.shape[1]), held[:, -1:]], dim=1).to(white)


def _neighbours(place: Place) -> list[Place]:
    """A place of the grid and those next to it."""
    i, j = place
    around = [(i, j), (i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)]
    return [(a, b) for a, b in around if 0 <= a < len(FLICKER_SHARES) and 0 <= b < len(WALK_SHARES)]


def _log_prior(share: float, typical: float) -> float:
    return -0.5 * (math.log(share / typical) / math.log(FACTOR)) ** 2


def _best_level(cost: float, size: int) -> tuple[float, float]:
    """Likeliest factor on the level of a mixture under which the residual has this χ², and its log likelihood."""
    levels = torch.tensor(LEVELS, dtype=torch.float64)
    logs = -0.5 * cost / levels**2 - size * levels.log() - 0.5 * (levels.log() / LEVEL_SPREAD) ** 2
    best = int(logs.argmax())
    return float(levels[best]), float(logs[best])
