"""The figures of a power-on in the cold: the error over the rise of temperature, what every method leaves of it, and the attitude that follows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from zoo.papers.hui2016 import KNOWN, WANTED_DEG, levelled
from zoo.papers.study import Row, Study
from zoo.report.canvas import blank, panel
from zoo.report.comparison_figure import COLORS, scaled
from zoo.report.merit_figure import merit_figures
from zoo.report.palette import FLOOR, MEASURED
from zoo.scoring.comparison import UNCOMPENSATED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEAD, FOOT, INDENT, LEFT, WIDE = 740, 48, 44, 12, 82, 644
HIGH = 130
NAMES, ROW = 210, 34
BANDS = 4.0
"""How far a band is drawn, in largest values of the median."""


def figures(study: Study, rows: list[Row]) -> dict[str, Figure]:
    """All of them, by the name of their file."""
    found = {"fits": fits_figure(study), "left": left_figure(study), **merit_figures(rows)}
    if study.others:
        found |= {"attitude": attitude_figure(study), "units": units_figure(study)}
    return found


def fits_figure(study: Study) -> Figure:
    """The fitted error over the temperature, and what every method makes of it: the median over its seeds."""
    figure = blank(WIDTH, HEAD + 320 + FOOT)
    axes = panel(figure, (LEFT, HEAD, WIDE, 320), "error and predictions [pulses]", INDENT)
    temperature, error = _temperature(study), study.left[UNCOMPENSATED][0][0].numpy()
    axes.plot(temperature, error, "o", color=MEASURED, ms=6, label="measured")
    for place, name in enumerate(study.methods):
        predicted = error - study.left[name][0].median(dim=0).values.numpy()
        axes.plot(temperature, predicted, color=COLORS[place % len(COLORS)], lw=1.2, label=name)
    axes.set_xlabel("Temperature [°C]")
    axes.legend(loc="best")
    return figure


def left_figure(study: Study) -> Figure:
    """What every method leaves of the fitted counts, median and 90 % of the seeds as far as it fits, each to its own scale."""
    figure = blank(WIDTH, (HIGH + HEAD) * len(study.methods) + FOOT)
    temperature = _temperature(study)
    for place, name in enumerate(study.methods):
        axes = panel(figure, (LEFT, HEAD + place * (HIGH + HEAD), WIDE, HIGH), f"fitted counts, after {name} [pulses]", INDENT)
        low, middle, high = np.quantile(study.left[name][0].numpy(), (0.05, 0.5, 0.95), axis=0)
        color = COLORS[place % len(COLORS)]
        axes.fill_between(temperature, low, high, color=color, alpha=0.25, lw=0)
        axes.plot(temperature, middle, color=color, lw=1.2)
        # A training that has failed would hide all the others.
        reach = BANDS * float(np.abs(middle).max())
        axes.set_ylim(max(-reach, 1.1 * float(low.min())), min(reach, 1.1 * float(high.max())))
        axes.ticklabel_format(axis="y", style="plain")
    axes.set_xlabel("Temperature [°C]")
    return figure


def attitude_figure(study: Study) -> Figure:
    """Pitch and roll of the first unit over the minutes of its second power-on, and what was wanted."""
    figure = blank(WIDTH, 2 * (200 + HEAD) + FOOT)
    minutes = study.runs[0].block_mean(study.runs[0].time).numpy() / 60
    both = {name: levelled(study, name)[1][0].numpy() for name in study.methods}
    for place, angle in enumerate(("pitch", "roll")):
        axes = panel(figure, (LEFT, HEAD + place * (200 + HEAD), WIDE, 200), f"unit 1: error of {angle} [°]", INDENT)
        for number, (name, angles) in enumerate(both.items()):
            axes.plot(minutes, angles[place], color=COLORS[number % len(COLORS)], lw=1.3, label=name)
        for sign in (-1, 1):
            axes.axhline(sign * WANTED_DEG, color=FLOOR, lw=1.2, ls="--", label=f"{WANTED_DEG}°")
    axes.set_xlabel("Time since power-on [min]")
    _legend_above(figure, axes)
    return figure


def units_figure(study: Study) -> Figure:
    """The largest attitude error of every unit: a row a method, a point a unit."""
    names = [*study.methods, KNOWN]
    figure = blank(WIDTH, HEAD + ROW * len(names) + FOOT)
    axes = panel(figure, (NAMES, HEAD, WIDTH - NAMES - 20, ROW * len(names)))
    everything: list[float] = [WANTED_DEG]
    for place, name in enumerate(names):
        most = np.sort(levelled(study, name)[1].abs().amax((1, 2)).numpy())
        everything += most.tolist()
        lift = 0.5 * ((np.arange(len(most)) * 0.618034) % 1.0 - 0.5)
        axes.plot(most, place + lift, "o", color=COLORS[place % len(COLORS)] if name != KNOWN else FLOOR, ms=3.5, mew=0, alpha=0.6)
    axes.axvline(WANTED_DEG, color=FLOOR, lw=1.2, ls="--")
    title = f"largest attitude error of each unit [°], {scaled(axes.xaxis, everything)}; wanted: {WANTED_DEG}"
    axes.annotate(title, (0, 1), (INDENT - NAMES, 10), "axes fraction", textcoords="offset points", fontsize=11, weight="bold")
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
    return figure


def _temperature(study: Study) -> np.ndarray:
    return study.runs[0].block_mean(study.runs[0].temperature).numpy()


def _legend_above(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    figure.legend(named.values(), named.keys(), loc="upper right", ncols=3, borderaxespad=0.4)
