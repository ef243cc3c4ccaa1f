"""What a case is, all of it drawn from its seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from hidden_effects.forms import clock, memory, outside, state, turning
from hidden_effects.forms.form import Form, Forms, decade
from hidden_effects.programs import KINDS as PROGRAMS
from hidden_effects.programs import TURNS

from zoo.simulator.laboratory.chamber import Chamber

BASE = ("static_bias", "shupe", "mohr")
FORMS: Forms = {**memory.FORMS, **state.FORMS, **clock.FORMS, **turning.FORMS}
NAMES = tuple(sorted([*FORMS, "dead_band"]))
SHARES = {"nothing": 0.15, "one": 0.5, "two": 0.2, "outside": 0.15}
SMALLEST, LARGEST = 0.15, 5.0
"""Amplitudes, half of peak to peak over the fitted runs, in white noise of a mean over 10 s."""
BOTH_LARGE = 0.6
"""Share of the cases with two hidden effects in which both are of 1 or more, as by chance few would be."""
SUITS = {
    "scale_factor": {"flip", "tumble", "table"},
    "scale_factor_nonlinearity": {"table"},
    "misalignment": {"flip"},
    "dead_band": {"slow"},
    "fixture_rotation": {"constant", "flip"},
}
"""Ways to turn the gyro that show an effect, where not all do."""
TWO = {"thermal_gradient"}
"""What only a second thermometer shows."""
TURNED_ANYWAY = 0.12


@dataclass(frozen=True)
class Recipe:
    """One case.

    Attributes:
        seed: of everything.
        kind: one of `SHARES`.
        hidden: names, ``"outside"`` for what no catalogue has.
        amplitudes: of each [white noise of a mean over 10 s].
        gyro: class of the gyro, ``"medium"`` or ``"tactical"``.
        heat: fidelity of the winding.
        thermometers: where they sit, the main one first.
        programs: kind of the chamber program of each fitted run.
        turns: how the gyro is turned.
        latitude_deg: of the laboratory.
        chamber: how its air follows.
        gap: whether rows of one run are missing.
        spikes: how many rows of the fitted runs are far off.
    """

    seed: int
    kind: str
    hidden: tuple[str, ...]
    amplitudes: tuple[float, ...]
    gyro: str
    heat: str
    thermometers: tuple[str, ...]
    programs: tuple[str, ...]
    turns: str
    latitude_deg: float
    chamber: Chamber
    gap: bool
    spikes: int

    def chance(self, *what: int) -> np.random.Generator:
        """A stream of its own for each use."""
        return np.random.default_rng([self.seed, *what])


def recipe(seed: int) -> Recipe:
    """Draw a case."""
    chance = np.random.default_rng([seed, 0])
    kind = str(chance.choice(list(SHARES), p=list(SHARES.values())))
    hidden = _hidden(kind, chance)
    program = str(chance.choice(PROGRAMS))
    return Recipe(
        seed=seed,
        kind=kind,
        hidden=hidden,
        amplitudes=_amplitudes(hidden, chance),
        gyro="tactical" if chance.random() < 0.2 else "medium",
        heat="radial_axial" if chance.random() < 0.1 else "radial",
        thermometers=("spool", "housing") if chance.random() < 0.65 or set(hidden) & TWO else ("spool",),
        programs=(program,) * int(chance.choice([1, 2, 3, 4], p=[0.1, 0.2, 0.5, 0.2])),
        turns=_turns(hidden, chance),
        latitude_deg=float(chance.uniform(35, 60)),
        chamber=_chamber(chance),
        gap=bool(chance.random() < 0.25),
        spikes=int(chance.integers(1, 5)) if chance.random() < 0.25 else 0,
    )


def _hidden(kind: str, chance: np.random.Generator) -> tuple[str, ...]:
    if kind == "outside":
        return ("outside",)
    count = {"nothing": 0, "one": 1, "two": 2}[kind]
    while True:
        names = tuple(str(name) for name in chance.choice(NAMES, size=count, replace=False))
        if _turns_of(names):
            return names


def _amplitudes(hidden: tuple[str, ...], chance: np.random.Generator) -> tuple[float, ...]:
    least = 1.0 if len(hidden) > 1 and chance.random() < BOTH_LARGE else SMALLEST
    return tuple(decade(chance, least, LARGEST) for _ in hidden)


def _turns_of(names: tuple[str, ...]) -> list[str]:
    """Ways to turn the gyro that suit all of these effects; none where two exclude each other."""
    return sorted(set(TURNS).intersection(*(SUITS.get(name, TURNS) for name in names)))


def _turns(names: tuple[str, ...], chance: np.random.Generator) -> str:
    """The axis stays where nothing hidden has to do with it, in most cases."""
    possible = _turns_of(names)
    if any(name in SUITS for name in names):
        return str(chance.choice(possible))
    return str(chance.choice(["flip", "tumble", "table"])) if chance.random() < TURNED_ANYWAY else "constant"


def _chamber(chance: np.random.Generator) -> Chamber:
    cycling = float(chance.uniform(0.05, 0.3)) if chance.random() < 0.5 else 0.0
    overshoot = float(chance.choice([0.0, 0.05]))
    return Chamber(lag_s=float(chance.uniform(60, 240)), overshoot=overshoot, cycling_k=cycling, cycling_s=float(chance.uniform(200, 500)))


def forms_of(one: Recipe, sigma_dph: float) -> list[Form]:
    """The hidden effects' forms; `sigma_dph` is the white noise of a mean over 10 s [°/h]."""
    return [_form(one, place, sigma_dph) for place in range(len(one.hidden))]


def band_dph(one: Recipe, sigma_dph: float) -> float:
    """Half-width of the dead band that makes an error of the drawn amplitude without being scaled [°/h]; 0 where there is none."""
    if "dead_band" not in one.hidden:
        return 0.0
    place = one.hidden.index("dead_band")
    largest = float(np.abs(turning.band(np.linspace(0.0, 2.0, 2001), _edge(one, place))).max())
    return one.amplitudes[place] * sigma_dph / largest


def _edge(one: Recipe, place: int) -> float:
    return turning.edge(one.chance(1, place))


def _form(one: Recipe, place: int, sigma_dph: float) -> Form:
    if one.hidden[place] == "dead_band":
        return turning.dead_band(band_dph(one, sigma_dph), _edge(one, place))
    chance = one.chance(1, place)
    ways = (FORMS | outside.FORMS)[one.hidden[place]]
    return ways[int(chance.integers(len(ways)))](chance)
