"""Chamber programs of several kinds, and how the gyro is turned meanwhile; everything drawn."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from hidden_effects.body import Array
from hidden_effects.forms.form import decade

from zoo.catalog import build
from zoo.simulator.laboratory.earth import earth_rate
from zoo.simulator.laboratory.profiles import cycle, staircase, tour
from zoo.simulator.laboratory.program import Campaign, Program

KINDS = ("campaign", "staircase", "cycle", "multirate", "minor_loops", "random")
TURNS = ("constant", "flip", "tumble", "table", "slow")
"""Earth's rate throughout; the axis up and down; four positions of it in the meridian; a rate table; a dead band's width about no rate."""
POSITIONS = {"flip": (0, 180), "tumble": (0, 90, 180, 270)}
"""Of the axis from the vertical toward the north [°]."""
GRID_S, STAYS = 600, 4
"""How long the table keeps a rate [s]; for how many such times the axis stays in a position."""


def random_program(chance: np.random.Generator, low_c: float = -40.0, high_c: float = 65.0) -> Program:
    """Six to nine stops anywhere between two temperatures [°C], each with its own rate and hold."""
    count = int(chance.integers(6, 10))
    stops = [(chance.uniform(low_c, high_c), decade(chance, 0.3, 2.5), chance.uniform(900, 3600)) for _ in range(count)]
    return tour(
        float(np.clip(chance.uniform(10, 30), low_c, high_c)), [(round(c, 1), round(rate, 2), round(hold, -1)) for c, rate, hold in stops], 2400.0
    ).of(1)


@cache
def _shipped(name: str) -> Campaign:
    made: Campaign = build("profile", name)
    return made


def run_program(kind: str, label: int, chance: np.random.Generator) -> Program:
    """The program of a run, counted from 1; runs of one kind differ in their limits and rates."""
    if kind in {"campaign", "multirate", "minor_loops"}:
        return _shipped(kind).of(label) if label % 2 else _shipped(kind).of(label).reversed()
    if kind == "random":
        return random_program(chance)
    low, high = round(chance.uniform(-45, -20)), round(chance.uniform(45, 65))
    rate, hold = round(chance.uniform(0.4, 1.5), 2), round(chance.uniform(1800, 4200), -1)
    if kind == "cycle":
        return cycle(low, high, 20, rate, hold, int(chance.integers(1, 3))).of(1)
    return staircase(low, high, round(chance.uniform(12, 25)), rate, hold).of(1)


def turned(
    program: Program, kind: str, latitude_deg: float, width_dph: float, chance: np.random.Generator
) -> tuple[Program, tuple[tuple[float, float], ...]]:
    """A program with what turns the gyro, and the pieces of the rate across its axis.

    Args:
        program: of the chamber.
        kind: one of `TURNS`.
        latitude_deg: of the laboratory; the axis points up where nothing turns it.
        width_dph: of the dead band that slow rates are to show [°/h].
        chance: source of chance.

    Returns:
        The program, and (rate [°/h], seconds) of the Earth across the axis.
    """
    count = int(program.seconds // GRID_S) - 1
    up, north = earth_rate(latitude_deg, "up"), earth_rate(latitude_deg, "north")
    if kind in POSITIONS:
        ways = POSITIONS[kind]
        order = chance.permutation(np.tile(ways, count // (STAYS * len(ways)) + 1))
        tilt = np.radians(np.repeat(order, STAYS)[:count])
        along, across = up * np.cos(tilt) + north * np.sin(tilt), north * np.cos(tilt) - up * np.sin(tilt)
        return replace(program, rates=_pieces(along - up)), (*_pieces(across), (north, program.seconds))  # upright again in the end
    if kind == "constant":
        return program, ((north, program.seconds),)
    largest = 3.0 * width_dph if kind == "slow" else 10 * 3600.0
    return replace(program, rates=_pieces(chance.uniform(-largest, largest, count))), ((north, program.seconds),)


def _pieces(rates: Array) -> tuple[tuple[float, float], ...]:
    return tuple((float(rate), float(GRID_S)) for rate in rates)


def at_rows(pieces: tuple[tuple[float, float], ...], time: Array) -> Array:
    """(T,) the rate of each row from its pieces, the last of them held."""
    ends = np.cumsum([seconds for _, seconds in pieces])
    return np.array([rate for rate, _ in pieces])[np.searchsorted(ends, time, side="right").clip(max=len(pieces) - 1)]
