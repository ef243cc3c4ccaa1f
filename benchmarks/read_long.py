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
    """One swing of the temperature, and a rate that follows it with white noise."""
    random = np.random.default_rng(1)
    for start in range(0, rows, chunk):
        row = np.arange(start, min(start + chunk, rows))
        temperature = (20 + 40 * np.sin(2 * np.pi * row / rows)).round(4)
        rate = (0.01 * temperature + random.normal(0, 1, len(row))).round(5)
        yield pd.DataFrame({"time_s": row / RATE_HZ, "temperature_c": temperature, "temperature_case_c": temperature + 1, "rate_dph": rate})


def measure(path: Path, average: str | float) -> str:
    """Reads one file in a new process; a line of the table."""
    command = [sys.executable, "-c", CHILD, str(path), json.dumps(average)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    seconds, rows, fine, blocks, length, before, peak = json.loads(done.stdout)
    asked = f"auto:{length:g}" if average == "auto" else f"{length:g}"
    size, speed = path.stat().st_size / 1e6, rows / seconds / 1e6
    return f"{size:>5.0f} {asked:>9} {seconds:>6.2f} {speed:>7.2f} {fine:>7} {blocks:>6} {before:>10.0f} {peak:>8.0f} {peak - before:>10.0f}"


def main(rows: int) -> None:
    """Writes the files to a temporary folder and prints the table."""
    print(f"{rows} rows, {rows / RATE_HZ / 3600:g} h at {RATE_HZ} Hz; RSS of the reading process in MB, torch and pandas being loaded before")
    print("file        MB average_s      s  Mrow/s    fine blocks RSS before RSS peak RSS growth")
    with tempfile.TemporaryDirectory() as folder:
        paths = {kind: write_measurements(Path(folder) / f"long.{kind}", frames(rows)) for kind in ("csv", "csv.gz", "parquet")}
        for kind, average in CASES:
            print(f"{kind:<8} {measure(paths[kind], average)}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 7_200_000)
