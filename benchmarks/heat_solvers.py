"""Heat in a winding of 36 layers for 13 h at 1 s: our modes beside SciPy, Crank–Nicolson, FiPy and py-pde; one device, then a thousand.

python benchmarks/heat_solvers.py 1000         how many devices
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import torch
from heat.crank_nicolson import compiled, propagated, tridiagonal
from heat.exact import exact
from heat.ours import ours
from heat.problem import CONDUCTIVITY, CONTACT, Body, air, all_layers, body, mean_and_shupe
from heat.scipy_ivp import lsoda, lsoda_ivp, lsoda_stacked, radau
from heat.with_fipy import fipy
from heat.with_py_pde import py_pde

RAMP = slice(3600, 5101)
"""The first ramp begins: what FiPy and py-pde are run on."""
AT_ONCE, SINGLY = 40, 15
"""Devices that ours takes at once where only a part of the answer is kept; those that the others are timed on."""
NODAL = {
    "LSODA 1e-6, odeint": lsoda,
    "LSODA 1e-8, odeint": partial(lsoda, tolerance=1e-8),
    "LSODA 1e-6, solve_ivp": lsoda_ivp,
    "Radau 1e-6, solve_ivp": radau,
    "Crank-Nicolson 1 s, NumPy": propagated,
    "Crank-Nicolson 1 s, LAPACK": tridiagonal,
    "Crank-Nicolson 1 s, Numba": compiled,
}
IN_BATCH = ("LSODA 1e-6, odeint", "LSODA 1e-8, odeint", "LSODA 1e-6, solve_ivp", "Crank-Nicolson 1 s, Numba")
OWN_CELLS = {"FiPy, backward Euler 1 s *": fipy, "py-pde, LSODA 1e-6 *": py_pde}


def milliseconds(work: Callable[[], object], times: int) -> float:
    """Median wall time, after one run that does not count."""
    taken = []
    for _ in range(times + 1):
        started = time.perf_counter()
        work()
        taken.append(1000 * (time.perf_counter() - started))
    return float(np.median(taken[1:]))


def largest(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.abs(found - expected).max())


def line(name: str, *cells: object) -> None:
    """A row of a table; times and ratios to three digits, errors to two."""
    print(f"{name:28s}" + "".join(f"{cell if isinstance(cell, str) else f'{cell:.3g}':>11s}" for cell in cells), flush=True)


def one_device(driving: np.ndarray) -> None:
    """The temperatures of all layers, then only the fibre's mean temperature and Shupe's error; the errors of both."""
    coil, fine = body(), body(cuts=8)
    layers, asked, reference = all_layers(coil), mean_and_shupe(coil), exact(fine, driving)
    truth, in_time = reference[:, fine.layers], exact(coil, driving)[:, coil.layers]
    expected = mean_and_shupe(fine).seen(fine, driving, reference)
    peak = np.abs(expected[:, 1]).max()
    print(f"One device, one core, {len(driving) - 1} s. The largest error anywhere: of a layer, against the exact solution on its own cells")
    print(f"(in time) and on 8 times finer ones (in all); of the mean temperature; of Shupe's error in shares of its peak, {peak:.2g} °/h")
    line("", "36 layers", "", "mean,Shupe", "", "in time", "in all", "mean", "Shupe")
    line("", "ms", "x ours", "ms", "x ours", "K", "K", "K", "1")
    layers_ms, asked_ms = (milliseconds(lambda wanted=wanted: ours(coil, driving, wanted), 9) for wanted in (layers, asked))

    def errors(nodes: np.ndarray, seen: np.ndarray) -> Iterator[str]:
        sizes = (largest(nodes, in_time), largest(nodes, truth), largest(seen[:, 0], expected[:, 0]), largest(seen[:, 1], expected[:, 1]) / peak)
        return (f"{size:.1e}" for size in sizes)

    line("ours", layers_ms, 1.0, asked_ms, 1.0, *errors(ours(coil, driving, layers).numpy().T, ours(coil, driving, asked).numpy().T))
    for name, solve in NODAL.items():
        nodes = solve(coil, driving)
        solved_ms = milliseconds(lambda solve=solve: solve(coil, driving), 5)
        seen_ms = solved_ms + milliseconds(lambda nodes=nodes: asked.seen(coil, driving, nodes), 5)
        line(name, solved_ms, solved_ms / layers_ms, seen_ms, seen_ms / asked_ms, *errors(nodes[:, coil.layers], asked.seen(coil, driving, nodes)))
    for name, prepared in OWN_CELLS.items():
        run = prepared(driving[RAMP])
        run(5)  # compiles
        started = time.perf_counter()
        nodes = run(RAMP.stop - RAMP.start - 1)
        scaled_ms = 1000 * (time.perf_counter() - started) * len(driving) / len(nodes)
        line(name, scaled_ms, scaled_ms / layers_ms, "", "", "", f"{largest(nodes, truth[RAMP]):.1e}")
    print(f"* 36 cells of its own, one run of {RAMP.stop - RAMP.start - 1} s where the first ramp begins, its time scaled to {len(driving) - 1} s")


def drawn(devices: int) -> Body:
    """Coils whose conductivity and contact differ a little."""
    chance = np.random.default_rng(1)
    return body(CONDUCTIVITY * chance.uniform(0.9, 1.1, devices), CONTACT * chance.uniform(0.7, 1.3, devices))


def device_ms(devices: int, driving: np.ndarray, cores: int = 1, at_once: int = 1000, times: int = 3) -> float:
    """Mean and Shupe from the parameters on, so many devices at once, the answers of those before thrown away; for each device."""

    def work() -> None:
        whole, asked = drawn(devices), mean_and_shupe(body())
        for first in range(0, devices, at_once):
            ours(whole[first : first + at_once], driving, asked)

    torch.set_num_threads(cores)
    taken = milliseconds(work, times)
    torch.set_num_threads(1)
    return taken / devices


def many_devices(devices: int, driving: np.ndarray) -> None:
    """A batch at once, or one device after another."""
    print(f"\n{devices} devices that differ, mean temperature and Shupe's error; the others' times are the median of {SINGLY} devices, or of runs")
    line("", "ms/device", "x 2 cores", "x 1 core")
    two_ms, one_ms = (device_ms(devices, driving, cores, AT_ONCE) for cores in (2, 1))

    def row(name: str, taken_ms: float) -> None:
        line(name, taken_ms, taken_ms / two_ms, taken_ms / one_ms)

    row(f"ours, {AT_ONCE} at once, 2 cores", two_ms)
    row(f"ours, {AT_ONCE} at once", one_ms)
    row(f"ours, {devices} at once, 2 cores", device_ms(devices, driving, 2, devices))
    row(f"ours, {devices} at once", device_ms(devices, driving, 1, devices))
    asked, singly = mean_and_shupe(body()), drawn(SINGLY)
    for name in IN_BATCH:
        works = [partial(lambda coil, solve: asked.seen(coil, driving, solve(coil, driving)), singly[place], NODAL[name]) for place in range(SINGLY)]
        row(name, float(np.median([milliseconds(work, 1) for work in works])))
    row(f"LSODA 1e-6, {AT_ONCE} stacked", milliseconds(lambda: lsoda_stacked(drawn(AT_ONCE), driving, asked), 3) / AT_ONCE)
    answer, peak = devices * 2 * len(driving) * 8 / 1e6, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"memory: the answer for {devices} at once {answer:.0f} MB, the whole process at most {peak:.0f} MB")


def growth(devices: int, driving: np.ndarray) -> None:
    """Exponents of a power law through four sizes."""
    batches = [max(1, devices * share // 10) for share in (1, 2, 5, 10)]
    lengths = [len(driving) // share for share in (8, 4, 2, 1)]
    by_devices = [count * device_ms(count, driving, at_once=count) for count in batches]
    by_samples = [batches[0] * device_ms(batches[0], driving[:length], at_once=batches[0], times=7) for length in lengths]
    print("\nours, 1 core")
    for what, sizes, taken in (("devices", batches, by_devices), ("samples", lengths, by_samples)):
        exponent = np.polyfit(np.log(sizes), np.log(taken), 1)[0]
        print(f"time grows as {what}^{exponent:.2f}: {', '.join(f'{ms:.0f} ms for {size}' for size, ms in zip(sizes, taken, strict=True))}")


def main(devices: int) -> None:
    torch.set_num_threads(1)
    driving = air()
    with torch.no_grad():
        one_device(driving)
        many_devices(devices, driving)
        growth(devices, driving)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
