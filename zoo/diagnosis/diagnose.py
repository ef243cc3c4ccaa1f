"""How far the model is from the measurements, where it fails, and which effect is missing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from zoo.diagnosis.acceptance import accepted
from zoo.diagnosis.alike import indistinguishable
from zoo.diagnosis.cross_validation import rms_by_run
from zoo.diagnosis.description import Description, describe
from zoo.diagnosis.detection_limits import Limit, detection_limits
from zoo.diagnosis.experiment.proposal import Proposal
from zoo.diagnosis.experiment.propose import propose
from zoo.diagnosis.experiment.rivals import rivals_of
from zoo.diagnosis.noise_likelihood import NoiseMixtures
from zoo.diagnosis.parameters import fitted_parameters, times_of
from zoo.diagnosis.posterior import Hypothesis, hypotheses, posterior, too_small, unknown
from zoo.diagnosis.preparation import check_swing, without_spikes
from zoo.diagnosis.regions import regions, runs_rms
from zoo.diagnosis.search import Search, what_helps
from zoo.diagnosis.settle import settle
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.strangers import strangers
from zoo.diagnosis.structure import Structure, examine
from zoo.diagnosis.trials import Step, Trial
from zoo.diagnosis.workbench import Workbench
from zoo.effects.base import RUN, Effect, Parameter
from zoo.effects.repeated import kind, kinds
from zoo.errors import InputError, nearest
from zoo.fitting.noise import floors_of, noise_of
from zoo.measurements.run import Run
from zoo.measurements.wrong_unit import too_hot
from zoo.scoring.noise import effective_samples
from zoo.scoring.stages import rms
from zoo.side_by_side import side_by_side
from zoo.threads import threads_for

SCHEMA_VERSION = 1
LISTED = 9
"""How many hypotheses are listed beside the unknown."""
PROMISING = 0.3
"""Share of an effect's gain by projection that another must have for a closer look at whether it can be told from it."""
CLOSE = 3.0
"""Log Bayes factor below which two effects explain the runs about as well (20 : 1, strong evidence in Kass & Raftery 1995)."""


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


def check_effects(runs: list[Run], effects: list[str], catalogue: dict[str, Effect]) -> None:
    """Refuse effects that these runs cannot be fitted with.

    Args:
        runs: the fitted runs.
        effects: names.
        catalogue: every effect by name.

    Raises:
        InputError: there is no run or no effect; an effect is not in the catalogue or lacks its column; the runs cannot determine it.
    """
    if not runs or not effects:
        what = "effect to start from: static_bias, shupe, mohr are where most gyros do" if runs else "run to compare with"
        raise InputError(f"no {what}")
    for name in effects:
        if name not in catalogue:
            raise InputError(f"unknown effect '{name}': {nearest(name, catalogue)}")
        lacking = [column for column in catalogue[name].needs if column not in runs[0].columns]
        if lacking:
            raise InputError(f"effect '{name}' needs the column {', '.join(lacking)}; {runs[0].name} has {', '.join(runs[0].known)}")
    check_swing(runs, {name: catalogue[name] for name in effects})


def open_bench(runs: list[Run], effects: list[str], catalogue: dict[str, Effect]) -> Workbench:
    """Check the runs, leave spikes out and estimate the noise.

    Args:
        runs: the fitted runs.
        effects: names in the model as it stands.
        catalogue: every effect by name.

    Raises:
        InputError: see `check_effects`.
    """
    check_effects(runs, effects, catalogue)
    clean = without_spikes(runs)
    noise = noise_of(clean)
    return Workbench(clean, catalogue, noise, NoiseMixtures(clean, noise.white))


