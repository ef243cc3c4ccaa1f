"""What the model leaves of one run, against temperature and against its rate: loops and slopes show what is missing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from zoo.report.canvas import DENSE, blank, panel
from zoo.report.palette import FLOOR, STAGES
from zoo.report.trace import Trace
from zoo.report.wording import Scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 380, 276
BOX = (58, 34, 308, 194)


def residual_against_temperature(trace: Trace, scale: Scale, floor: float | None) -> Figure:
    """A loop between heating and cooling is memory; a curve that both share is a static term."""
    figure, axes = _scatter(trace, trace.temperature_c, scale, floor)
    axes.set_xlabel("Temperature [°C]")
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), ncols=4, borderpad=0.35, handletextpad=0.1, columnspacing=0.9, markerscale=1.4)
    return figure


def residual_against_rate(trace: Trace, scale: Scale, floor: float | None) -> Figure:
    """A slope is a missing or wrong rate term; two branches are a delay."""
    figure, axes = _scatter(trace, trace.rate_k_per_min, scale, floor)
    axes.set_xlabel("Temperature rate [K/min]")
    return figure


def _scatter(trace: Trace, x: np.ndarray, scale: Scale, floor: float | None) -> tuple[Figure, Axes]:
    figure = blank(WIDTH, HEIGHT)
    axes = panel(figure, BOX, f"Residual [{scale.label}]")
    if floor:
        axes.axhspan(-floor * scale.factor, floor * scale.factor, color=FLOOR, alpha=0.18, lw=0)
    kinds, y = np.array(trace.stage), trace.residual * scale.factor
    for kind, (color, marker) in STAGES.items():
        here = kinds == kind
        if here.any():
            size, edge = (2.6, 0.7) if kind == "edge" else (3.8, 0.0)
            axes.plot(x[here], y[here], marker, color=color, ms=size, mew=edge, alpha=0.65, label=kind, rasterized=len(x) > DENSE)
    return figure, axes
