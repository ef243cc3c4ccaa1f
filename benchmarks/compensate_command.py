"""Time and memory of the whole command `fogzoo compensate`, imports and figure included: 10 h at 200 Hz, 7.2 million rows.

python benchmarks/compensate_command.py [ROWS]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from read_long import frames

from zoo.measurements.write import write_measurements

COMMAND = [sys.executable, "-c", "from zoo.cli import main; main()"]
EFFECTS = "[static_bias,shupe,mohr,hysteresis,viscoelastic]"
MODELS = {"bp": ["model=bp", "epochs=20"], "grey box of 5 effects": ["model=graybox", f"effects={EFFECTS}"]}
PROGRAM = ["profile=legs", "profile.legs=[[20,20,3600],[20,60,6000],[60,60,3600],[60,-20,9000],[-20,20,3600]]", "sample_s=10", "runs=1"]
KINDS = ("csv", "csv.gz", "parquet")


def measured(*arguments: str) -> tuple[float, float]:
    """Wall time [s] and peak memory [MB] of a command."""
    started = time.perf_counter()
    process = subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, ["fogzoo", *arguments])
    return time.perf_counter() - started, used.ru_maxrss / 1024


def main(rows: int) -> None:
    """Trains both models on a short run, writes the long files, and prints the table."""
    print(f"{rows} rows of 4 columns, compensated by models that take the thermometer(s)")
    print(f"{'model':<22} {'file':<8} {'MB':>5} {'s':>6} {'Mrow/s':>7} {'MB peak':>8}")
    with tempfile.TemporaryDirectory() as folder:
        measured("simulate", *PROGRAM, f"hydra.run.dir={folder}/short")
        renamed = "+data.columns.temperature_case=temperature_outer_c"
        trained = [f"data.files=[{folder}/short/run_1.csv]", renamed]
        paths = {kind: write_measurements(Path(folder) / f"long.{kind}", frames(rows)) for kind in KINDS}
        for place, (name, settings) in enumerate(MODELS.items()):
            run = f"{folder}/model_{place}"
            inputs = ["model.inputs=[time_s,temperature_c,temperature_case_c,reference_dph]"] if "graybox" in settings[0] else []
            measured("train", *settings, *trained, *inputs, f"hydra.run.dir={run}")
            for kind, path in paths.items():
                wall, memory = measured("compensate", f"run={run}", f"data.files=[{path}]", f"hydra.run.dir={folder}/out_{place}_{kind}")
                print(f"{name:<22} {kind:<8} {path.stat().st_size / 1e6:>5.0f} {wall:>6.1f} {rows / wall / 1e6:>7.2f} {memory:>8.0f}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 7_200_000)
