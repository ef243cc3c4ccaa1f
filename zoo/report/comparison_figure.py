"""Models side by side: RMS by stage as bars, what each leaves of a run as curves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.report.canvas import blank, curve, panel
from zoo.report.palette import MEASURED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#1d2733", "#F0E442")
"""Okabe & Ito (2008); the uncompensated error is grey."""
OTHERS = "#dfe4e9"
"""Where there are more models than colours, the best are coloured."""
WIDTH, HEIGHT, HEAD, FOOT, INDENT = 740, 150, 40, 16, 12
LETTER, HANDLE = 7, 46
"""Width of an entry of the legend: so much a letter, and so much for its mark [px]."""


def colors_of(pooled: dict[str, float]) -> dict[str, str]:
    """A colour for every column, no two alike but those of the models that are not among the best.

    Args:
        pooled: RMS over all runs by column, the uncompensated error first.
    """
    first, *models = pooled
    best = sorted(models, key=lambda name: pooled[name])[: len(COLORS)]
    coloured = dict(zip((name for name in models if name in best), COLORS, strict=False))
    return {first: MEASURED} | {name: coloured.get(name, OTHERS) for name in models}


def rms_figure(rows: list[dict[str, Any]], pooled: dict[str, float], unit: str) -> Figure:
    """Bars: one panel a run, one group a stage, one bar a model.

    Args:
        rows: ``{"run": ..., "stage": ..., COLUMN: rms [output's unit]}``.
        pooled: RMS over all runs by column, the uncompensated error first [output's unit].
        unit: the output's unit as usually written.
    """
    runs, colors = list(dict.fromkeys(row["run"] for row in rows)), colors_of(pooled)
    head = HEAD + _legend_height(colors)
    figure = blank(WIDTH, head + (HEIGHT + HEAD + FOOT) * len(runs))
    for index, run in enumerate(runs):
        axes = panel(figure, (62, head + index * (HEIGHT + HEAD + FOOT), 664, HEIGHT), f"{run}: RMS of the error [{unit}]", INDENT)
        chosen = [row for row in rows if row["run"] == run]
        for place, (column, color) in enumerate(colors.items()):
            offset = (place - (len(colors) - 1) / 2) * 0.8 / len(colors)
            axes.bar(np.arange(len(chosen)) + offset, [row[column] for row in chosen], 0.8 / len(colors), color=color)
        axes.set_xticks(range(len(chosen)), [row["stage"] for row in chosen])
        axes.grid(visible=False, axis="x")
    _legend(figure, colors, thick=8)
    return figure


def residual_figure(run: str, hours: np.ndarray, left: dict[str, np.ndarray], unit: str, colors: dict[str, str]) -> Figure:
    """Curves: what every model leaves of one run, and the error without any.

    Args:
        run: its name.
        hours: (N,) [h].
        left: (N,) residual by column [output's unit], the uncompensated error first.
        unit: the output's unit as usually written.
        colors: by column, see `colors_of`.
    """
    head = HEAD + _legend_height(colors)
    figure = blank(WIDTH, head + 300)
    axes = panel(figure, (62, head, 664, 250), f"{run}: what is left of the error [{unit}]", INDENT)
    for place, (name, value) in enumerate(left.items()):
        axes.plot(*curve(hours, value), color=colors[name], lw=1.6 if place == 0 else 1.1, zorder=1.9 if colors[name] == OTHERS else 2)
    axes.set_xlabel("Time [h]")
    _legend(figure, colors, thick=2)
    return figure


def _entries(colors: dict[str, str]) -> dict[str, str]:
    """What the legend names: every column with a colour of its own, and the others together."""
    others = sum(color == OTHERS for color in colors.values())
    together = {f"{others} others": OTHERS} if others else {}
    return {name: color for name, color in colors.items() if color != OTHERS} | together


def _legend_columns(colors: dict[str, str]) -> int:
    longest = max(len(name) for name in _entries(colors))
    return max(1, min(4, len(_entries(colors)), WIDTH // (LETTER * longest + HANDLE)))


def _legend_height(colors: dict[str, str]) -> int:
    return 18 * -(-len(_entries(colors)) // _legend_columns(colors))


def _legend(figure: Figure, colors: dict[str, str], thick: int) -> None:
    from matplotlib.lines import Line2D

    entries = _entries(colors)
    marks = [Line2D([], [], color=color, lw=thick, solid_capstyle="butt") for color in entries.values()]
    figure.legend(marks, list(entries), loc="upper right", ncols=_legend_columns(colors), borderaxespad=0.6)
