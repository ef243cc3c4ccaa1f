"""A trained model and the effects that it lacks: found, and trained together with it."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import torch
from omegaconf import DictConfig, OmegaConf

from zoo.catalog import MODEL_FILE, load, names
from zoo.cli.command_line import plain, searchpath
from zoo.cli.given_model import Subject
from zoo.cli.next_commands import with_own_configs
from zoo.cli.saved_models import physical_values
from zoo.diagnosis.diagnose import Diagnosis, diagnose
from zoo.diagnosis.refine import Refinement, refine
from zoo.diagnosis.regions import regions, runs_rms
from zoo.diagnosis.solved import Solved
from zoo.effects.repeated import kind
from zoo.given import of_the_house
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.scoring.noise import CHECK_ALLOWED
from zoo.scoring.stages import rms
from zoo.training.scores import residual_blocks, score_runs

Progress = Callable[[str], None]


def examine(asked: Subject, runs: list[Run], progress: Progress) -> tuple[Diagnosis, Subject]:
    """Diagnose; a network that seems to lack several effects, or something unknown, is looked at again.

    A network that lacks an effect has bent itself to it, farther perhaps than its linearisation reaches back; what it is then short of passes for a
    second effect. So it is trained with the first one beside it, and linearised there as well.
    """
    with _nothing_is_trained_after(asked):
        found = diagnose(runs, asked.effects, asked.catalogue, progress)
    missing = found.search.missing
    if asked.network is None or not missing or (len(found.record["missing"]) == 1 and found.verdict == "missing"):
        return _told(found, asked), asked
    progress(f"training with {missing[0]}, to look again")
    beside = next(solved for solved in _rungs(found) if missing[0] in solved.names)
    grown = _grown(asked, beside, runs)[0]
    assert isinstance(grown, Hybrid)
    again = asked.linearised(runs, [grown.network])
    return _told(diagnose(runs, again.effects, again.catalogue, progress), again), again


def _nothing_is_trained_after(asked: Subject) -> torch.inference_mode:
    """Torch's inference mode for a sum of this package's effects, a tenth faster.

    What it makes, also of the runs, goes into no gradient, as a network's would, and cannot be changed after it, as an effect from outside may do.
    """
    return torch.inference_mode(asked.network is None and all(map(of_the_house, asked.catalogue.values())))


def _rungs(found: Diagnosis) -> list[Solved]:
    return [*(step.before for step in found.search.steps), found.search.final]


def _told(found: Diagnosis, asked: Subject) -> Diagnosis:
    """The diagnosis with the model it is of, and what that leaves as it was trained: the linearised one was fitted to these runs anew."""
    record = found.record
    record["left_out"] = [name for name in names("effects", searchpath()) if name not in asked.catalogue]
    if record["next_experiment"] is not None:
        record["next_experiment"]["command"] = with_own_configs(record["next_experiment"]["command"])
    if asked.saved is None:
        return found
    record["model"] = {"path": str(asked.saved.folder), "name": asked.saved.kind}
    record["parameters"].pop(asked.term, None)
    if asked.as_given is not None:
        clean = _on_cpu(found.bench.runs)
        left = torch.cat([residual_blocks(asked.as_given, run) for run in clean])
        record |= {
            "rms": rms(left),
            "rms_by_run": runs_rms(clean, left),
            "where": regions(clean, left, record["noise_floor_by_run"]),
            "verdict_refitted": record["verdict"],
        }
        if record["verdict"] == "complete" and record["rms"] > CHECK_ALLOWED * record["noise_floor"]:
            record["verdict"] = "unknown"
    return found


def climb(
    asked: Subject, before: Diagnosis, runs: list[Run], check_runs: list[Run], add: str | list[str], progress: Progress
) -> tuple[Refinement, list[Model]]:
    """Refine; each rung of a network's ladder is trained as a hybrid, and a trained model is on the first as it was given.

    Args:
        asked: the model as it stands.
        before: its diagnosis.
        runs: fitted.
        check_runs: only predicted.
        add: names in order, or ``"auto"``.
        progress: told what is being done.

    Returns:
        The refinement and the model on each rung.
    """
    with _nothing_is_trained_after(asked):
        found = refine(runs, check_runs, asked.effects, add, asked.catalogue, progress, before)
    if asked.network is None:
        return _from_given(found, asked, check_runs)
    models: list[Model] = []
    for rung, solved in zip(found.record["ladder"], found.solutions, strict=True):
        progress(f"training {' + '.join(solved.names)}")
        model, found.record["parameters"] = _grown(asked, solved, runs)
        scores = score_runs(model, _on_cpu(runs), check_runs)
        rung.update(rms=scores["rms"], rms_check=scores["rms_check"])
        found.record["beyond"] = scores["beyond"]
        models.append(model)
    _judge(found.record)
    return found, models


def _from_given(found: Refinement, asked: Subject, check_runs: list[Run]) -> tuple[Refinement, list[Model]]:
    """A sum of effects and what was fitted on each rung; a trained one is on the first as it was given, judged as `diagnose` judges it."""
    models: list[Model] = [solved.model.cpu() for solved in found.solutions]
    given, record = asked.as_given, found.record
    if asked.saved is None or not isinstance(given, GrayBox):
        return found, models
    scores = score_runs(given, _on_cpu(found.diagnosis.bench.runs), check_runs)
    record["ladder"][0].update(rms=scores["rms"], rms_check=scores["rms_check"])
    if len(models) == 1:
        record["parameters"] = physical_values(asked.saved.facts) or {}
        _judge(record)
    return found, [given, *models[1:]]


def _judge(record: dict[str, Any]) -> None:
    """The refinement's verdict where its last rung is another than the fit: what is far from the noise, or not borne out, is not complete."""
    floor, last = record["noise_floor_check"], record["ladder"][-1]
    record["verdict_refitted"] = record["verdict"]
    record["borne_out"] = floor is None or last["rms_check"] <= CHECK_ALLOWED * floor
    if not record["borne_out"] or last["rms"] > CHECK_ALLOWED * record["noise_floor"]:
        record["verdict"] = "unknown"