@threads_for(0)
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
    candidates = [name for name in bench.available() if name not in effects or bench.effects[name].again]
    bench, found = settle(bench, tuple(effects), candidates, progress)
    base = found.base
    progress("testing what is left")
    structure = examine(bench, found.final, base)
    if not structure.is_noise:
        found = what_helps(found)
        structure = examine(bench, found.final, base)
    verdict = "unknown" if not structure.is_noise else "missing" if found.missing else "complete"
    if verdict == "unknown":
        progress("describing what nothing explains")
    told = _description(bench, found) if verdict == "unknown" else None
    complete = found.final if structure.is_noise else told and told.complete
    floor = bench.reached_floor(complete) if complete else bench.mixtures.white
    missing, others = kinds(found.missing, bench.effects), _not_in(found.final, candidates, bench)
    limits = detection_limits(bench, found.final, others, accepted(base, found.final))
    weighed = hypotheses(found, structure, too_small([(limit.hidden, limit.odds) for limit in limits.values()], alone=not missing), bench.effects)
    shown, floors = found.as_it_stands, floors_of(bench.runs, floor)
    record = {
        "schema_version": SCHEMA_VERSION,
        "effects": list(effects),
        "unit": runs[0].unit,
        "average_s": runs[0].average_s,
        "runs": [run.name for run in runs],
        "thermometers": list(base.model.thermometers),
        "samples": bench.blocks,
        "effective_samples": round(effective_samples(found.final.likely.noise, bench.mixtures.runs), 1),
        "noise_floor": floor,
        "noise_floor_by_run": floors,
        "noise": asdict(found.final.likely.noise),
        "rms": shown.rms,
        "rms_by_run": runs_rms(bench.runs, shown.residual),
        "rms_uncompensated": rms(base.design.error),
        "rms_final": (found.final if found.missing else shown).rms,
        "verdict": verdict,
        "missing": missing,
        "outdone": structure.outdone,
        "posterior": _posterior(weighed, structure),
        "candidates": _candidates(bench, found, candidates, weighed),
        "detection_limits": {name: _limit(limit) for name, limit in limits.items()},
        "where": regions(bench.runs, shown.residual, floors),
        "strangers": strangers(bench, (base, found.final)),
        "hot": too_hot(bench.runs),
        "next_experiment": None,
        "unexplained": [],
        "parameters": fitted_parameters(found.final, runs[0].unit),
        "times": times_of(found.final),
        "not_tried": {name: bench.lacking(name) for name in catalogue if name not in effects and bench.lacking(name)},
        "notes": [*(note for run in bench.runs for note in run.notes), *_unequal(floors), *_numbered(len(runs), bench.effects)],
    }
    record |= told.record() if told else {}
    proposal = _experiment(bench, found, record, progress)
    return Diagnosis(record | {"next_experiment": proposal.record() if proposal else None}, bench, found, structure)


def _description(bench: Workbench, found: Search) -> Description:
    """What the model leaves; where nothing smooth is seen in that, what it leaves with one effect more that helps, which may have hidden it."""
    first = describe(bench, found.base)
    if first.best is not None or found.final is found.base:
        return first
    for solved in found.path:
        told = describe(bench, solved)
        if told.best is not None:
            return told
        if solved is found.final:
            break
    return first


def _unequal(floors: dict[str, float]) -> list[str]:
    """A note where one run is noisier than another."""
    quiet, loud = min(floors, key=lambda name: floors[name]), max(floors, key=lambda name: floors[name])
    if floors[loud] <= floors[quiet]:
        return []
    return [f"the runs are not equally noisy: {loud} has {floors[loud] / floors[quiet]:.1f} times the noise of {quiet}, each is judged by its own"]


def _counts_runs(one: Parameter) -> bool:
    return (one.name, one.scale) == (RUN, "index")


def _numbered(runs: int, effects: dict[str, Effect]) -> list[str]:
    """A note where there are more runs than an effect can tell by their numbers."""
    known = {kind(name, effect): effect for name, effect in effects.items()}
    most = {name: int(one.high) for name, effect in known.items() for one in effect.shape if _counts_runs(one) and one.high < runs}
    if not most:
        return []
    return [f"of {runs} runs only the first {min(most.values())} are searched for one that differs from the others ({', '.join(most)})"]


def _experiment(bench: Workbench, found: Search, record: dict[str, Any], progress: Callable[[str], None]) -> Proposal | None:
    """The run that would tell apart what these do not; None where nothing is open."""
    twins = {entry["effect"]: entry["indistinguishable_from"] for entry in record["candidates"] if entry["effect"] in record["missing"]}
    rivals = rivals_of(bench, found, twins)
    if len(rivals) < 2:
        return None
    progress("looking for the next experiment")
    return propose(bench, rivals)


def _limit(limit: Limit) -> dict[str, float | None]:
    """A limit of detection for JSON, which knows no infinity."""
    return {"size": limit.size if math.isfinite(limit.size) else None, "hidden": limit.hidden, "odds": limit.odds}


def _posterior(weighed: list[Hypothesis], structure: Structure) -> list[dict[str, Any]]:
    """Hypotheses with their probabilities, likeliest first."""
    listed = [
        {
            "hypothesis": "faint" if one.faint else "missing" if one.effects else "complete",
            "effects": list(one.effects),
            "probability": one.probability,
        }
        for one in weighed[:LISTED]
    ]
    return sorted([*listed, {"hypothesis": "unknown", "effects": [], "probability": unknown(structure)}], key=lambda one: -one["probability"])


