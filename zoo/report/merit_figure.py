"""Figures of merit whose methods are orders of magnitude apart: a row a method, the paper's beside ours."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from zoo.papers.study import Row
from zoo.report.canvas import blank, panel
from zoo.report.comparison_figure import COLORS, scaled
from zoo.report.palette import CHECK
from zoo.scoring.comparison import WHOLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEAD, INDENT = 740, 48, 12
NAMES, LINE = 190, 11
"""Room for the methods' names, height of a sample [px]."""


def merit_figures(rows: list[Row]) -> dict[str, Figure]:
    """Every quantity of the table over the whole runs, by the name of its file."""
    quantities = dict.fromkeys(row.quantity for row in rows)
    return {re.sub(r"[^a-z]+", "_", quantity.lower()): merit_figure(rows, quantity) for quantity in quantities}


def merit_figure(rows: list[Row], quantity: str) -> Figure:
    """One figure of merit: a row a method, in it the samples from top to bottom, ours with its band and the paper's."""
    chosen = [row for row in rows if row.quantity == quantity and row.stage == WHOLE]
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
    title = f"{quantity} [{chosen[0].unit}]: {', '.join(samples)}; {kind}"
    axes.annotate(title, (0, 1), (INDENT - NAMES, 34), "axes fraction", textcoords="offset points", fontsize=11, weight="bold")
    axes.set_yticks(range(len(models)), models)
    axes.set_ylim(len(models) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    axes.legend(named.values(), named.keys(), loc="lower right", bbox_to_anchor=(1, 1.0), ncols=len(named))
    return figure
