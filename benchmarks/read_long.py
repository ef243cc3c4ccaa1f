"""Time and memory of reading a long run: 10 h at 200 Hz, 7.2 million rows, each read in a process of its own.

python benchmarks/read_long.py [ROWS]
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from zoo.measurements.write import write_measurements

RATE_HZ = 200
CASES = [("csv", "auto"), ("csv.gz", "auto"), ("parquet", "auto"), ("csv", 100.0), ("parquet", 1.0)]
CHILD = """
import json, resource, sys, time
from zoo.measurements.read import read_runs
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
path, average = sys.argv[1], json.loads(sys.argv[2])
before, start = peak(), time.perf_counter()
run = read_runs([path], average_s=average)[0]
print(json.dumps([time.perf_counter() - start, run.rows, len(run.time), run.blocks, run.average_s, before, peak()]))
"""


def frames(rows: int, chunk: int = 200_000) -> Iterator[pd.DataFrame]:
    """A ramp up and down with white noise on the rate, seven digits a cell."""
    random = np.random.default_rng(1)
    for start in range(0, rows, chunk):
        row = np.arange(start, min(start + chunk, rows))
        temperature = 20 + 40 * np.sin(2 * np.pi * row / rows)
        rate = 0.01 * temperature + random.normal(0, 1, len(row))
        yield pd.DataFrame({"time_s": row / RATE_HZ, "temperature_c": temperature.round(4), "temperature_case_c": (temperature + 1).round(4), "rate_dph": rate.round(5)})


def main(rows: int) -> None:
    """Writes the three files to a temporary folder and prints a table."""
    print(f"{rows} rows, {rows / RATE_HZ / 3600:g} h at {RATE_HZ} Hz")
    print(f"{'file':<8} {'MB':>5} {'average_s':>9} {'s':>6} {'Mrow/s':>7} {'fine':>7} {'blocks':>6} {'RSS before, MB':>15} {'peak, MB':>9} {'growth, MB':>11}")
    with tempfile.TemporaryDirectory() as folder:
        paths = {kind: write_measurements(Path(folder) / f"long.{kind}", frames(rows)) for kind in ("csv", "csv.gz", "parquet")}
        for kind, average in CASES:
            done = subprocess.run([sys.executable, "-c", CHILD, str(paths[kind]), json.dumps(average)], capture_output=True, text=True, check=True)
            seconds, read, fine, blocks, length, before, peak = json.loads(done.stdout)
            size = paths[kind].stat().st_size / 1e6
            print(
                f"{kind:<8} {size:>5.0f} {f'{average}' if average != 'auto' else f'auto:{length:g}':>9} {seconds:>6.2f} {read / seconds / 1e6:>7.2f} {fine:>7} "
                f"{blocks:>6} {before:>15.0f} {peak:>9.0f} {peak - before:>11.0f}"
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 7_200_000)
