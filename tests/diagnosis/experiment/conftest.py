"""One run of a gyro at one attitude, whose fixture turns as it warms; Mohr's effect looks the same there."""

from __future__ import annotations

from functools import cache

import pytest

from zoo.catalog import build, names
from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.effects.base import Effect
from zoo.simulator.gyros.presets import gyro_class
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import cycle
from zoo.simulator.simulate import Simulation, simulate

CATALOGUE: dict[str, Effect] = {name: build("effects", name) for name in names("effects")}
BASE, HIDDEN = ("static_bias", "shupe"), "fixture_rotation"
QUIET = gyro_class("medium", random_walk=0.003, flicker=0.003, rate_random_walk=0.001)
CYCLE = cycle(-40.0, 60.0, 20.0, 1.0, 3600.0)
EARTH_DPH = 10.0


@cache
def simulated(thermometers: int = 2) -> Simulation:
    effects = {name: CATALOGUE[name] for name in BASE}
    settings = {"runs": 1, "seed": 4, "reference_dph": EARTH_DPH, "sample_s": 20.0, "amplitude": 0.3, "thermometers": thermometers}
    return simulate(QUIET, CYCLE, effects, hidden=[HIDDEN], catalogue=CATALOGUE, **settings)


@cache
def opened() -> tuple[Workbench, list[Solved]]:
    bench = open_bench([as_run(run) for run in simulated().runs], list(BASE), CATALOGUE)
    before = bench.solve(BASE)
    return bench, [bench.add(before, name) for name in (HIDDEN, "mohr")]


@pytest.fixture
def simulation() -> Simulation:
    return simulated()


@pytest.fixture
def bench() -> Workbench:
    return opened()[0]


@pytest.fixture
def rivals() -> list[Solved]:
    """What the fixture does, and Mohr's effect in its place."""
    return list(opened()[1])
