"""The verb `diagnose`: compares the model with measurements and names what is missing."""

from __future__ import annotations

from pathlib import Path

from omegaconf import DictConfig
from rich.console import Console

from zoo.artifacts import write_json
from zoo.cli.given_model import subject
from zoo.cli.grown_model import examine
from zoo.cli.inputs import read_data
from zoo.cli.next_commands import form_is_better, next_commands, refine_words, save_command, stub_commands
from zoo.models.prediction import usable_device
from zoo.report.page_ahead import page_ahead
from zoo.report.unknown_stub import stub_line, write_stub
from zoo.threads import threads_for


def run(config: DictConfig, out: Path) -> Path:
    """Diagnose and report.

    Args:
        config: as composed from conf/diagnose.yaml.
        out: folder of the results.

    Returns:
        The diagnosis as JSON; report.html and TensorBoard events lie beside it, and where nothing explains the runs, a class to start from.
    """
    console = Console(stderr=True)
    with page_ahead() as page, console.status("reading") as status, threads_for(0):
        runs, check_runs = read_data(config)
        device = usable_device(config.torch_device)
        runs = [run.to(device) for run in runs]
        found, asked = examine(subject(config, runs), runs, status.update)
        status.update("drawing the report")
        from zoo.report.collect import traces  # matplotlib takes a second to import: only once there is something to draw
        from zoo.report.tensorboard import write_events
        from zoo.report.terminal import print_diagnosis

        first, last = found.search.as_it_stands, found.search.final
        base, refined = asked.as_given or first.model.cpu(), last.model.cpu() if found.search.missing else None
        fitted, left = [run.to("cpu") for run in found.bench.runs], None if asked.as_given else first.residual
        drawn = [*traces(fitted, "fit", base, refined, left, last.residual), *traces(check_runs, "check", base, refined)]
        stub = write_stub(found.record, out)
        known, own = next_commands(found.record["missing"]), stub_commands(found.record, out)
        commands = [*own, *known] if form_is_better(found.record) else [*known, *own]
        if found.record["verdict"] == "complete" and asked.saved is None:
            commands = [save_command()]
        page.begin(out / "report.html", found.record, drawn, commands=commands, refine=refine_words())
        write_events(out / "tensorboard", found.record, drawn)
        page.end()
        path = write_json(out / "diagnosis.json", found.record)
    print_diagnosis(found.record, commands)
    if stub:
        print(stub_line(stub))
    print(f"report: {out / 'report.html'}")
    return path
