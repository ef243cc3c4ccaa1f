"""A paper's figures, redrawn: what was recorded, what every method makes of it, what it leaves."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from zoo.papers.study import BEFORE, Claim, Row, Study
from zoo.report.canvas import blank, curve, panel
from zoo.report.comparison_figure import COLORS, scaled
from zoo.report.palette import CHECK, MEASURED
from zoo.units import symbol

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT, HEAD, FOOT, INDENT = 740, 190, 48, 44, 12
NAMES, LINE = 190, 11
"""Of a figure of merit: room for the methods' names, height of a sample [px]."""


def figures(study: Study, rows: list[Row]) -> dict[str, Figure]:
    """All of them, by the name of their file."""
    unit = symbol(study.runs[0].unit)
    found = {"drift": drift_figure(study, unit)}
    for sample, run in enumerate(study.runs):
        found |= {f"fits_{run.name}": fits_figure(study, sample, unit), f"compensated_{run.name}": compensated_figure(study, sample, unit)}
    return found | table_figures(rows)


def table_figures(rows: list[Row]) -> dict[str, Figure]:
    """Every quantity of the table over the whole runs, by the name of its file."""
    quantities = dict.fromkeys(row.quantity for row in rows)
    return {re.sub(r"[^a-z]+", "_", quantity.lower()): table_figure(rows, quantity, "whole") for quantity in quantities}


def drift_figure(study: Study, unit: str) -> Figure:
    """The error against temperature, run by run."""
    figure = blank(WIDTH, HEAD + 280 + FOOT)
    axes = panel(figure, (62, HEAD, 664, 280), f"error before compensation [{unit}]", INDENT)
    for place, run in enumerate(study.runs):
        axes.plot(
            run.block_mean(run.temperature).numpy(), study.left[BEFORE][place][0].numpy(), lw=1.1, color=COLORS[place % len(COLORS)], label=run.name
        )
    axes.set_xlabel("Temperature [°C]")
    _legend(axes)
    return figure


def fits_figure(study: Study, sample: int, unit: str) -> Figure:
    """The error of one run and what every method predicts: median and 90 % band over the seeds."""
    figure = blank(WIDTH, HEAD + 280 + FOOT)
    run = study.runs[sample]
    axes = panel(figure, (62, HEAD, 664, 280), f"{run.name}: error and predictions [{unit}]", INDENT)
    hours, error = run.block_mean(run.time).numpy() / 3600, study.left[BEFORE][sample][0].numpy()
    axes.plot(*curve(hours, error), color=MEASURED, lw=2.4, label="measured")
    for place, name in enumerate(study.methods):
        _band(axes, hours, error - study.left[name][sample].numpy(), COLORS[place % len(COLORS)], name)
    axes.set_xlabel("Time [h]")
    _legend(axes)
    return figure


def compensated_figure(study: Study, sample: int, unit: str) -> Figure:
    """What every method leaves of one run, one panel a method, all to one scale."""
    run, names = study.runs[sample], study.methods
    step = HEIGHT + HEAD
    figure = blank(WIDTH, step * len(names) + FOOT)
    hours, error = run.block_mean(run.time).numpy() / 3600, study.left[BEFORE][sample][0].numpy()
    for place, name in enumerate(names):
        axes = panel(figure, (62, HEAD + place * step, 664, HEIGHT), f"{run.name} after {name} [{unit}]", INDENT)
        axes.plot(*curve(hours, error), color=MEASURED, lw=1.4)
        _band(axes, hours, study.left[name][sample].numpy(), COLORS[place % len(COLORS)], name)
    axes.set_xlabel("Time [h]")
    return figure


def table_figure(rows: list[Row], quantity: str, stage: str) -> Figure:
    """One figure of merit: a row a method, in it the samples from top to bottom, ours with its band and the paper's."""
    chosen = [row for row in rows if row.quantity == quantity and row.stage == stage]
    samples, models = (list(dict.fromkeys(getattr(row, key) for row in chosen)) for key in ("sample", "model"))
    step = LINE * (len(samples) + 1)
    figure = blank(WIDTH, 2 * HEAD + step * len(models))
    axes = panel(figure, (NAMES, HEAD + 24, WIDTH - NAMES - 24, step * len(models)))
    for row in chosen:
        y = models.index(row.model) + (samples.index(row.sample) - (len(samples) - 1) / 2) * LINE / step
        axes.plot([row.low, row.high], [y, y], color=COLORS[0], lw=4, alpha=0.35, solid_capstyle="butt")
        axes.plot(row.ours, y, "o", color=COLORS[0], ms=5, label="ours, 90 % range")
        if row.paper is not None:
            axes.plot(abs(row.paper), y, "D", mfc="none", color=CHECK, ms=6, label="paper")
    kind = scaled(axes.xaxis, [abs(value) for row in chosen for value in (row.low, row.high, row.ours, row.paper or row.ours)])
    title = f"{quantity}, {stage} [{chosen[0].unit}]: {', '.join(samples)}; {kind}"
    axes.annotate(title, (0, 1), (INDENT - NAMES, 34), "axes fraction", textcoords="offset points", fontsize=11, weight="bold")
    axes.set_yticks(range(len(models)), models)
    axes.set_ylim(len(models) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
    _legend(axes)
    return figure


def table_text(rows: list[Row], claims: list[Claim], words: str) -> str:
    """The table and the claims as Markdown, below what is said of the paper: its title, and what else there is to say."""
    title, *more = words.strip().splitlines()
    lines = [f"# {title}", *more, "", "| | found | |", "|---|---|---|"]
    lines += [f"| {claim.text} | {claim.value} | {'yes' if claim.holds else '**no**'} |" for claim in claims]
    for quantity in dict.fromkeys(row.quantity for row in rows):
        chosen = [row for row in rows if row.quantity == quantity]
        models = list(dict.fromkeys(row.model for row in chosen))
        lines += ["", f"## {quantity} [{chosen[0].unit}]", "", "Ours (the range that holds 90 %), and below it the paper's.", ""]
        lines += [f"| stage | sample | {' | '.join(models)} |", "|---" * (len(models) + 2) + "|"]
        for stage, sample in dict.fromkeys((row.stage, row.sample) for row in chosen):
            cells = {row.model: row for row in chosen if (row.stage, row.sample) == (stage, sample)}
            lines.append(f"| {stage} | {sample} | " + " | ".join(_cell(cells.get(model)) for model in models) + " |")
    return "\n".join([*lines, ""])


def _cell(row: Row | None) -> str:
    if row is None:
        return ""
    band = f" ({row.low:.4g} … {row.high:.4g})" if row.high > row.low else ""
    return f"{row.ours:.4g}{band}" + ("" if row.paper is None else f"<br>*{row.paper:.4g}*")


def _band(axes: Axes, hours: np.ndarray, values: np.ndarray, color: str, name: str) -> None:
    """Median over the seeds (E, N), and the band in which 90 % of them lie."""
    low, middle, high = np.quantile(values, (0.05, 0.5, 0.95), axis=0)
    if len(values) > 1:
        axes.fill_between(hours, low, high, color=color, alpha=0.25, lw=0)
    axes.plot(*curve(hours, middle), color=color, lw=1.1, label=name)


def _legend(axes: Axes) -> None:
    """Each label once, above the axes at the right."""
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    axes.legend(named.values(), named.keys(), loc="lower right", bbox_to_anchor=(1, 1.0), ncols=4)
