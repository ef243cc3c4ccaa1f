"""Where each turn of a wound coil lies along the fibre: from the winding's pattern to the weights of the Shupe integral."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.errors import InputError, nearest

PERIODS = {"cylindrical": "A", "dipolar": "AB", "quadrupolar": "ABBA", "octupolar": "ABBABAAB", "hexadecapolar": "ABBABAABBAABABBA"}
"""Supply that lays each layer, from the inside, repeated; A and B start at the middle of the fibre. Each is the one before it, then that with A and B
exchanged."""
CROSSOVER_FREE = "crossover_free"
"""A winds one axial half of every layer, B the other (double cylinder)."""
PATTERNS = (*PERIODS, CROSSOVER_FREE)


@dataclass(frozen=True)
class Coil:
    """A coil's geometry, before it is wound.

    Attributes:
        layers: how many, from the inside.
        turns: in every layer.
        diameter_m: mean diameter of the winding [m].
        layer_pitch_m: distance of neighbouring layers [m].
        turn_pitch_m: distance of neighbouring turns [m].
        pattern: one of `PATTERNS`.
        index: n of the fibre.
        thermo_optic_per_k: dn/dT + n·α of the fibre [1/K]; 8.6e-6 of silica and 0.8e-6 of its expansion (Rego 2023, Sensors 23:6023).
    """

    layers: int
    turns: int
    diameter_m: float
    layer_pitch_m: float
    turn_pitch_m: float
    pattern: str = "quadrupolar"
    index: float = 1.452
    thermo_optic_per_k: float = 9.4e-6

    def __post_init__(self) -> None:
        """Check.

        Raises:
            InputError: no layers or turns, a size that is not above 0, a winding that reaches the axis, an unknown pattern.
        """
        for key in ("layers", "turns"):
            if not isinstance(getattr(self, key), int) or getattr(self, key) < 1:
                raise InputError(f"coil.{key}={getattr(self, key)}: a whole number from 1 up is possible")
        for key in ("diameter_m", "layer_pitch_m", "turn_pitch_m", "index"):
            if not 0 < getattr(self, key) < math.inf:
                raise InputError(f"coil.{key}={getattr(self, key)}: a number above 0 is possible")
        if self.layers * self.layer_pitch_m >= self.diameter_m:
            layers = f"{self.layers} layers of {self.layer_pitch_m:g} m"
            raise InputError(f"coil.diameter_m={self.diameter_m:g}: {layers} do not fit into a mean diameter of {self.diameter_m:g} m")
        if self.pattern not in PATTERNS:
            raise InputError(f"coil.pattern='{self.pattern}': {nearest(self.pattern, PATTERNS)}")

    @property
    def radii(self) -> Tensor:
        """(layers,) of each layer's fibre, from the inside [m]."""
        place = torch.arange(self.layers, dtype=torch.float64) - (self.layers - 1) / 2
        return self.diameter_m / 2 + place * self.layer_pitch_m

    @property
    def radial_m(self) -> float:
        """Thickness of the winding [m]."""
        return self.layers * self.layer_pitch_m

    @property
    def height_m(self) -> float:
        """Axial height of the winding [m]."""
        return self.turns * self.turn_pitch_m


@dataclass(frozen=True, eq=False)
class Winding:
    """A wound coil: every turn's place along the fibre.

    Attributes:
        coil: its geometry.
        start: (layers, turns) fibre coordinate s at which each turn begins, from the end of A [m]; turns from one flange to the other.
        length: (layers, turns) of each turn [m].
        supply: (layers, turns) 0 where A laid the turn, 1 where B did.
        first: () fibre coordinate of the first end after trimming [m].
        last: () of the second end [m].
    """

    coil: Coil
    start: Tensor
    length: Tensor
    supply: Tensor
    first: Tensor
    last: Tensor

    @property
    def fibre_m(self) -> float:
        """L, what is left of the fibre after trimming [m]."""
        return float(self.last - self.first)

    def weights(self) -> Tensor:
        """(layers, turns) share of each turn's temperature rate in Shupe's error [rad/s per K/s].

        Ω = n·n_T/(D·L)·∫₀ᴸ Ṫ(s)·(L − 2s) ds, counted positive where the fibre end of supply A warms first; n_T = dn/dT + n·α, uniform (Shupe 1980,
        Appl. Opt. 19:654). The integral over a turn at one temperature is exact.
        """
        fibre = self.last - self.first
        begin = torch.minimum((self.start - self.first).clamp_min(0.0), fibre)
        end = torch.minimum((self.start + self.length - self.first).clamp_min(0.0), fibre)
        lever = (end - begin) * (fibre - begin - end)
        return self.coil.index * self.coil.thermo_optic_per_k / (self.coil.diameter_m * fibre) * lever

    def reversed(self) -> Winding:
        """The same coil with its two ends exchanged."""
        begin = self.first + self.last - self.start - self.length
        return Winding(self.coil, begin, self.length, 1 - self.supply, self.first, self.last)