def _grown(asked: Subject, solved: Solved, runs: Sequence[Run]) -> tuple[Model, dict[str, Any]]:
    """The network and the effects of one fit, trained on together from there, with their parameters; where nothing is new, the model as given."""
    from zoo.training.alternating import Alternating  # Lightning behind it takes seconds, which a sum of effects needs not wait for

    assert asked.network is not None
    linear = copy.deepcopy(solved.model).cpu()
    effects = {name: effect for name, effect in linear.named_effects() if name != asked.term}
    if asked.as_given is not None and len(solved.names) == len(asked.effects):
        return asked.as_given, {}
    hybrid = Hybrid(copy.deepcopy(asked.network), effects, linear.inputs, linear.in_motion)
    with torch.no_grad():
        hybrid.physics.coil_value.copy_(linear.coil_value)
    fitter = Alternating(draw=False)
    fitter.fit(hybrid, _on_cpu(runs), torch.Generator())
    return hybrid.eval(), fitter.physical(runs[0].unit)


def _on_cpu(runs: Sequence[Run]) -> list[Run]:
    return [run.to("cpu") for run in runs]


def model_config(config: DictConfig, asked: Subject, model: Model) -> dict[str, Any]:
    """A refined model as `create` takes it."""
    saved = None if asked.saved is None else _saved_config(asked.saved.folder)
    if saved is not None and not isinstance(model, GrayBox | Hybrid):
        return saved
    own: dict[str, Any] = (saved or {}).get("effects", {})
    given = {**plain(config.get("effects") or {}), **own}
    sum_of = model.physics if isinstance(model, Hybrid) else model
    assert isinstance(sum_of, GrayBox)
    effects = {name: given.get(name) or _of_catalogue(kind(name, effect)) for name, effect in sum_of.named_effects()}
    own_class = type(model)
    parts = {
        "_target_": f"{own_class.__module__}.{own_class.__qualname__}",
        "effects": effects,
        "inputs": sum_of.inputs,
        "in_motion": sum_of.in_motion,
    }
    if isinstance(model, Hybrid):
        assert saved is not None
        parts["network"] = saved.get("network", saved)
    return parts


def _of_catalogue(name: str) -> Any:
    """How an effect is made."""
    return plain(load("effects", name, searchpath())[name])


def _saved_config(folder: Path) -> dict[str, Any]:
    config: dict[str, Any] = plain(OmegaConf.load(folder / MODEL_FILE))
    return config