def _candidates(bench: Workbench, found: Search, names: list[str], weighed: list[Hypothesis]) -> list[dict[str, Any]]:
    first = found.steps[0]
    tried = [trial.screened.name for trial in first.trials]
    added = {kind(name, bench.effects[name]): name for name in reversed(found.missing)}  # of what was added several times, the first
    asked = [*reversed(added.values())] or [trial.screened.name for trial in first.trials[:1] if trial.refitted and trial.evidence > 0]
    chance = {name: sum(one.probability for one in weighed if kind(name, bench.effects[name]) in one.effects) for name in [*tried, *asked]}
    others = _not_in(found.final, names, bench)
    entries = [_candidate(bench, found, name, chance[name], others) for name in asked]  # each beside all others side by side
    rest = [name for name in tried if not {name, added.get(kind(name, bench.effects[name]))}.intersection(asked)]
    entries += side_by_side(lambda name: _candidate(bench, found, name, chance[name], []), rest)
    twins = {entry["effect"]: entry["indistinguishable_from"] for entry in entries}
    for entry in entries[len(asked) :]:  # neither can be told from the other
        entry["indistinguishable_from"] = [one["effect"] for one in entries[: len(asked)] if entry["effect"] in twins[one["effect"]]]
    rank = {name: i for i, name in enumerate(kinds(found.missing, bench.effects))}
    return sorted(entries, key=lambda entry: (rank.get(entry["effect"], len(rank)), -entry["probability"], entry["delta_bic"]))


def _candidate(bench: Workbench, found: Search, name: str, chance: float, compare_with: list[str]) -> dict[str, Any]:
    """What is known of one candidate, from one round of the search; parameters of an effect that was added are those of the final model.

    Its probability is that of all hypotheses together that have it.
    """
    step = _round_for(found, name)
    trial = next(trial for trial in step.trials if trial.screened.name == name)
    solved = trial.solved or bench.peek(step.before, name, trial.screened.shape, trial.screened.start)
    effect = bench.effects[name]
    return {
        "effect": kind(name, effect),
        "probability": chance,
        "rms": solved.rms,
        "rms_cross_validated": rms_by_run(bench, solved),
        "delta_bic": -2.0 * bench.evidence(step.before, solved),
        "beside": list(step.before.names),
        "indistinguishable_from": _alike(bench, step, trial, solved, compare_with),
        "parameters": fitted_parameters(found.final if name in found.missing else solved, bench.runs[0].unit)[name],
        "place": effect.place,
        "formula": effect.formula,
        "explanation": effect.signature,
        "refitted": trial.refitted,
    }


def _alike(bench: Workbench, step: Step, own: Trial, solved: Solved, compare_with: list[str]) -> list[str]:
    """Those that the columns cannot tell from it in this noise, and those that explain these runs about as well."""
    if not compare_with:
        return []
    as_likely = [one.screened.name for one in step.trials if one is not own and one.refitted and one.evidence > own.evidence - CLOSE]
    gains = {one.screened.name: one.screened.gain for one in step.trials}
    promising = [name for name in compare_with if gains.get(name, 0.0) > PROMISING * own.screened.gain or name not in gains]
    found = [*as_likely, *indistinguishable(bench, solved, own.screened.name, promising)]
    return [name for name in kinds(found, bench.effects) if name != kind(own.screened.name, bench.effects[own.screened.name])]


def _not_in(solved: Solved, names: list[str], bench: Workbench) -> list[str]:
    """Those of some effects in the catalogue that a model does not have."""
    return [name for name in names if name not in kinds(solved.names, bench.effects)]


def _round_for(found: Search, name: str) -> Step:
    """The round that added an effect, beside all the others if there is one; for another the round, of those beside nothing but what lasted, in which
    it was the likeliest alternative to something lasting."""
    tried = [step for step in found.steps if name in posterior(step)]
    own = [step for step in tried if {*step.before.names, name} == set(found.final.names)] or [step for step in tried if step.chosen == name]
    if name in found.missing and own:
        return own[-1]
    tried = [step for step in tried if set(step.before.names) <= set(found.final.names)] or tried
    lasting = [step for step in tried if step.chosen in found.missing] or tried[:1]
    return max(lasting, key=lambda step: posterior(step)[name])
