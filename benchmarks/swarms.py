"""Swarms over the weights of a 2-9-1 network beside pygmo, EvoX, pyswarms and mealpy: python benchmarks/swarms.py [seeds]

Equal evaluations, one core for everybody, the same network in the same precision. A peer's cost is what a good NumPy user writes (for EvoX in
torch): the population at once where the peer can take one, weights by features in one product, tanh in place, in pieces of 64 MB at most. Rows
marked * are the peer's algorithm with a cost of ours: pieces that fit the cache, for EvoX with tanh from the faster sigmoid as well.
At 36 000 samples the particle swarms stop after 15 steps of their 300, all of them, since 300 take everybody minutes a seed and a step takes as
long as any other. Ant colonies find quite different values from seed to seed, and take more seeds for that.
A quarter of an hour on a core of its own. The peers run in a temporary folder, since pyswarms leaves a file where it runs.
mealpy asks for an old NumPy and works with the new one: pip install --no-deps mealpy opfunu.
"""

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import contextlib
import logging
import sys
import tempfile
import time
from functools import partial

import numpy as np
import torch

from zoo.models.bp import BP
from zoo.swarm import aco, pheromone, pso
from zoo.training.population import Population

HIDDEN, REACH = 9, 3.0
PLAIN, PIECES = 900_000, 16_384
"""Outputs computed at once, by the plain cost and by that of the rows marked *."""
D = 4 * HIDDEN + 1
FEWER = 15
"""Steps of the particle swarms at 36 000 samples."""
WIDTHS = (9, 18, 12, 9, 9, 9, 9)


