"""The verb `refine`: adds effects, refits, and shows the error fall."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf
from rich.console import Console

from zoo.artifacts import write_json
from zoo.catalog import load, save_model
from zoo.cli.effects import catalogue, compare_command, model_effects, named, next_commands
from zoo.cli.inputs import read_data, searchpath
from zoo.diagnosis.diagnose import diagnose
from zoo.diagnosis.refine import Refinement, refine
from zoo.effects.base import Effect
from zoo.models.prediction import usable_device
from zoo.training.threads import threads_for


def run(config: DictConfig, out: Path) -> Path:
    """Refine, report, save the model.

    Args:
        config: as composed from conf/refine.yaml.
        out: folder of the results.

    Returns:
        The refinement as JSON; model.yaml and weights.pt lie beside it for `compare`, with report.html and TensorBoard events.
    """
    add = "auto" if config.add == "auto" else named("add", config.add, "auto")
    wanted = None if isinstance(add, str) else add
    console = Console(stderr=True)
    with console.status("reading") as status, threads_for(0):
        runs, check_runs = read_data(config)
        device = usable_device(config.torch_device)
        runs = [run.to(device) for run in runs]
        effects = model_effects(config)
        # All that the report's diagnosis will ask for as well: a wrong effect is refused before the work, not after it.
        candidates = catalogue(config)
        asked = candidates if wanted is None else catalogue(config, wanted)
        found = refine(runs, check_runs, effects, add, asked, status.update)
        status.update("drawing the report")
        record = _diagnosis(found, runs, effects, candidates, status.update)
        _report(out, record, found, check_runs)
        save_model(out, _model_config(config, found), found.model)
        path = write_json(out / "refinement.json", found.record)
    from zoo.report.terminal import print_ladder
    from zoo.report.verdict import worth_adding

    better = next_commands(worth_adding(found.record) or [])
    print_ladder(found.record, [*better, compare_command(out)])
    print(f"report: {out / 'report.html'}")
    return path


def _diagnosis(found: Refinement, runs: Any, effects: list[str], candidates: dict[str, Effect], progress: Any) -> dict[str, Any]:
    """The diagnosis that the report begins with: that of `add=auto`, else a new one of the model as it was."""
    if found.diagnosis is not None:
        return found.diagnosis.record
    return diagnose(runs, effects, candidates, progress).record


def _report(out: Path, record: dict[str, Any], found: Refinement, check_runs: Any) -> None:
    from zoo.report.collect import traces  # matplotlib takes a second to import: only once there is something to draw
    from zoo.report.page import write_report
    from zoo.report.tensorboard import write_events

    base = found.solutions[0].model.cpu()
    refined = found.model.cpu() if len(found.solutions) > 1 else None
    drawn = [*traces([run.to("cpu") for run in found.solutions[0].design.runs], "fit", base, refined), *traces(check_runs, "check", base, refined)]
    write_report(out / "report.html", record, drawn, found.record)
    write_events(out / "tensorboard", record, drawn, found.record)


def _model_config(config: DictConfig, found: Refinement) -> dict[str, Any]:
    """The fitted grey box as `create` takes it."""
    effects = {}
    for name, _ in found.model.named_effects():
        own = config.effects.get(name)
        effects[name] = OmegaConf.to_container(own if own is not None else load("effects", name, searchpath())[name], resolve=True)
    return {"_target_": "zoo.models.graybox.GrayBox", "effects": effects, "inputs": found.model.inputs, "in_motion": found.model.in_motion}
