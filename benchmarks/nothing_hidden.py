"""How often the diagnosis cries wolf: simulated gyros with nothing hidden, each with its own coil, package, thermometers and noise.

python benchmarks/nothing_hidden.py 200        how many gyros (default 20)
"""

from __future__ import annotations

import sys
import time

import torch

from zoo.catalog import build, names
from zoo.diagnosis.diagnose import diagnose
from zoo.simulator.gyros.presets import MEDIUM, TACTICAL
from zoo.simulator.in_process import as_run
from zoo.simulator.simulate import simulate

BASE = ["static_bias", "shupe", "mohr"]


def main(gyros: int) -> None:
    torch.set_num_threads(1)
    catalogue = {name: build("effects", name) for name in names("effects")}
    verdicts: dict[str, int] = {}
    started = time.process_time()
    for seed in range(gyros):
        kind = MEDIUM if seed % 2 == 0 else TACTICAL
        effects = {name: build("effects", name) for name in BASE}
        simulated = simulate(kind, build("profile", "campaign"), effects, build("noise", "gyro"), catalogue=catalogue, runs=3, seed=seed)
        found = diagnose([as_run(run) for run in simulated.runs], BASE, catalogue)
        verdicts[found.verdict] = verdicts.get(found.verdict, 0) + 1
        if found.verdict != "complete":
            print(f"seed {seed} ({kind.name}): {found.verdict} {found.record['missing']} {found.record['unexplained']}", flush=True)
    print(f"{gyros} gyros with nothing hidden: {verdicts}, {(time.process_time() - started) / gyros:.1f} s of CPU each")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
