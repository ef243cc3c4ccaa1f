"""The figures of a rate table in a chamber: the error over the rate at every temperature, and what every method leaves of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.papers.study import Row, Study
from zoo.report.canvas import blank, panel
from zoo.report.merit_figure import merit_figures
from zoo.report.palette import MUTED
from zoo.scoring.comparison import UNCOMPENSATED
from zoo.units import convert

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEAD, FOOT, INDENT, LEFT, WIDE = 740, 48, 44, 12, 62, 578
BAR = (676, 12)
"""The scale of temperatures: its left end and its width [px]."""
COLD_TO_WARM = "coolwarm"


def figures(study: Study, rows: list[Row]) -> dict[str, Figure]:
    """All of them, by the name of their file."""
    return {"error": error_figure(study), "compensated": compensated_figure(study), **merit_figures(rows)}


def error_figure(study: Study) -> Figure:
    """The error before compensation, all points."""
    figure = blank(WIDTH, HEAD + 320 + FOOT)
    _points(figure, study, UNCOMPENSATED, (LEFT, HEAD, WIDE, 320), "error before compensation [°/s]")
    return figure


def compensated_figure(study: Study) -> Figure:
    """What every method leaves of the points that were not fitted: the median over its seeds, each method to its own scale."""
    high = 150
    figure = blank(WIDTH, (high + HEAD) * len(study.methods) + FOOT)
    for place, name in enumerate(study.methods):
        _points(figure, study, name, (LEFT, HEAD + place * (high + HEAD), WIDE, high), f"points not fitted, after {name} [°/s]", study.fitted)
    return figure


def _points(figure: Figure, study: Study, model: str, box: tuple[int, int, int, int], title: str, first: int = 0) -> None:
    """One method's residuals over the rate, coloured by temperature, with the scale of colours at the side; runs from `first` on."""
    chosen = range(first, len(study.runs))
    reference = np.concatenate([_rate(study, one) for one in chosen])
    temperature = np.concatenate([study.runs[one].block_mean(study.runs[one].temperature).numpy() for one in chosen])
    left = np.concatenate([_dps(study, study.left[model][one].median(dim=0).values.numpy()) for one in chosen])
    axes = panel(figure, box, title, INDENT)
    shown: Any = axes.scatter(reference, left, c=temperature, cmap=COLD_TO_WARM, s=11, lw=0)
    if box[1] + box[3] + FOOT + 1 > figure.get_size_inches()[1] * figure.dpi:
        axes.set_xlabel("True rate [°/s]")
    bar = panel(figure, (BAR[0], box[1], BAR[1], box[3]))
    bar.grid(visible=False)
    figure.colorbar(shown, cax=bar).outline.set_visible(False)
    bar.annotate("°C", (0.5, 1), (0, 6), "axes fraction", textcoords="offset points", ha="center", color=MUTED)


def _rate(study: Study, place: int) -> np.ndarray:
    run = study.runs[place]
    return _dps(study, run.block_mean(run.column(f"reference_{run.unit}")).numpy())


def _dps(study: Study, values: np.ndarray) -> np.ndarray:
    return np.asarray(convert(values, study.runs[0].unit, "dps"))
