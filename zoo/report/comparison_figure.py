"""Models side by side: RMS by stage as bars, what each leaves of a run as curves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.report.canvas import blank, panel, thinned
from zoo.report.palette import MEASURED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#1d2733", "#F0E442")
"""Okabe & Ito (2008); the uncompensated error is grey."""
WIDTH, HEIGHT, HEAD = 740, 150, 40


def rms_figure(rows: list[dict[str, Any]], columns: list[str], unit: str) -> Figure:
    """Bars: one panel a run, one group a stage, one bar a model.

    Args:
        rows: ``{"run": ..., "stage": ..., COLUMN: rms [output's unit]}``.
        columns: the uncompensated error first, then the models.
        unit: the output's unit as usually written.
    """
    runs = list(dict.fromkeys(row["run"] for row in rows))
    head = HEAD + 18 * -(-len(columns) // 4)
    figure = blank(WIDTH, head + (HEIGHT + HEAD) * len(runs))
    for index, run in enumerate(runs):
        axes = panel(figure, (62, head + index * (HEIGHT + HEAD), 664, HEIGHT), f"{run}: RMS of the error [{unit}]")
        chosen = [row for row in rows if row["run"] == run]
        for place, column in enumerate(columns):
            offset = (place - (len(columns) - 1) / 2) * 0.8 / len(columns)
            axes.bar(np.arange(len(chosen)) + offset, [row[column] for row in chosen], 0.8 / len(columns), color=_color(place), label=column)
        axes.set_xticks(range(len(chosen)), [row["stage"] for row in chosen])
        axes.grid(visible=False, axis="x")
    figure.legend(*axes.get_legend_handles_labels(), loc="upper right", ncols=min(len(columns), 4), borderaxespad=0.6)
    return figure


def residual_figure(run: str, hours: np.ndarray, left: dict[str, np.ndarray], unit: str) -> Figure:
    """Curves: what every model leaves of one run, and the error without any.

    Args:
        run: its name.
        hours: (N,) [h].
        left: (N,) residual by column [output's unit], the uncompensated error first.
        unit: the output's unit as usually written.
    """
    head = HEAD + 18 * -(-len(left) // 4)
    figure = blank(WIDTH, head + 300)
    axes = panel(figure, (62, head, 664, 250), f"{run}: what is left of the error [{unit}]")
    for place, (name, value) in enumerate(left.items()):
        axes.plot(*thinned(hours, value), color=_color(place), lw=1.6 if place == 0 else 1.1, label=name)
    axes.set_xlabel("Time [h]")
    figure.legend(*axes.get_legend_handles_labels(), loc="upper right", ncols=min(len(left), 4), borderaxespad=0.6)
    return figure


def _color(place: int) -> str:
    return MEASURED if place == 0 else COLORS[(place - 1) % len(COLORS)]
