"""A gyro with a hidden effect, simulated, diagnosed, refined, compared; the truth comes last: python scripts/demo.py [seed=7]"""

import json
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FOGZOO = Path(sys.executable).with_name("fogzoo")
SEED = 10
NEAR = 1.25
"""Times the noise floor."""
NEXT = """Your own recordings, one run a file, columns time_s, temperature_c and rate_dph (rate_dps, rate_rad_per_s, accel_ug ...):
  source .venv/bin/activate
  fogzoo diagnose 'data.files=[run_*.csv]'
With other names and units:
  fogzoo diagnose 'data.files=[log.csv]' data.columns.time=t data.columns.temperature=imu_temp data.columns.output=gz data.output_unit=rad/s
Then what is missing added, and checked on a run that is not fitted:
  fogzoo refine add=auto 'data.files=[run_*.csv]' 'data.check_files=[check.csv]'"""


def heading(text: str) -> None:
    print(f"\n\033[1m== {text}\033[0m" if sys.stdout.isatty() else f"\n== {text}", flush=True)


def fogzoo(*arguments: str, quiet: bool = False) -> None:
    """Runs one verb as a user would; ends the demo where it fails."""
    print("$", shlex.join(["fogzoo", *arguments]), flush=True)
    done = subprocess.run([FOGZOO, *arguments], cwd=ROOT, capture_output=quiet, text=True, check=False)
    if done.returncode:
        sys.exit(f"{done.stdout or ''}{done.stderr or ''}the demo ended here: fogzoo {arguments[0]} gave exit code {done.returncode}")


def document(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def judgement(hidden: str, diagnosis: dict[str, Any], refinement: dict[str, Any]) -> str:
    """What the verdict is worth, knowing the truth."""
    named = diagnosis["missing"]
    alike = {other for one in diagnosis["candidates"] if one["effect"] in named for other in one["indistinguishable_from"]}
    if named == [hidden]:
        return "Right."
    if hidden in named:
        return f"Half right: {hidden} was named, but not alone."
    if hidden in alike:
        return f"Not told apart: the diagnosis named {', '.join(named)} and said that these runs cannot tell it from {hidden}."
    if named:
        return f"Wrong: it is {hidden}, and the diagnosis named {', '.join(named)}."
    called = "the model is complete" if diagnosis["verdict"] == "complete" else "something is missing, but not what"
    floor, after = refinement["noise_floor_check"], refinement["ladder"][-1]["rms_check"]
    why = "the known effects take its place: the check run is near its noise floor all the same"
    if not floor or after > NEAR * floor:
        why = "yet the check run shows that something is missing, so it should have been seen"
    return f"Missed: the diagnosis says that {called}; {why}."


def numbers(hidden: str, truth: dict[str, Any], diagnosis: dict[str, Any]) -> None:
    """The hidden effect's parameters, true and fitted."""
    fitted = {one["effect"]: one.get("parameters") or {} for one in diagnosis["candidates"]}.get(hidden, {})
    for name, true in truth["parameters"][hidden].items():
        found, error = fitted.get(name, {}).get("value"), fitted.get(name, {}).get("stderr")
        value = "–" if found is None else f"{found:.4g}"
        spread = "" if error is None else f" ± {error:.2g}"
        unit = "" if true["unit"] == "1" else f" {true['unit']}"
        print(f"  {name:<12} true {true['value']:>9.4g}   fitted {value:>9}{spread}{unit}")


def reveal(folder: Path) -> None:
    truth, diagnosis = document(folder / "runs/truth.json"), document(folder / "diagnosis/diagnosis.json")
    refinement = document(folder / "refinement/refinement.json")
    (hidden,) = truth["hidden"]
    last = refinement["ladder"][-1]
    print(f"  hidden       {hidden}, {truth['rms'][hidden]['value']:.3g} °/h RMS; the noise floor is {diagnosis['noise_floor']:.3g} °/h")
    print(f"  diagnosed    {', '.join(diagnosis['missing']) or 'nothing'}; verdict '{diagnosis['verdict']}'")
    print(f"  check run    {refinement['ladder'][0]['rms_check']:.3g} °/h before, {last['rms_check']:.3g} °/h after", end="")
    print(f"; its noise floor is {refinement['noise_floor_check']:.3g} °/h" if refinement["noise_floor_check"] else "")
    print(f"\n  {judgement(hidden, diagnosis, refinement)}\n")
    if diagnosis["missing"]:
        numbers(hidden, truth, diagnosis)


def main(seed: int) -> None:
    began, folder = time.monotonic(), Path("outputs/demo") / f"seed_{seed}"
    files, check = f"data.files=[{folder}/runs/run_*.csv]", f"data.check_files=[{folder}/runs/check.csv]"
    heading("1  A gyro in the chamber: known effects, noise, and one effect that the fit is not told")
    fogzoo("simulate", "hidden=1", f"seed={seed}", f"hydra.run.dir={folder}/runs")
    heading("2  What is missing in the model of static_bias, shupe and mohr?")
    fogzoo("diagnose", files, f"hydra.run.dir={folder}/diagnosis")
    heading("3  Add it, fit again, look at a run that was not fitted")
    fogzoo("refine", "add=auto", files, check, f"hydra.run.dir={folder}/refinement")
    heading("4  Two models that know no physics, for comparison")
    for model in ("polynomial", "bp"):
        fogzoo("train", f"model={model}", files, f"hydra.run.dir={folder}/{model}", quiet=True)
    models = ",".join(f"{folder}/{name}" for name in ("refinement", "polynomial", "bp"))
    fogzoo("compare", f"runs=[{models}]", f"data.files=[{folder}/runs/check.csv]", f"hydra.run.dir={folder}/comparison")
    heading(f"5  The truth, from {folder}/runs/truth.json")
    reveal(ROOT / folder)
    heading(f"Done in {time.monotonic() - began:.0f} s. The report with all plots: {folder}/refinement/report.html")
    print(f"Another gyro: make demo SEED={seed + 1}. Not every hidden effect can be found; see what it says then.\n\n{NEXT}")


if __name__ == "__main__":
    given = re.fullmatch(r"(?:seed=)?(\d+)", " ".join(sys.argv[1:]) or str(SEED))
    if not given:
        sys.exit("usage: python scripts/demo.py [seed=NUMBER]")
    main(int(given[1]))
