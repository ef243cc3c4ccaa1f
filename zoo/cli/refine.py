"""The verb `refine`: adds effects, refits, and shows the error fall."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from omegaconf import DictConfig
from rich.console import Console

from zoo.ahead import Ahead
from zoo.artifacts import write_json
from zoo.cli.effects import named
from zoo.cli.given_model import subject
from zoo.cli.grown_model import climb, examine, model_config
from zoo.cli.inputs import read_data
from zoo.cli.next_commands import FITTED, compare_command, diagnose_command, next_commands, refine_words, stub_commands, typed_settings
from zoo.cli.saved_models import keep_model
from zoo.diagnosis.refine import Refinement, check_added
from zoo.models.base import Model
from zoo.models.prediction import usable_device
from zoo.report.page_ahead import page_ahead
from zoo.report.unknown_stub import stub_line, write_stub
from zoo.threads import threads_for


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
    with page_ahead() as page, console.status("reading") as status, threads_for(0):
        runs, check_runs = read_data(config)
        device = usable_device(config.torch_device)
        runs = [run.to(device) for run in runs]
        whole = subject(config, runs)
        asked = whole if wanted is None else subject(config, runs, wanted)
        check_added(runs, check_runs, asked.effects, wanted or [], asked.catalogue)
        before, seen = examine(whole, runs, status.update)
        asked = seen if wanted is None else asked
        found, models = climb(asked, before, runs, check_runs, add, status.update)
        status.update("drawing the report")
        record = before.record
        _report(page, out, record, found, models, check_runs)
        stub = write_stub(record, out)  # the page shows it
        keep_model(out, model_config(config, asked, models[-1]), models[-1], runs)
        path = write_json(out / "refinement.json", found.record)
    from zoo.report.terminal import print_ladder
    from zoo.report.verdict import worth_adding

    better = next_commands(worth_adding(found.record) or [])
    commands = [*better, *_what_is_left(found.record, record, wanted, out), compare_command(out, typed_settings())]
    print_ladder(found.record, commands, "" if check_runs else FITTED, diagnosis=record if wanted is None else None)
    if stub and wanted is None:
        print(stub_line(stub))
    print(f"report: {out / 'report.html'}")
    return path


def _what_is_left(refined: dict[str, Any], record: dict[str, Any], wanted: list[str] | None, out: Path) -> list[str]:
    """What to type where the ladder ends above the noise: with the class that was written, or to see what the effects that were asked for leave."""
    if refined["verdict"] == "complete":
        return []
    if wanted is None:
        return stub_commands(record, out)
    return [] if record.get("model") else [diagnose_command([*record["effects"], *wanted])]


def _report(page: Ahead, out: Path, record: dict[str, Any], found: Refinement, models: list[Model], check_runs: Any) -> None:
    from zoo.report.collect import traces  # matplotlib takes a second to import: only once there is something to draw
    from zoo.report.tensorboard import write_events

    base, refined = models[0], models[-1] if len(models) > 1 else None
    fitted = [run.to("cpu") for run in found.solutions[0].design.runs]
    # A network was trained anew on each rung, and a trained sum of effects is as it was given: neither leaves what the fit does.
    left = [found.solutions[i].residual if models[i] is found.solutions[i].model else None for i in (0, -1)]
    drawn = [*traces(fitted, "fit", base, refined, *left), *traces(check_runs, "check", base, refined)]
    page.begin(out / "report.html", record, drawn, found.record, refine=refine_words())
    write_events(out / "tensorboard", record, drawn, found.record)
    page.end()