class Task:
    """Temperature and its rate of a chamber run, and a gyro's drift over them; the cost is the mean squared error in units of its variance."""

    def __init__(self, samples: int) -> None:
        time_s = torch.linspace(0, 36_000, samples, dtype=torch.float64)
        temperature = 10 + 45 * torch.sin(time_s / 4000) + 5 * torch.sin(time_s / 700)
        rate = torch.gradient(temperature, spacing=(time_s,))[0] * 60
        noise = 0.05 * torch.randn(samples, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
        drift = 0.3 * (temperature / 40) ** 3 + rate * (1 + temperature / 60) + 0.3 * torch.sin(temperature / 12) + noise
        self.model, self.features = BP(["temperature", "temperature_rate"], HIDDEN), torch.stack([temperature, rate], dim=-1)
        self.error = (drift - drift.mean()) / drift.std(correction=0)
        self.model.standardise(self.features, self.error)
        standard = ((self.features - self.features.mean(0)) / self.features.std(0, correction=0)).T.contiguous()
        self.x, self.y, self.standard = standard.numpy(), self.error.numpy(), standard

    def of_outputs(self, outputs: torch.Tensor) -> torch.Tensor:
        """(p, M) -> (p,)."""
        return torch.linalg.vector_norm(outputs.sub_(self.error), dim=-1).square_().div_(len(self.error))

    def numpy_costs(self, weights: np.ndarray, at_once: int = PLAIN) -> np.ndarray:
        """(P, D) -> (P,)."""
        few = max(at_once // len(self.y), 1)
        if few >= len(weights):
            return self._numpy_costs(weights)
        return np.concatenate([self._numpy_costs(weights[i : i + few]) for i in range(0, len(weights), few)])

    def _numpy_costs(self, w: np.ndarray) -> np.ndarray:
        p, h, m = len(w), HIDDEN, len(self.y)
        nodes = (w[:, : 2 * h].reshape(-1, 2) @ self.x).reshape(p, h, m)
        nodes += w[:, 2 * h : 3 * h, None]
        np.tanh(nodes, out=nodes)
        left = (w[:, None, 3 * h : 4 * h] @ nodes)[:, 0]
        left += w[:, 4 * h :]
        left -= self.y
        return np.einsum("pm,pm->p", left, left) / m

    def torch_costs(self, weights: torch.Tensor, at_once: int = PLAIN) -> torch.Tensor:
        """(P, D) -> (P,)."""
        return torch.cat([self._torch_costs(w, at_once == PIECES) for w in weights.split(max(at_once // len(self.y), 1))])

    def _torch_costs(self, w: torch.Tensor, by_sigmoid: bool) -> torch.Tensor:
        p, h = len(w), HIDDEN
        nodes = torch.addmm(w[:, 2 * h : 3 * h].reshape(-1, 1), w[:, : 2 * h].reshape(-1, 2), self.standard)
        nodes = (nodes.mul_(2).sigmoid_().mul_(2).sub_(1) if by_sigmoid else nodes.tanh_()).view(p, h, -1)
        return torch.baddbmm(w[:, 4 * h :, None], w[:, None, 3 * h : 4 * h], nodes)[:, 0].sub_(self.error).square_().mean(-1)


def ours(algorithm, task, particles, steps, seed):
    chance, population = torch.Generator().manual_seed(seed), Population(task.model, task.features)
    edge = torch.full((D,), REACH, dtype=torch.float64)
    state = algorithm.init(-edge, edge, particles, chance, steps=steps)
    for _ in range(steps):
        state = algorithm.tell(state, population.costs(algorithm.ask(state), task.of_outputs), chance)
    return float(state.leader_cost)


def ours_at_once(algorithm, task, particles, steps, seeds):
    """Each seed's colony takes the path that it takes alone."""
    chance, population = [torch.Generator().manual_seed(seed) for seed in range(1, seeds + 1)], Population(task.model, task.features)
    edge = torch.full((seeds, D), REACH, dtype=torch.float64)
    state = algorithm.init(-edge, edge, particles, chance, steps=steps)
    for _ in range(steps):
        costs = population.costs(algorithm.ask(state).flatten(0, 1), task.of_outputs)
        state = algorithm.tell(state, costs.view(seeds, particles), chance)
    return state.leader_cost


def of_pygmo(name, batch, at_once=PLAIN):
    import pygmo

    def run(task, particles, steps, seed):
        class Problem:
            def fitness(self, w):
                return task.numpy_costs(w[None])

            def batch_fitness(self, w):
                return task.numpy_costs(w.reshape(-1, D), at_once)

            def get_bounds(self):
                return [-REACH] * D, [REACH] * D

        extra = {"ker": particles} if name == "gaco" else {}
        chosen = getattr(pygmo, name)(gen=steps - 1, seed=seed, **extra)
        if batch:
            chosen.set_bfe(pygmo.bfe())
        return float(pygmo.algorithm(chosen).evolve(pygmo.population(Problem(), particles, seed=seed)).champion_f[0])

    return run


def of_evox(at_once=PLAIN):
    from evox.algorithms import PSO
    from evox.core import Problem
    from evox.workflows import EvalMonitor, StdWorkflow

    def run(task, particles, steps, seed):
        class Cost(Problem):
            def evaluate(self, pop):
                return task.torch_costs(pop, at_once)

        torch.manual_seed(seed)
        torch.set_default_dtype(torch.float64)
        edge, monitor = torch.full((D,), REACH), EvalMonitor()
        workflow = StdWorkflow(PSO(particles, -edge, edge), Cost(), monitor)
        workflow.init_step()
        for _ in range(steps - 1):
            workflow.step()
        torch.set_default_dtype(torch.float32)
        return float(monitor.get_best_fitness())

    return run


def of_pyswarms(at_once=PLAIN):
    import pyswarms

    logging.disable(logging.INFO)

    def run(task, particles, steps, seed):
        np.random.seed(seed)  # noqa: NPY002  it has no other source of chance
        bounds, options = (np.full(D, -REACH), np.full(D, REACH)), {"c1": 1.49445, "c2": 1.49445, "w": 0.729}
        return pyswarms.single.GlobalBestPSO(particles, D, options, bounds=bounds).optimize(
            partial(task.numpy_costs, at_once=at_once), steps, verbose=False
        )[0]

    return run


def of_mealpy(kind):
    import mealpy

    def run(task, particles, steps, seed):
        problem = {"bounds": mealpy.FloatVar([-REACH] * D, [REACH] * D), "minmax": "min", "log_to": None}
        problem["obj_func"] = lambda w: float(task.numpy_costs(w[None])[0])
        if kind == "PSO":
            chosen = mealpy.PSO.OriginalPSO(epoch=steps - 1, pop_size=particles)
        else:
            chosen = mealpy.ACOR.OriginalACOR(epoch=steps - 50 // particles, pop_size=50, sample_count=particles)
        return chosen.solve(problem, seed=seed).target.fitness

    return run


SWARMS = {
    "pygmo pso": lambda: of_pygmo("pso", False),
    "pygmo pso_gen, batch": lambda: of_pygmo("pso_gen", True),
    "pygmo pso_gen, batch *": lambda: of_pygmo("pso_gen", True, PIECES),
    "EvoX PSO": of_evox,
    "EvoX PSO *": lambda: of_evox(PIECES),
    "pyswarms": of_pyswarms,
    "pyswarms *": lambda: of_pyswarms(PIECES),
    "mealpy PSO": lambda: of_mealpy("PSO"),
}
COLONIES = {
    "pygmo gaco": lambda: of_pygmo("gaco", False),
    "pygmo gaco, batch": lambda: of_pygmo("gaco", True),
    "pygmo gaco, batch *": lambda: of_pygmo("gaco", True, PIECES),
    "mealpy ACOR": lambda: of_mealpy("ACOR"),
}


def made(peers):
    """Those that are installed; the others are named."""
    found = {}
    for name, make in peers.items():
        try:
            found[name] = make()
        except ImportError as missing:
            print(f"  {name}: not installed ({missing})")
    return found


def table(title, own, peers, task, particles, steps, seeds):
    """Medians of the best value and of the seconds. All take their turn seed by seed, so that whatever else runs slows everybody."""
    print(f"\n{title}", flush=True)
    runs = {name: partial(ours, algorithm) for name, algorithm in own.items()} | made(peers)
    taken = {name: [] for name in runs}
    for run in runs.values():
        run(task, particles, 10 if particles < 50 else 3, 999)  # not counted
    for seed in range(1, seeds + 1):
        for name, run in runs.items():
            cpu, wall = time.process_time(), time.perf_counter()
            best = run(task, particles, steps, seed)
            taken[name].append((best, time.process_time() - cpu, time.perf_counter() - wall))
    report({name: np.array(rows).T for name, rows in taken.items()}, seeds)


def at_once(task, particles, steps, seeds):
    """What a seed takes where many run side by side, as they do in a training: calling an operation takes longer than ten ants' arithmetic."""
    single, joint = [], []
    for seed in range(1, 6):
        start = time.process_time()
        ours(aco, task, particles, steps, seed)
        middle = time.process_time()
        ours_at_once(aco, task, particles, steps, seeds)
        single.append(middle - start)
        joint.append((time.process_time() - middle) / seeds)
    print(
        f"  fogzoo ACO_R, {seeds} seeds at once: {np.median(joint):.3f} s a seed, {np.median(joint) / np.median(single):.2f} of one alone", flush=True
    )


def report(taken, seeds):
    """One line each; `ours lower` is how often, of all pairs of seeds, our first algorithm's best value is below this one's."""
    reference, *_ = taken.values()
    head = ("best", "quartiles", "ours lower", "CPU s", "of ours", "wall s", "of ours")
    print(f"  {f'median of {seeds} seeds':24s}" + "".join(f"{word:>{width}s}" for word, width in zip(head, WIDTHS, strict=True)))
    for name, row in taken.items():
        best, cpu, wall = np.median(row, axis=1)
        least, most = np.percentile(row[0], [25, 75])
        lower = "" if row is reference else f"{100 * np.mean(reference[0][:, None] < row[0]):.0f} %"
        ratios = (np.median(row[i]) / np.median(reference[i]) for i in (1, 2))
        cells = (f"{best:.4f}", f"{least:.4f} … {most:.4f}", lower, f"{cpu:.3f}", f"{next(ratios):.2f}", f"{wall:.3f}", f"{next(ratios):.2f}")
        print(f"  {name:24s}" + "".join(f"{cell:>{width}s}" for cell, width in zip(cells, WIDTHS, strict=True)), flush=True)


def one_core() -> None:
    """A second thread of a peer's, waiting busily for work that does not come, would count as CPU time and not by the clock."""
    torch.set_num_threads(1)
    if hasattr(os, "sched_setaffinity"):  # Linux
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def main() -> None:
    one_core()
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    colonies = {"fogzoo ACO_R": aco, "fogzoo pheromone": pheromone}
    small, large = Task(350), Task(36_000)
    with tempfile.TemporaryDirectory() as own, contextlib.chdir(own):
        table("350 samples, 400 particles, 300 steps", {"fogzoo PSO": pso}, SWARMS, small, 400, 300, seeds)
        table("350 samples, 10 ants, 300 steps", colonies, COLONIES, small, 10, 300, 5 * seeds)
        at_once(small, 10, 300, 5 * seeds)
        fewer = f"36 000 samples, 400 particles, {FEWER} steps of 300 for all: 300 take each of them minutes a seed"
        table(fewer, {"fogzoo PSO": pso}, SWARMS, large, 400, FEWER, seeds)
        table("36 000 samples, 10 ants, 300 steps", colonies, COLONIES, large, 10, 300, 2 * seeds)


if __name__ == "__main__":
    main()
