"""Time and memory of the whole command `fogzoo diagnose`, imports and report included, at several sizes.

python benchmarks/diagnose_command.py [WORDS]     only sizes with these words in their name, such as million
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

FOGZOO = Path(sys.executable).with_name("fogzoo")
DAY = (
    "[[20,20,3600],[20,60,6000],[60,60,3600],[60,-40,9000],[-40,-40,3600],[-40,20,3600],"
    "[20,20,3600],[20,50,3000],[50,0,4000],[0,40,4000],[40,40,3000],[40,20,3000]]"
)
TEN_HOURS = "[[20,20,3600],[20,60,6000],[60,60,3600],[60,-40,9000],[-40,-40,3600],[-40,20,3600],[20,50,3000],[50,20,3600]]"


@dataclass(frozen=True)
class Size:
    """What is diagnosed.

    Attributes:
        legs: of the chamber program.
        sample_s: from row to row [s].
        runs: fitted runs.
        hidden: what is to be found.
        times: how often the command is timed.
        repeated: rows for each one simulated, as a recorder would write that is faster than the gyro.
    """

    legs: str
    sample_s: float
    runs: int
    hidden: str
    times: int = 3
    repeated: int = 1


SIZES = {
    "3 runs x 5 000 rows (10 s), nothing hidden": Size(DAY, 10, 3, "none"),
    "3 runs x 5 000 rows (10 s), bias_step": Size(DAY, 10, 3, "bias_step"),
    "3 runs x 5 000 rows (10 s), polarization": Size(DAY, 10, 3, "polarization"),
    "3 runs x 50 000 rows (1 s), polarization": Size(DAY, 1, 3, "polarization"),
    "1 run x 7.2 million rows (200 Hz), polarization": Size(TEN_HOURS, 0.05, 1, "polarization", 1, 10),
}


def measured(*arguments: str) -> tuple[float, float]:
    """Wall time [s] and peak memory [MB] of a command."""
    started = time.perf_counter()
    process = subprocess.Popen([FOGZOO, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, ["fogzoo", *arguments])
    return time.perf_counter() - started, used.ru_maxrss / 1024


def diagnosed(size: Size, folder: str) -> tuple[float, float]:
    """Median time [s] and largest memory [MB] of diagnosing runs of a size, which are simulated first."""
    data = f"{folder}/data"
    program = ["profile=legs", f"profile.legs={size.legs}", f"sample_s={size.sample_s}", f"runs={size.runs}", "seed=3"]
    hidden = [] if size.hidden == "none" else [f"hidden={size.hidden}"]
    measured("simulate", *program, *hidden, f"hydra.run.dir={data}")
    for path in Path(data).glob("run_*.csv") if size.repeated > 1 else []:
        table = pd.read_csv(path)
        longer = table.loc[np.repeat(table.index, size.repeated)].reset_index(drop=True)
        longer["time_s"] = longer.index * size.sample_s / size.repeated
        longer.to_csv(path, index=False)
    found = [measured("diagnose", f"data.files=[{data}/run_*.csv]", f"hydra.run.dir={folder}/out_{i}") for i in range(size.times)]
    return sorted(wall for wall, _ in found)[size.times // 2], max(memory for _, memory in found)


def main(words: str) -> None:
    for name, size in SIZES.items():
        if words in name:
            with tempfile.TemporaryDirectory() as folder:
                wall, memory = diagnosed(size, folder)
            print(f"{name}: {wall:.1f} s (median of {size.times}), {memory:.0f} MB at most", flush=True)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "")
