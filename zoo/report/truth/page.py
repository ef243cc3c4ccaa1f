"""The self-contained page with the truth about a simulated gyro: how it is wound, where it is warm, what each effect adds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from markupsafe import Markup

from zoo import __version__
from zoo.artifacts import write_text
from zoo.report.canvas import inline_svg
from zoo.report.palette import styled
from zoo.report.template import filled
from zoo.report.truth import tables
from zoo.report.truth.effect_figure import colors_of, effect_figure
from zoo.report.truth.effect_stack import Parts, parts_of, ranked
from zoo.report.truth.effect_trace import trace_of
from zoo.report.truth.heat_figure import heat_figure
from zoo.report.truth.winding_figure import winding_figure
from zoo.report.truth.winding_heat import pictured, snapshots
from zoo.report.truth.words import at_rest, sentences, tiles, winding_text
from zoo.simulator.recorded import Recorded
from zoo.simulator.simulation import Simulation

PAGE = "truth.html"
RUNS_DRAWN = 8
"""More runs make the page slow; the first and the check run are drawn."""


@dataclass(frozen=True)
class RunDrawing:
    """One run's picture and what is said of it."""

    name: str
    role: str
    caption: str
    figure: Markup


def write_truth_page(simulation: Simulation, folder: str | Path) -> Path:
    """Write ``truth.html`` beside the files of the truth, whole or not at all.

    Args:
        simulation: a gyro's runs.
        folder: where its files are.

    Returns:
        The page.
    """
    return write_text(Path(folder) / PAGE, render(simulation))


def render(simulation: Simulation) -> str:
    """The page as text."""
    runs, truth = [*simulation.runs, simulation.check], simulation.truth()
    parts = {run.name: parts_of(run, simulation.settings.cold_start) for run in runs}
    order = ranked(list(parts.values()))
    drawn = runs if len(runs) <= RUNS_DRAWN else [*runs[: RUNS_DRAWN - 1], simulation.check]
    context = {
        "headline": f"The truth about the {simulation.name} gyro with seed {simulation.seed}",
        "sentences": list(sentences(simulation)),
        "tiles": list(tiles(simulation)),
        "winding_text": list(winding_text(simulation)),
        "winding": _winding(simulation),
        "heated": pictured(simulation).name,
        "heat": _heat(simulation),
        "rest": "in the last row, as the gyro was switched on in the first" if simulation.settings.cold_start else "in the first row, soaked",
        "runs": [_run(simulation, run, parts[run.name], order, number) for number, run in enumerate(drawn)],
        "undrawn": [run.name for run in runs if run not in drawn],
        "order": order,
        "run_rows": tables.run_rows(simulation, order),
        "effects": tables.effect_rows(simulation),
        "gyro": simulation.name,
        "device_rows": tables.device_rows(simulation.device),
        "noise_rows": tables.noise_rows(truth),
        "thermometer_rows": tables.thermometer_rows(truth),
        "setting_rows": tables.setting_rows(truth),
        "written": datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %Z"),
        "version": __version__,
    }
    return filled("truth.html.j2", context)


def _winding(simulation: Simulation) -> Markup:
    gyro = simulation.device.gyro
    with styled("winding"):
        figure = winding_figure(simulation.device.winding)
        return inline_svg(figure, f"Cross-section of a {gyro.pattern} winding of {gyro.layers} layers, and the weight of each layer")


def _heat(simulation: Simulation) -> Markup:
    shown = snapshots(simulation)
    with styled("heat"):
        what = "; ".join(one.label for one in shown.moments)
        return inline_svg(heat_figure(shown, simulation.device.winding), f"Temperature in the cross-section of the winding: {what}")


def _run(simulation: Simulation, run: Recorded, parts: Parts, order: Sequence[str], number: int) -> RunDrawing:
    trace = trace_of(run, parts, order, simulation.settings.places)
    with styled(f"e{number}"):
        drawn = inline_svg(effect_figure(trace, colors_of(order)), f"{run.name}: what each effect adds to the output over time")
    return RunDrawing(run.name, "check run" if run is simulation.check else "to be fitted", at_rest(parts), drawn)
