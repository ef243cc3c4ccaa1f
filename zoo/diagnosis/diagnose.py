"""How far the model is from the measurements, where it fails, and which effect is missing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from zoo.diagnosis.alike import indistinguishable
from zoo.diagnosis.cross_validation import rms_by_run
from zoo.diagnosis.parameters import fitted_parameters
from zoo.diagnosis.preparation import check_swing, noise_of, without_spikes
from zoo.diagnosis.regions import regions, runs_rms
from zoo.diagnosis.search import Search, Trial, posterior, search
from zoo.diagnosis.structure import Structure, dependences, examine
from zoo.diagnosis.workbench import Solved, Workbench
from zoo.effects.base import Effect
from zoo.errors import InputError, nearest
from zoo.measurements.run import Run

SCHEMA_VERSION = 1
COMPARED = 3
"""How many of the best candidates are compared with all others for what these runs cannot tell apart."""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What was found.

    Attributes:
        record: the contract's diagnosis, ready for JSON.
        bench: the runs and their noise.
        search: the path from the model as it stands to the one with everything that helps.
        structure: the absolute test of what is left.
    """

    record: dict[str, Any]
    bench: Workbench
    search: Search
    structure: Structure

    @property
    def verdict(self) -> str:
        """``"complete"``, ``"missing"`` or ``"unknown"``."""
        return str(self.record["verdict"])


def open_bench(runs: list[Run], effects: list[str], catalogue: dict[str, Effect]) -> Workbench:
    """Check the runs, leave spikes out and estimate the noise.

    Args:
        runs: the fitted runs.
        effects: names in the model as it stands.
        catalogue: every effect by name.

    Raises:
        InputError: an effect is not in the catalogue or lacks its column; the runs cannot determine it.
    """
    for name in effects:
        if name not in catalogue:
            raise InputError(f"unknown effect '{name}': {nearest(name, catalogue)}")
        lacking = [column for column in catalogue[name].needs if column not in runs[0].columns]
        if lacking:
            raise InputError(f"effect '{name}' needs the column {', '.join(lacking)}; {runs[0].name} has {', '.join(runs[0].columns)}")
    check_swing(runs, {name: catalogue[name] for name in effects})
    clean = without_spikes(runs)
    return Workbench(clean, catalogue, noise_of(clean))


def diagnose(runs: list[Run], effects: list[str], catalogue: dict[str, Effect], progress: Callable[[str], None] = lambda _: None) -> Diagnosis:
    """Compare a sum of effects with measurements and say what is missing.

    Args:
        runs: R runs, all fitted.
        effects: names in the model as it stands.
        catalogue: every effect by name, those of the model included.
        progress: told what is being done, one line at a time.

    Raises:
        InputError: see `open_bench`.
    """
    bench = open_bench(runs, effects, catalogue)
    progress("fitting the model as it stands")
    base = bench.solve(tuple(effects))
    candidates = [name for name in bench.available() if name not in effects]
    found = search(bench, base, candidates, progress)
    progress("testing what is left")
    structure = examine(bench, found.final, base)
    verdict = "unknown" if not structure.is_noise else "missing" if found.missing else "complete"
    record = {
        "schema_version": SCHEMA_VERSION,
        "effects": list(effects),
        "unit": runs[0].unit,
        "average_s": runs[0].average_s,
        "runs": [run.name for run in runs],
        "samples": bench.blocks,
        "noise_floor": bench.noise.white,
        "rms": base.rms,
        "rms_by_run": runs_rms(bench.runs, base.residual),
        "rms_uncompensated": float(base.design.error.square().mean().sqrt()),
        "rms_final": found.final.rms,
        "verdict": verdict,
        "missing": found.missing,
        "candidates": _candidates(bench, base, found, candidates),
        "where": regions(bench.runs, base.residual, bench.noise.white),
        "next_experiment": None,
        "unexplained": [_dependence(item) for item in (dependences(bench, base) if verdict == "unknown" else [])],
        "parameters": fitted_parameters(found.final, runs[0].unit),
        "not_tried": {name: list(effect.needs) for name, effect in catalogue.items() if name not in bench.available()},
        "notes": [note for run in bench.runs for note in run.notes],
    }
    return Diagnosis(record, bench, found, structure)


def _candidates(bench: Workbench, base: Solved, found: Search, names: list[str]) -> list[dict[str, Any]]:
    chances = _probabilities(bench, found)
    first = found.steps[0].trials if found.steps else []
    compared = {trial.screened.name for trial in first[:COMPARED] if trial.solved is not None and trial.evidence > 0} | set(found.missing)
    entries = [_candidate(bench, base, trial, names if trial.screened.name in compared else [], chances) for trial in first]
    rank = {name: i for i, name in enumerate(found.missing)}
    return sorted(entries, key=lambda entry: (rank.get(entry["effect"], len(rank)), -entry["probability"], entry["delta_bic"]))


def _candidate(bench: Workbench, base: Solved, trial: Trial, compare_with: list[str], chances: dict[str, float]) -> dict[str, Any]:
    name = trial.screened.name
    solved = trial.solved or bench.peek(base, name, trial.screened.shape)
    effect = bench.effects[name]
    return {
        "effect": name,
        "probability": chances.get(name, 0.0),
        "rms": solved.rms,
        "rms_cross_validated": rms_by_run(bench, solved),
        "delta_bic": -2.0 * bench.evidence(base, solved),
        "indistinguishable_from": indistinguishable(bench, base, solved, compare_with) if compare_with else [],
        "parameters": fitted_parameters(solved, bench.runs[0].unit)[name],
        "place": effect.place,
        "formula": effect.formula,
        "explanation": effect.signature,
        "refitted": trial.solved is not None,
    }


def _probabilities(bench: Workbench, found: Search) -> dict[str, float]:
    """Highest posterior of each candidate over the rounds; a free smooth function of one quantity competes in each of them as 'none of the known'."""
    best: dict[str, float] = {}
    for step in found.steps:
        rivals = [item.evidence for item in dependences(bench, step.before)]
        for name, chance in posterior(step.trials, rivals).items():
            best[name] = max(chance, best.get(name, 0.0))
    return best


def _dependence(item: Any) -> dict[str, Any]:
    return {"depends_on": item.depends_on, "explains": item.explains}
