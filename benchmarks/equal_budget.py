"""Is a swarm's start worth its evaluations?  python benchmarks/equal_budget.py [SEEDS]        default 100

The network of qiu2023 (9 nodes, temperature and its rate) on the paper's runs as simulated here, trained on the first and judged on the two others,
by Adam, Levenberg–Marquardt and L-BFGS: from an ant colony's or a particle swarm's best place, and, for as many evaluations, from random places of
which the best of the fitted run is kept, or from one random place for longer. An evaluation without slopes counts 1, one with slopes or a Jacobian 3
(a backward pass takes twice a forward one). The swarms have the settings of conf/init. L-BFGS trains one seed after another and takes longest.

Found with 100 seeds, by medians on the unseen runs: a swarm's start hardly matters. It leaves 1 % less than restarts for as many evaluations under
Adam, as much under L-BFGS, 3 % more under Levenberg–Marquardt, which ends in good places and in bad ones from any start. A quarter of an hour on a
core of its own.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import hydra
import torch
from torch import Generator

from zoo.catalog import config_folder, create, load
from zoo.cli.inputs import read_data
from zoo.measurements.run import Run
from zoo.models.bp import BP
from zoo.scoring.seeds import Spread, contest, spread
from zoo.training.levenberg_marquardt import LevenbergMarquardt
from zoo.training.random_init import RandomInit
from zoo.training.run import train

FEATURES = ["temperature", "temperature_rate"]
SWARMS = {"ACO": "aco_pheromone", "ACO_R": "aco", "PSO": "pso"}
SLOPES = 3
"""Price of an evaluation with its slopes."""
FIRST = 1
Values = dict[int, float]


@dataclass(frozen=True)
class Optimizer:
    """One way down.

    Attributes:
        name: of it.
        make: as `train` takes it.
        epochs: passes of a training.
        price: of a training, in evaluations without slopes.
    """

    name: str
    make: Any
    epochs: int
    price: int


OPTIMIZERS = (
    Optimizer("Adam", partial(torch.optim.Adam, lr=0.01), 1000, 1000 * SLOPES),
    Optimizer("Levenberg–Marquardt", LevenbergMarquardt(), 100, 100 * (SLOPES + 3)),  # three dampings are tried in a step
    Optimizer(
        "L-BFGS",
        partial(torch.optim.LBFGS, lr=1.0, max_iter=20, history_size=10, tolerance_grad=1e-9, line_search_fn="strong_wolfe"),
        25,
        25 * 20 * SLOPES,
    ),
)


def fitted(runs: list[Run], checks: list[Run], one: Optimizer, init: Any, seeds: int, epochs: int) -> tuple[Values, Values]:
    """RMS of the fitted run and of the others, by seed."""
    with tempfile.TemporaryDirectory() as out:
        found = train(BP(FEATURES), runs, checks, optimizer=one.make, init=init, epochs=epochs, seed=FIRST, seeds=seeds, out=Path(out))["members"]
    return dict(zip(found["seeds"], found["rms"], strict=True)), dict(zip(found["seeds"], found["rms_check"], strict=True))


def restarted(fit: Values, check: Values, restarts: int) -> tuple[Values, Values]:
    """The best of every so many seeds, as the fitted run tells it."""
    kept: dict[int, int] = {}
    for seed in sorted(fit, key=fit.__getitem__):
        kept.setdefault(FIRST + (seed - FIRST) // restarts, seed)
    return {group: fit[seed] for group, seed in kept.items()}, {group: check[seed] for group, seed in kept.items()}


def compare(runs: list[Run], checks: list[Run], one: Optimizer, seeds: int) -> None:
    run = partial(fitted, runs, checks, one)
    found: dict[str, tuple[Values, Values]] = {}
    most = 0
    for name, config in SWARMS.items():
        settings = load("init", config)
        init = create(settings, seed=FIRST)
        found[f"{name} start"] = run(init, seeds, one.epochs)
        most = max(most, settings.particles * settings.steps)
    budget = most + one.price
    restarts = -(-budget // one.price)
    print(f"\n{one.name}: {budget} evaluations; {restarts} trainings from random places, or one of {one.epochs * budget // one.price} epochs")
    found["random start"] = run(RandomInit(FIRST), seeds, one.epochs)
    every = run(RandomInit(FIRST), seeds * restarts, one.epochs)
    found[f"best of {restarts} random starts"] = restarted(*every, restarts)
    found["random start, longer"] = run(RandomInit(FIRST), seeds, one.epochs * budget // one.price)
    chance, rival = Generator().manual_seed(1), found[f"best of {restarts} random starts"][1]
    for name, (fit, check) in found.items():
        here, there = (spread(torch.tensor(list(values.values()), dtype=torch.float64), chance) for values in (fit, check))
        against = contest(check, rival, chance)
        interval = "" if against.interval is None else f" ({against.interval[0]:.3f} … {against.interval[1]:.3f})"
        print(f"  {name:26s} fitted {told(here)}  unseen {told(there)}  over restarts {against.ratio:.3f}{interval}", flush=True)


def told(one: Spread) -> str:
    return f"{one.median:.5f} ({one.low:.5f} … {one.high:.5f})"


def main(seeds: int) -> None:
    torch.set_num_threads(1)
    with hydra.initialize_config_dir(str(config_folder()), version_base=None):
        runs, checks = read_data(hydra.compose("train", ["data=qiu2023"]))
    print(f"RMS [°/h] over {seeds} seeds: median (90 % range); and the median's ratio on unseen runs to that of restarts (95 % interval)")
    for one in OPTIMIZERS:
        compare(runs, checks, one, seeds)


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else 100)
