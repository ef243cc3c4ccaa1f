"""One recording before and after a model was subtracted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from zoo.report.canvas import blank, curve, panel
from zoo.report.palette import FIT, MEASURED, REFINED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT, HEAD, FOOT, INDENT = 740, 180, 40, 40, 12


def compensation_figure(name: str, hours: np.ndarray, error: np.ndarray, predicted: np.ndarray, unit: str) -> Figure:
    """The error with its prediction, and what is left of it.

    Args:
        name: the recording.
        hours: (N,) time [h].
        error: (N,) output − true input [output's unit].
        predicted: (N,) by the model [output's unit].
        unit: the output's unit as usually written.
    """
    figure = blank(WIDTH, 2 * (HEIGHT + HEAD) + FOOT)
    above = panel(figure, (62, HEAD, 664, HEIGHT), f"{name}: error [{unit}]", INDENT)
    above.plot(*curve(hours, error), color=MEASURED, lw=1.6, label="recorded")
    above.plot(*curve(hours, predicted), color=FIT, lw=1.1, label="predicted")
    below = panel(figure, (62, HEIGHT + 2 * HEAD, 664, HEIGHT), f"what is left [{unit}]", INDENT)
    below.plot(*curve(hours, error - predicted), color=REFINED, lw=1.1, label="compensated")
    below.axhline(0.0, color=MEASURED, lw=0.8, zorder=1)
    for axes in (above, below):
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), ncols=2)
    below.set_xlabel("Time [h]")
    return figure