def wind(coil: Coil, errors: Tensor | None = None, trimmed_m: float = 0.0) -> Winding:
    """Lay the fibre, layer by layer from the inside, from the fibre's middle outwards with the supplies A and B.

    Each supply changes its axial direction from one of its layers to the next, so that a pair AA or BB returns to the flange it came from.

    Args:
        coil: geometry and pattern.
        errors: (layers,) or (layers, 2) fibre that a layer has too much, by layer or by layer and supply, in turns of a layer that one supply lays
            alone; spread over its turns.
        trimmed_m: fibre cut off at the end of A (negative: of B) to move the optical middle [m].

    Raises:
        InputError: errors of another shape or larger than a layer, or a trim longer than one.
    """
    share = _errors(coil, errors)
    supply = _supplies(coil)
    circumference = 2 * math.pi * coil.radii.unsqueeze(1)
    length = circumference * (1 + share.gather(1, supply))
    order = _order(coil, supply)
    along = torch.zeros_like(length)
    for which in (0, 1):
        chosen = torch.nonzero(supply.flatten() == which).squeeze(-1)
        chosen = chosen[order.flatten()[chosen].argsort()]
        laid = length.flatten()[chosen]
        end = laid.cumsum(0)
        # A runs from the middle towards s = 0, B towards s = L; the middle is s = 0 here.
        along.flatten()[chosen] = -end if which == 0 else end - laid
    first, last = along.min(), (along + length).max()
    if abs(trimmed_m) > float(circumference[-1]) * coil.turns:
        raise InputError(f"coil: trimming {trimmed_m:g} m is more than a layer")
    ends = (torch.zeros_like(first) + max(trimmed_m, 0.0), last - first + min(trimmed_m, 0.0))
    return Winding(coil, along - first, length, supply, *ends)


def shupe_weight(winding: Winding) -> float:
    """C_w: error when the rates of the outer and the inner face differ by 1 K/min and grow linearly between [rad/s]."""
    layers = winding.coil.layers
    profile = (torch.arange(layers, dtype=torch.float64) + 0.5) / layers - 0.5
    return float((winding.weights().sum(1) * profile).sum()) / 60.0


def balancing_trim(coil: Coil, errors: Tensor | None, share: float = 1.0) -> float:
    """Fibre to cut off, as in `wind`, that takes away a share of C_w [m]; as much as one layer's where that does not suffice.

    Raises:
        InputError: see `wind`.
    """
    most = 2 * math.pi * float(coil.radii[-1]) * coil.turns * 0.999
    weight, trim = shupe_weight(wind(coil, errors)), 0.0
    wanted, slope = (1 - share) * weight, (shupe_weight(wind(coil, errors, min(1.0, most))) - weight) / min(1.0, most)
    if slope == 0:
        return 0.0  # a single layer has no radial sensitivity to trim
    for _ in range(3):  # all but linear in the trim
        trim = max(-most, min(most, trim + (wanted - shupe_weight(wind(coil, errors, trim))) / slope))
    return trim


def _supplies(coil: Coil) -> Tensor:
    """(layers, turns) 0 for A, 1 for B."""
    if coil.pattern == CROSSOVER_FREE:
        half = torch.arange(coil.turns) >= coil.turns // 2
        return half.long().expand(coil.layers, -1).contiguous()
    period = PERIODS[coil.pattern]
    letters = [period[layer % len(period)] for layer in range(coil.layers)]
    return torch.tensor([[0 if letter == "A" else 1] for letter in letters]).expand(-1, coil.turns).contiguous()


def _order(coil: Coil, supply: Tensor) -> Tensor:
    """(layers, turns) number of each turn in the order in which its supply lays it."""
    places = torch.arange(coil.turns)
    order = torch.zeros_like(supply)
    laid = [0, 0]
    for layer in range(coil.layers):
        for which in (0, 1):
            mine = places[supply[layer] == which]
            if len(mine) == 0:
                continue
            forward = laid[which] % 2 == (which == 0 and coil.pattern == CROSSOVER_FREE)  # both begin in the middle between the flanges
            order[layer, mine if forward else mine.flip(0)] = layer * coil.turns + torch.arange(len(mine))
            laid[which] += 1
    return order


def _errors(coil: Coil, errors: Tensor | None) -> Tensor:
    """(layers, 2) share by which the turns of each supply are longer than their circumference."""
    if errors is None:
        return torch.zeros(coil.layers, 2, dtype=torch.float64)
    if errors.shape not in {(coil.layers,), (coil.layers, 2)}:
        raise InputError(f"coil: winding errors of shape {tuple(errors.shape)}; one a layer is needed ({coil.layers})")
    share = (errors if errors.dim() == 2 else errors.unsqueeze(1).expand(-1, 2)).double() / coil.turns
    if not bool((share > -1).all()):
        raise InputError(f"coil: a winding error of {float(errors.min()):.3g} turns in a layer of {coil.turns}; a layer has to have some fibre")
    return share
