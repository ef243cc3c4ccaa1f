"""The verb `diagnose`: compares the model with measurements and names what is missing."""

from __future__ import annotations

from pathlib import Path

from omegaconf import DictConfig
from rich.console import Console

from zoo.artifacts import write_json
from zoo.cli.effects import catalogue, model_effects, next_commands
from zoo.cli.inputs import read_data
from zoo.diagnosis.diagnose import diagnose
from zoo.models.prediction import usable_device
from zoo.training.threads import threads_for


def run(config: DictConfig, out: Path) -> Path:
    """Diagnose and report.

    Args:
        config: as composed from conf/diagnose.yaml.
        out: folder of the results.

    Returns:
        The diagnosis as JSON; report.html and TensorBoard events lie beside it.
    """
    console = Console(stderr=True)
    with console.status("reading") as status, threads_for(0):
        runs, check_runs = read_data(config)
        device = usable_device(config.torch_device)
        found = diagnose([run.to(device) for run in runs], model_effects(config), catalogue(config), status.update)
        status.update("drawing the report")
        from zoo.report.collect import traces  # matplotlib takes a second to import: only once there is something to draw
        from zoo.report.page import write_report
        from zoo.report.tensorboard import write_events
        from zoo.report.terminal import print_diagnosis

        base, final = found.search.base.model.cpu(), found.search.final.model.cpu()
        refined = final if found.search.missing else None
        drawn = [*traces([run.to("cpu") for run in found.bench.runs], "fit", base, refined), *traces(check_runs, "check", base, refined)]
        commands = next_commands(found.search.missing)
        write_report(out / "report.html", found.record, drawn, commands=commands)
        write_events(out / "tensorboard", found.record, drawn)
        path = write_json(out / "diagnosis.json", found.record)
    print_diagnosis(found.record, commands)
    print(f"report: {out / 'report.html'}")
    return path
