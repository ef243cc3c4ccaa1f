"""What the model leaves of one run, against temperature and against its rate: loops and slopes show what is missing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from zoo.report.canvas import DENSE, blank, panel
from zoo.report.palette import FLOOR, STAGES
from zoo.report.trace import Trace
from zoo.report.wording import Scale, Sides

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HIGH, FOOT = 380, 194, 48
HEAD, LEGEND = 34, 18
"""Above the panels: their titles, and over these a line for the legend [px]."""
LEFT, INNER, BETWEEN = 58, 308, 28


def residual_against_temperature(trace: Trace, scale: Scale, floor: float | None, sides: Sides) -> Figure:
    """A loop between heating and cooling is memory; a curve that both share is a static term."""
    figure = _scatter(trace, trace.temperature_c, "Temperature [°C]", scale, floor, sides, LEGEND)
    # One line for all panels, right above their titles, which are as long as the unit is.
    handles, labels = figure.axes[0].get_legend_handles_labels()
    corner = ((LEFT + INNER) / WIDTH, 1.0 - 2 / (HEAD + LEGEND + HIGH + FOOT))
    figure.legend(handles, labels, loc="upper right", bbox_to_anchor=corner, ncols=4, handletextpad=0.1, columnspacing=0.9, markerscale=1.4)
    return figure


def residual_against_rate(trace: Trace, scale: Scale, floor: float | None, sides: Sides) -> Figure:
    """A slope is a missing or wrong rate term; two branches are a delay."""
    return _scatter(trace, trace.rate_k_per_min, "Temperature rate [K/min]", scale, floor, sides)


def _scatter(trace: Trace, x: np.ndarray, label: str, scale: Scale, floor: float | None, sides: Sides, extra: int = 0) -> Figure:
    """One panel, or two on one scale where effects were added: before, and after."""
    top = HEAD + extra
    figure = blank(WIDTH, top + HIGH + FOOT)
    if trace.residual_after is None:
        axes = panel(figure, (LEFT, top, INNER, HIGH), f"Residual [{scale.label}]")
        _points(axes, trace, x, trace.residual * scale.factor, scale, floor)
        axes.set_xlabel(label)
        return figure
    wide = (INNER - BETWEEN) // 2
    first = panel(figure, (LEFT, top, wide, HIGH), f"Residual {sides.now} [{scale.label}]")
    second = panel(figure, (LEFT + wide + BETWEEN, top, wide, HIGH), sharex=first, sharey=first)
    second.set_title(sides.after, loc="right", fontsize=11, weight="bold", pad=10)
    second.tick_params(labelleft=False)
    _points(first, trace, x, trace.residual * scale.factor, scale, floor)
    _points(second, trace, x, trace.residual_after * scale.factor, scale, floor)
    figure.text((LEFT + INNER / 2) / WIDTH, 8 / (top + HIGH + FOOT), label, ha="center", va="baseline", color=first.xaxis.label.get_color())
    return figure


def _points(axes: Axes, trace: Trace, x: np.ndarray, y: np.ndarray, scale: Scale, floor: float | None) -> None:
    if floor:
        axes.axhspan(-floor * scale.factor, floor * scale.factor, color=FLOOR, alpha=0.18, lw=0)
    kinds = np.array(trace.stage)
    for kind, (color, marker) in STAGES.items():
        here = kinds == kind
        if here.any():
            size, edge = (2.6, 0.7) if kind == "edge" else (3.8, 0.0)
            axes.plot(x[here], y[here], marker, color=color, ms=size, mew=edge, alpha=0.65, label=kind, rasterized=len(x) > DENSE)
