"""A fleet of gyros with all effects and noise, 14 h at 0.1 Hz, and one gyro with a temperature for each turn.

python benchmarks/fleet.py 1000        how many gyros (default 1000)
"""

from __future__ import annotations

import resource
import sys
import time

import numpy as np
import torch

from zoo.catalog import build, names
from zoo.simulator.gyros.classes import MEDIUM
from zoo.simulator.gyros.device import draw
from zoo.simulator.gyros.gyro_class import changed
from zoo.simulator.simulate import fleet
from zoo.simulator.thermal.heat import heat

LATITUDE = {"reference_dph": 9.67, "runs": 1}
HOURS_14 = 50_400


def seconds(devices: int, sample_s: float = 10.0, torch_device: str = "cpu") -> float:
    """For one run and one check run each, on their way to the files."""
    effects = {name: build("effects", name) for name in names("effects")}
    started = time.perf_counter()
    made = fleet(
        MEDIUM,
        build("profile", "qiu2023"),
        effects,
        build("noise", "gyro"),
        devices=devices,
        sample_s=sample_s,
        torch_device=torch_device,
        **LATITUDE,
    )
    rows = sum(len(run.table["rate_dph"]) for one in made for run in (*one.runs, one.check))
    taken = time.perf_counter() - started
    print(f"{devices:5d} gyros, {rows:9d} rows of 14.3 h runs in two each: {taken:6.1f} s, {1e3 * taken / devices:5.1f} ms a gyro", flush=True)
    return taken


def line(what: str, sizes: list[float], taken: list[float]) -> None:
    """Time as a straight line in size, weighted by relative errors."""
    slope, fixed = np.polyfit(sizes, taken, 1, w=1 / np.array(taken))
    off = np.abs((fixed + slope * np.array(sizes)) / taken - 1).max()
    print(f"time is {fixed:.2f} s + {slope:.2e} s a {what}; no more than {100 * off:.0f} % off that line")


def turn_by_turn() -> None:
    """36 layers of 48 turns, 14 h in steps of 1 s."""
    device = draw(changed(MEDIUM, layers=36, turns=48), 1)
    at = torch.arange(HOURS_14, dtype=torch.float64)
    air = 20 + (at - 3600).clamp(0, 6000) / 60
    taken = []
    for _ in range(5):
        started = time.perf_counter()
        heat([device], at, air, fidelity="radial_axial")
        taken.append(time.perf_counter() - started)
    print(f"radial-axial, 36 x 48 turns, {HOURS_14} steps: {np.median(taken):.2f} s (median of 5)")


def main(devices: int) -> None:
    torch.set_num_threads(1)  # as `fogzoo simulate` does; two gain nothing, and lose much on a busy machine
    turn_by_turn()
    some = [max(1, devices // share) for share in (10, 5, 2)]
    line("gyro", [*some, devices], [*(seconds(count) for count in some), seconds(devices)])
    steps = [40.0, 20.0, 10.0, 5.0]
    line("row", [2 * some[0] * 51_600 / step for step in steps], [seconds(some[0], step) for step in steps])
    if torch.cuda.is_available():
        seconds(some[0], torch_device="cuda")
        seconds(devices, torch_device="cuda")
    print(f"memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB at most")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
