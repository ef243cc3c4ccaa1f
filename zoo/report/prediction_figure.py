"""Measured and predicted error of several runs against time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from zoo.report.canvas import blank, curve, panel
from zoo.report.palette import FIT, MEASURED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT, HEAD, FOOT, INDENT = 740, 150, 40, 40, 12


@dataclass(frozen=True, eq=False)
class Prediction:
    """One run's block means.

    Attributes:
        name: the run.
        hours: (N,) time [h].
        measured: (N,) error [output's unit].
        predicted: (N,) by the model [output's unit].
    """

    name: str
    hours: np.ndarray
    measured: np.ndarray
    predicted: np.ndarray


def prediction_figure(predictions: list[Prediction], unit: str) -> Figure:
    """One panel a run.

    Args:
        predictions: the runs, top down.
        unit: the output's unit as usually written.
    """
    step = HEIGHT + HEAD
    figure = blank(WIDTH, step * len(predictions) + FOOT)
    for index, one in enumerate(predictions):
        axes = panel(figure, (62, HEAD + index * step, 664, HEIGHT), f"{one.name}: error [{unit}]", INDENT)
        axes.plot(*curve(one.hours, one.measured), color=MEASURED, lw=2.4, label="measured")
        axes.plot(*curve(one.hours, one.predicted), color=FIT, lw=1.1, label="predicted")
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), ncols=2)
    axes.set_xlabel("Time [h]")
    return figure
