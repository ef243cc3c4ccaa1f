"""Training against itself: python benchmarks/training.py [ensemble|lightning|steps …]; all parts without an argument.

ensemble    100 seeds of a PSO-started network as one batch, against single trainings one after another
lightning   zoo.training.train, and a Trainer as Lightning sets it by default, against a raw loop of the same steps
steps       Levenberg–Marquardt against L-BFGS: time until the loss that L-BFGS ends with

Ratios come from one run on one thread, as medians over repeats that take turns: of wall time, and of CPU time, which does not count what others do
on the machine.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import torch
from lightning.pytorch import Trainer
from torch.utils.data import DataLoader, TensorDataset

from zoo.measurements.run import Run
from zoo.models.bp import BP
from zoo.training.levenberg_marquardt import LevenbergMarquardt
from zoo.training.module import Training
from zoo.training.problem import Problem
from zoo.training.quiet import quiet_lightning
from zoo.training.run import train
from zoo.training.swarm_init import SwarmInit
from zoo.training.weights import reset

FEATURES = ["temperature", "temperature_rate"]
ADAM = partial(torch.optim.Adam, lr=0.01)
LBFGS = partial(torch.optim.LBFGS, lr=1.0, max_iter=20, history_size=10, tolerance_grad=1e-9, line_search_fn="strong_wolfe")
"""As conf/optimizer/lbfgs.yaml."""
SEEDS, SINGLES, EPOCHS = 100, 5, 1000


def one_run(blocks: int, noise: float = 0.02) -> Run:
    """A chamber run of so many blocks: a curved static error, a term of the rate, noise."""
    time_s = 50.0 + 100.0 * torch.arange(blocks, dtype=torch.float64)
    phase = 2 * torch.pi * time_s / time_s[-1]
    temperature = 20 + 40 * torch.sin(3 * phase) * torch.sin(phase)
    white = noise * torch.randn(blocks, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    error = torch.tanh((temperature - 30) / 15) + 0.2 * torch.sin(temperature / 8) + 0.1 * torch.cos(3 * phase) + white
    table = torch.stack([time_s, temperature, 0 * temperature], dim=-1)
    return Run("run", "dph", 100.0, ("time_s", "temperature_c", "reference_dph"), table, error, 1 + 0 * time_s, torch.arange(blocks))


def seconds(work: Callable[[], object]) -> torch.Tensor:
    """(2,) wall and CPU."""
    started = time.perf_counter(), time.process_time()
    work()
    return torch.tensor([time.perf_counter() - started[0], time.process_time() - started[1]])


def ratio(one: list[torch.Tensor], other: list[torch.Tensor], factor: float = 1.0) -> str:
    """Of medians."""
    wall, cpu = (factor * torch.stack(one).median(0).values / torch.stack(other).median(0).values).tolist()
    return f"{wall:.2f} x by the clock, {cpu:.2f} x in CPU time"


def told(times: list[torch.Tensor]) -> str:
    wall, cpu = torch.stack(times).median(0).values.tolist()
    return f"{wall:.2f} s, {cpu:.2f} s CPU"


def pso(seed: int) -> SwarmInit:
    """As conf/init/pso.yaml."""
    from zoo.swarm import pso as algorithm

    return SwarmInit(algorithm, particles=30, steps=100, seed=seed)


def ensemble(out: Path) -> None:
    run = one_run(350)
    train(BP(FEATURES), [run], optimizer=ADAM, init=pso(1), epochs=20, out=out)
    singles, together = [], []
    for k in range(SINGLES):
        singles.append(seconds(lambda: train(BP(FEATURES), [run], optimizer=ADAM, init=pso(1 + k), seed=1 + k, epochs=EPOCHS, out=out)))  # noqa: B023
        if k % 2 == 0:
            together.append(seconds(lambda: train(BP(FEATURES), [run], optimizer=ADAM, init=pso(1), seeds=SEEDS, epochs=EPOCHS, out=out)))
    print(f"one PSO-BP (350 blocks, PSO 30 x 100, {EPOCHS} epochs): {told(singles)};  {SEEDS} seeds as one batch: {told(together)}")
    print(f"  as one batch {SEEDS} seeds are faster than alone: {ratio(singles, together, SEEDS)} (goal: 20)", flush=True)


def raw(run: Run, epochs: int) -> None:
    model = BP(FEATURES)
    problem = Problem.of_runs(model, [run])
    reset(model, torch.Generator().manual_seed(1))
    optimizer = ADAM(model.parameters())
    for _ in range(epochs):
        optimizer.zero_grad()
        ((model.head(problem.features) - problem.error) / problem.scale).square().mean().backward()
        optimizer.step()


def defaults(run: Run, epochs: int, out: Path) -> None:
    """As one would train with Lightning who knows nothing of whole runs in memory."""
    model = BP(FEATURES)
    problem = Problem.of_runs(model, [run])
    reset(model, torch.Generator().manual_seed(1))
    loader = DataLoader(TensorDataset(problem.features, problem.error), batch_size=len(problem.error))
    with quiet_lightning():
        Trainer(max_epochs=epochs, accelerator="cpu", default_root_dir=out).fit(Training(model, ADAM, float(problem.scale)), loader)


def lightning(out: Path) -> None:
    run = one_run(350)
    ours, bare = [], []
    for _ in range(5):
        ours.append(seconds(lambda: train(BP(FEATURES), [run], optimizer=ADAM, epochs=EPOCHS, out=out)))
        bare.append(seconds(lambda: raw(run, EPOCHS)))
    usual = [seconds(lambda: defaults(run, EPOCHS, out))]
    print(f"{EPOCHS} epochs of 350 blocks: train {told(ours)}; raw loop {told(bare)}; Lightning at its defaults {told(usual)}")
    print(f"  Lightning over a raw loop: {ratio(ours, bare)} (goal: 2.5); at its defaults {ratio(usual, bare)}", flush=True)


def steps(out: Path) -> None:
    for blocks, passes in ((350, 50), (36_000, 50)):
        run, theirs, ours, ends = one_run(blocks), [], [], []
        for seed in range(1, 8 if blocks < 1000 else 4):
            theirs.append(seconds(lambda: ends.append(train(BP(FEATURES), [run], optimizer=LBFGS, seed=seed, epochs=passes, out=out))))  # noqa: B023
        goal = sorted(one["loss"] for one in ends)[len(ends) // 2]
        for seed in range(1, len(ends) + 1):
            method = LevenbergMarquardt(settled=0.0)
            found: list[dict[str, Any]] = []
            work = partial(train, BP(FEATURES), [run], optimizer=method, seed=seed, epochs=200, goal=goal * (1 + 1e-9), out=out)
            ours.append(seconds(lambda: found.append(work())))  # noqa: B023
            ends[seed - 1] |= {"reached": found[0]["loss"], "steps": found[0]["epochs"]}
        reached = sum(one["reached"] <= goal * (1 + 1e-9) for one in ends)
        print(f"{blocks} blocks, {passes} epochs of L-BFGS: {told(theirs)}, median loss {goal:.5g}; LM until there, 200 steps at most: {told(ours)}")
        print(
            f"  {reached} of {len(ends)} seeds reach it, in {[one['steps'] for one in ends]} steps; L-BFGS takes {ratio(theirs, ours)} (goal: 2)",
            flush=True,
        )


PARTS = {"ensemble": ensemble, "lightning": lightning, "steps": steps}


def main(parts: list[str]) -> None:
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as name:
        for part in parts or list(PARTS):
            PARTS[part](Path(name))


if __name__ == "__main__":
    main(sys.argv[1:])
