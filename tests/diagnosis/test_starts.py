"""What runs bring along that begin at other temperatures: no effect of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
import torch
from torch import Tensor

from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.measurements.run import Run
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import campaign, tour

STARTS = campaign(
    [
        tour(-35, [(10, 1.0, 2400), (-20, 0.5, 1800), (55, 1.5, 2400), (20, 0.8, 2400)], 3000),
        tour(50, [(15, 0.7, 2400), (40, 1.5, 1800), (-30, 1.0, 2400), (0, 0.5, 1800), (35, 2.0, 1800)], 3000),
    ],
    tour(20, [(-25, 0.8, 2400), (55, 1.2, 2400)], 1800),
)
"""Two runs, one from the cold and one from the heat."""


def added(recorded: list[Any], more: list[Tensor], size: float) -> list[Run]:
    """Runs with more errors (T,) of so large a standard deviation over all of them."""
    scale = size / torch.cat(more).std()
    return [replace(as_run(one), error=as_run(one).error + scale * add) for one, add in zip(recorded, more, strict=True)]


def told_of(recorded: list[Any], more: list[Tensor], size: float, base: list[str], catalogue: dict[str, Any]) -> dict[str, Any]:
    """What is said of such runs."""
    scale = size / torch.cat(more).std()
    return diagnose(
        [replace(as_run(one), error=as_run(one).error + scale * add) for one, add in zip(recorded, more, strict=True)], base, catalogue
    ).record


def relaxing(time: Tensor, celsius: Tensor, tau_h: float, decades: float, soak_h: float) -> Tensor:
    """s/τ(T) [K/min] of ds/dt = dT/dt − s/τ(T), step by step, from the strain of a jump from 20 °C that has relaxed for so long at the start."""
    faster = 10 ** (decades * (celsius - 20) / 100) / tau_h / 3600
    strain, found = float(celsius[0] - 20) * float(torch.exp(-3600 * soak_h * faster[0])), []
    for k in range(len(time)):
        if k:
            gone = float(torch.exp(-0.5 * (faster[k] + faster[k - 1]) * (time[k] - time[k - 1])))
            strain = strain * gone + float(celsius[k] - celsius[k - 1]) * gone**0.5
        found.append(60 * strain * float(faster[k]))
    return torch.tensor(found, dtype=torch.float64)


@pytest.fixture
def recorded(simulation) -> Callable[[int], list[Any]]:
    return lambda seed: simulation(seed=seed, program=STARTS).runs


@pytest.mark.parametrize("colder", [0.008, 0.0])
def test_a_warm_up_that_the_start_makes_larger_is_one_effect(colder, recorded, base, catalogue, white) -> None:
    """By how much is found as well, or that it is the same from any start."""
    runs, more = recorded(1), []
    for one in runs:
        size = 1 - colder * (float(one.truth["temperature_coil_c"][0]) - 20)
        more.append(size * (torch.exp(-one.truth["time_s"] / 1500) + 0.6 * torch.exp(-one.truth["time_s"] / 130)))
    record = told_of(runs, more, 4 * white, base, catalogue)
    assert (record["verdict"], record["missing"]) == ("missing", ["warm_up"])
    found = record["parameters"]["warm_up"]["colder"]
    assert abs(found["value"] - colder) < 3 * found["stderr"]
    assert found["stderr"] < 0.003
    assert record["rms_final"] < 1.1 * record["noise_floor"]


def drying(recorded: list[Any], modes: int) -> list[Tensor]:
    """Σ e^(−n²u) over so many odd n, going on from run to run: τ is 14 h at 20 °C, E/R 6000 K."""
    found, age = [], 0.0
    for one in recorded:
        kelvin = one.truth["temperature_coil_c"] + 273.15
        spent = age + torch.exp(6000 * (1 / 293.15 - 1 / kelvin)).cumsum(0) * 20 / (14 * 3600)
        found.append(sum((torch.exp(-((2 * m + 1) ** 2) * spent) for m in range(modes)), torch.zeros_like(spent)))
        age = float(spent[-1])
    return found


@pytest.mark.parametrize("modes", [6, 1])
def test_a_coil_that_dries_in_many_modes_is_one_effect(modes, simulation, base, catalogue, white) -> None:
    """And that there is one alone is seen as well."""
    runs = simulation(seed=2).runs
    record = told_of(runs, drying(runs, modes), 15 * white, base, catalogue)
    assert (record["verdict"], record["missing"]) == ("missing", ["moisture"])
    assert record["parameters"]["moisture"]["modes"]["value"] == (modes > 1)


def test_what_made_up_for_modes_gives_way_to_them(simulation, base, catalogue, white) -> None:
    """A model with one mode and a warm-up; without the warm-up the coil dries in all of them."""
    runs = simulation(seed=2).runs
    bench = open_bench(added(runs, drying(runs, 6), 15 * white), base, catalogue)
    start = bench.add(bench.begin(tuple(base)), "moisture")
    names, theta = (*start.names, "warm_up"), bench.add(start, "warm_up").fit.theta.clone()
    place = start.model.parameters_of_theta().index(("moisture", catalogue["moisture"].shape[3]))
    theta[place] = 0.0
    both = bench.placed(names, bench.fitted(names, [theta]))
    assert float(both.shape_of("moisture")[3]) == 0.0
    less = open_bench(added(runs, drying(runs, 6), 15 * white), base, catalogue).without(both, "warm_up")
    assert float(less.shape_of("moisture")[3]) == 1.0


@pytest.mark.parametrize("soak_h", [1.0, 1000.0])
def test_a_potting_that_has_not_relaxed_when_a_run_begins_is_one_effect(soak_h, recorded, base, catalogue, white) -> None:
    """Or one that has."""
    runs = recorded(3)
    more = [relaxing(one.truth["time_s"], one.truth["temperature_coil_c"], 3.0, 3.5, soak_h) for one in runs]
    record = told_of(runs, more, 15 * white, base, catalogue)
    assert (record["verdict"], record["missing"]) == ("missing", ["viscoelastic"])
    assert record["rms_final"] < 1.1 * record["noise_floor"]
