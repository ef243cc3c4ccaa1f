"""Time and memory of the whole command `fogzoo diagnose`, imports and report included, at two sizes."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FOGZOO = Path(sys.executable).with_name("fogzoo")
LEGS = (
    "[[20,20,3600],[20,60,6000],[60,60,3600],[60,-40,9000],[-40,-40,3600],[-40,20,3600],"
    "[20,20,3600],[20,50,3000],[50,0,4000],[0,40,4000],[40,40,3000],[40,20,3000]]"
)
SIZES = {"3 runs x 5 000 rows (10 s)": 10, "3 runs x 50 000 rows (1 s)": 1}


def measured(*arguments: str) -> tuple[float, float]:
    """Wall time [s] and peak memory of all children so far [MB]."""
    started = time.perf_counter()
    subprocess.run([FOGZOO, *arguments], check=True, capture_output=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
    return time.perf_counter() - started, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        for words, sample_s in SIZES.items():
            data = f"{folder}/data_{sample_s}"
            settings = ["hidden=polarization", "profile=legs", f"profile.legs={LEGS}", f"sample_s={sample_s}", "seed=3"]
            measured("simulate", *settings, f"hydra.run.dir={data}")
            times = [measured("diagnose", f"data.files=[{data}/run_*.csv]", f"hydra.run.dir={folder}/out_{sample_s}_{i}") for i in range(3)]
            print(f"{words}: {sorted(wall for wall, _ in times)[1]:.1f} s (median of 3), {times[-1][1]:.0f} MB at most", flush=True)


if __name__ == "__main__":
    main()
