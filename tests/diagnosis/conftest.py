"""Two short runs of a simulated gyro, with or without something hidden; simulated and diagnosed once for all tests that look at them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache, wraps
from inspect import signature
from typing import Any, TypeVar

import pytest
import torch
from torch import Tensor

from zoo.catalog import build, names
from zoo.diagnosis.diagnose import Diagnosis, diagnose
from zoo.effects.base import Effect
from zoo.measurements.run import Run
from zoo.simulator.gyros.presets import gyro_class
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import Campaign, campaign, tour
from zoo.simulator.simulate import Simulation, simulate

Made = TypeVar("Made")

CATALOGUE: dict[str, Effect] = {name: build("effects", name) for name in names("effects")}
BASE = ("static_bias", "shupe", "mohr")
RANDOM_WALK = 0.003
WHITE_DPH = 60 * RANDOM_WALK / 10
"""White noise of a block of 100 s."""
QUIET = gyro_class("medium", random_walk=RANDOM_WALK, flicker=0.003, rate_random_walk=0.001)
PROGRAM = campaign(
    [
        tour(20, [(55, 1.0, 2400), (35, 0.5, 1200), (60, 1.5, 1800), (-10, 1.0, 2400), (10, 0.7, 1200), (-20, 2.0, 2400), (20, 1.0, 1800)], 2400),
        tour(20, [(-20, 0.7, 2400), (0, 1.5, 1200), (-30, 1.0, 1800), (50, 1.2, 2400), (25, 0.5, 1200), (45, 2.0, 1800), (20, 0.8, 1800)], 2400),
    ],
    tour(25, [(-25, 0.8, 2400), (55, 1.2, 2400), (25, 0.5, 1200)], 1800),
)


def once(make: Callable[..., Made]) -> Callable[..., Made]:
    """The same for the same arguments, said or left out: to a cache by itself `("aging")` and `("aging", 1)` are two."""
    made, declared = lru_cache(maxsize=32)(make), signature(make)

    @wraps(make)
    def of(*given: Any, **more: Any) -> Made:
        whole = declared.bind(*given, **more)
        whole.apply_defaults()
        return made(*whole.args, **whole.kwargs)

    return of


@pytest.fixture(autouse=True)
def _as_in_a_command() -> Iterator[None]:
    """In inference mode, as the commands diagnose: a tenth faster, and to the last digit the same."""
    with torch.inference_mode():
        yield


@once
def simulated(hidden: str = "", seed: int = 1, noises: float = 3.5, runs: int = 2, program: Campaign = PROGRAM, **settings: Any) -> Simulation:
    """A gyro with the three effects that every gyro has, and perhaps more, `a+b`, each of an RMS of `noises` times the white noise of a block."""
    more = {"hidden": hidden.split("+"), "amplitude": noises * WHITE_DPH} if hidden else {}
    present = {name: CATALOGUE[name] for name in BASE}
    return simulate(QUIET, program, present, catalogue=CATALOGUE, runs=runs, seed=seed, sample_s=20.0, **more, **settings)


@once
def diagnosed(hidden: str = "", seed: int = 1, noises: float = 3.5) -> Diagnosis:
    """What is said of it."""
    return diagnose([as_run(one) for one in simulated(hidden, seed, noises).runs], list(BASE), CATALOGUE)


def planted_error(recorded: list[Any], error_of: Callable[[Tensor, Tensor], Tensor], size: float) -> list[Run]:
    """Runs with an error of the true coil's temperature and its rate [K/min] added, of so large a standard deviation over all of them."""
    added = []
    for one in recorded:
        coil = one.truth["temperature_coil_c"]
        added.append(error_of(coil, torch.gradient(coil, spacing=(one.truth["time_s"] / 60,))[0]))
    scale = size / torch.cat(added).std()
    return [replace(as_run(one), error=as_run(one).error + scale * more) for one, more in zip(recorded, added, strict=True)]


@pytest.fixture
def with_error_of() -> Callable[..., list[Run]]:
    return planted_error


@pytest.fixture
def catalogue() -> dict[str, Effect]:
    return dict(CATALOGUE)


@pytest.fixture
def base() -> list[str]:
    return list(BASE)


@pytest.fixture
def white() -> float:
    return WHITE_DPH


@pytest.fixture
def simulation() -> Callable[..., Simulation]:
    return simulated


@pytest.fixture
def runs() -> Callable[..., list[Run]]:
    """The fitted runs of a simulation, as they are read from files."""
    return lambda *given, **more: [as_run(one) for one in simulated(*given, **more).runs]


@pytest.fixture
def check() -> Callable[..., list[Run]]:
    """Its check run, in a list."""
    return lambda *given, **more: [as_run(simulated(*given, **more).check)]


@pytest.fixture
def diagnosis() -> Callable[..., Diagnosis]:
    return diagnosed
