"""Adds effects one at a time, refits, and watches the error fall."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from math import hypot, isclose
from typing import Any

import torch

from zoo.diagnosis.diagnose import Diagnosis, check_effects, diagnose
from zoo.diagnosis.parameters import fitted_parameters, times_of
from zoo.diagnosis.preparation import reference_varies
from zoo.diagnosis.readings import as_flown, scatter_in
from zoo.diagnosis.regions import runs_rms
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.strangers import strangers
from zoo.diagnosis.structure import Structure, examine
from zoo.diagnosis.workbench import VARIED_REFERENCE, Workbench
from zoo.effects.base import Effect
from zoo.effects.repeated import by_kind, candidates_beside, kinds, with_times
from zoo.errors import InputError
from zoo.fitting.noise import floor_of, floors_of, of_all
from zoo.measurements.recording import JITTER
from zoo.measurements.run import Run
from zoo.measurements.wrong_unit import too_hot
from zoo.models.graybox import GrayBox
from zoo.models.prediction import predict_blocks
from zoo.models.reach import beyond
from zoo.scoring.noise import CHECK_ALLOWED
from zoo.scoring.stages import rms
from zoo.threads import threads_for


@dataclass(frozen=True, eq=False)
class Refinement:
    """The ladder and where it ends.

    Attributes:
        record: the contract's refinement, ready for JSON.
        solutions: the fitted model of every rung.
        diagnosis: of the model before anything was added.
    """

    record: dict[str, Any]
    solutions: list[Solved]
    diagnosis: Diagnosis

    @property
    def model(self) -> GrayBox:
        """The model on the last rung."""
        return self.solutions[-1].model


@threads_for(0)
def refine(
    runs: list[Run],
    check_runs: list[Run],
    effects: list[str],
    add: str | list[str],
    catalogue: dict[str, Effect],
    progress: Callable[[str], None] = lambda _: None,
    diagnosis: Diagnosis | None = None,
) -> Refinement:
    """Refit with more effects.

    Args:
        runs: the fitted runs.
        check_runs: runs that are only predicted.
        effects: names in the model as it stands.
        add: names to add in this order, or ``"auto"`` for what the diagnosis finds missing. Either way the ladder stands on the runs as the
            diagnosis left them: without outliers, weighted by the noise that it found; its models are fitted to the readings as they are.
        catalogue: every effect by name.
        progress: told what is being done.
        diagnosis: of the model as it stands, where there is one already; by default a new one, with all of the catalogue as candidates.

    Raises:
        InputError: unknown effect, an effect that is there already, unusable runs, check runs averaged otherwise.
    """
    added = [] if add == "auto" else [add] if isinstance(add, str) else list(add)
    check_added(runs, check_runs, effects, added, catalogue)
    found = diagnosis or diagnose(runs, effects, catalogue, progress)
    if add == "auto":
        added, bench, base = found.search.missing, found.bench, found.search.base
    else:
        catalogue, added = _times(found, effects, catalogue, added)
        bench = found.bench.with_effects(catalogue)
        base = bench.begin(tuple(effects))
    climbed = _climb(bench, base, added, progress)
    structure = examine(bench, climbed[-1], base)
    solutions = as_flown(bench, [found.search.as_it_stands, *climbed[1:]])
    return Refinement(_record(bench, solutions, climbed[-1], structure, check_runs, added), solutions, found)


def _times(found: Diagnosis, effects: list[str], catalogue: dict[str, Effect], added: list[str]) -> tuple[dict[str, Effect], list[str]]:
    """A catalogue and the effects to add, each as often as a diagnosis has found it, once at least."""
    every, times = with_times(catalogue), by_kind(found.search.missing, found.bench.effects)
    return every, [each for name in added for each in times.get(name) or candidates_beside([name], effects, every)]


def check_added(runs: list[Run], check_runs: list[Run], effects: list[str], added: list[str], catalogue: dict[str, Effect]) -> None:
    """Refuse effects that cannot be added, and runs that cannot check them, before any work.

    Args:
        runs: the fitted runs.
        check_runs: runs that are only predicted.
        effects: names in the model as it stands.
        added: names to add.
        catalogue: every effect by name.

    Raises:
        InputError: an effect is there already, is unknown, or lacks its column or an input that changes; the runs cannot determine
            it; check runs averaged otherwise.
    """
    other = next((run for run in check_runs if not isclose(run.average_s, runs[0].average_s, rel_tol=JITTER)), None)
    if other is not None:
        told = f"{other.name} has block means of {other.average_s:g} s, {runs[0].name} of {runs[0].average_s:g} s"
        raise InputError(f"{told}: read all with one average_s")
    there = [name for name in effects if name in catalogue and not catalogue[name].again]
    twice = [name for place, name in enumerate(added) if name in [*there, *added[:place]]]
    if twice:
        raise InputError(f"add: '{twice[0]}' is in the model already (effects: {', '.join(effects)})")
    check_effects(runs, [*effects, *added], catalogue)
    useless = next((name for name in added if catalogue[name].needs_varied_reference and not reference_varies(runs)), None)
    if useless is not None:
        raise InputError(f"add: '{useless}' needs {VARIED_REFERENCE}; the true input of {', '.join(run.name for run in runs)} is always the same")


def _climb(bench: Workbench, base: Solved, added: list[str], progress: Callable[[str], None]) -> list[Solved]:
    """The models with one effect more at a time, all its times together; one that a search came by is taken as it is."""
    solutions, now = [base], base
    for one, names in by_kind(added, bench.effects).items():
        progress(f"refitting with {one}")
        for name in names:
            there = tuple(other for other in added if other in now.names)
            now = bench.known((*now.names, name)) or bench.add(now, name, (*there, name))
        solutions.append(now)
    return solutions


def _record(
    bench: Workbench, solutions: list[Solved], final: Solved, structure: Structure, check_runs: list[Run], added: list[str]
) -> dict[str, Any]:
    """The contract's record of the rungs, the last of which is the final model, as it flies."""
    ladder: list[dict[str, Any]] = [
        {"added": name, "effects": list(solved.names), "rms": solved.rms, "rms_check": check_rms(solved.model, check_runs)}
        for name, solved in zip([None, *kinds(added, bench.effects)], solutions, strict=True)
    ]
    floor = bench.reached_floor(final) if structure.is_noise else bench.mixtures.white
    noise = final.likely.noise if structure.is_noise else None
    floor_check = of_all(check_runs, [floor_of(run, noise) for run in check_runs]) if check_runs else None
    read = _of_readings(bench, solutions, check_runs)
    borne_out = floor_check is None or (ladder[-1]["rms_check"] or 0.0) <= CHECK_ALLOWED * hypot(floor_check, read["check"] or 0.0)
    return {
        "schema_version": 1,
        "unit": bench.runs[0].unit,
        "average_s": bench.runs[0].average_s,
        "runs": [run.name for run in bench.runs],
        "check_runs": [run.name for run in check_runs],
        "uncompensated_by_run": runs_rms(bench.runs, torch.cat([run.block_mean(run.error) for run in bench.runs])),
        "ladder": ladder,
        "noise_floor": floor,
        "noise_floor_by_run": floors_of(bench.runs, floor),
        "noise_floor_check": floor_check,
        "noise": None if noise is None else asdict(noise),
        "readings": read,
        "verdict": "complete" if structure.is_noise and borne_out else "unknown",
        "outdone": structure.outdone,
        "borne_out": borne_out,
        "strangers": strangers(bench, solutions, check_runs),
        "hot": too_hot([*bench.runs, *check_runs]),
        "beyond": beyond(solutions[-1].model, bench.runs, check_runs),
        "parameters": fitted_parameters(solutions[-1], bench.runs[0].unit),
        "times": times_of(solutions[-1]),
    }


def _of_readings(bench: Workbench, solutions: list[Solved], check_runs: list[Run]) -> dict[str, float | None]:
    """What the thermometers' scatter makes of the errors as they fly [unit], where it matters; of the rung of which it makes least.

    One that makes more of it than another would need to is not excused by that.
    """
    if not bench.steadied:
        return {"fit": None, "check": None}
    models = [solved.model for solved in solutions]
    each = {"fit": [scatter_in(model, bench.runs) for model in models], "check": [scatter_in(model, check_runs) for model in models]}
    return {role: min((one for one in made if one is not None), default=None) for role, made in each.items()}


def check_rms(model: GrayBox, runs: list[Run]) -> float | None:
    """RMS over the block means of runs that were not fitted [unit]; None where there are none."""
    if not runs:
        return None
    errors = [run.block_mean(run.error) - predict_blocks(model, run) for run in runs]
    return rms(torch.cat(errors))
