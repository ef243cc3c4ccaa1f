"""How the error falls as effects are added, and what the noise leaves; and the program of a chamber run."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

from zoo.report.canvas import blank, panel
from zoo.report.floors import Floors
from zoo.report.palette import CHECK, FIT, FLOOR, INK
from zoo.report.verdict import Rung
from zoo.report.wording import Scale, significant
from zoo.units import convert

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, ROW, LEFT = 740, 40, 190
LONGEST_NAME, LINES = 26, 2
"""Letters in a line of a step's name, and how many lines there are for it."""
SPREAD = 6.0
"""A wider range of values is drawn on a logarithmic axis."""
FITTED = (FIT, "o", "fitted runs")
CHECKED = (CHECK, "D", "check runs, not fitted")
"""Colour, marker and label of a series."""


def ladder_figure(rungs: list[Rung], scale: Scale, floors: Floors) -> Figure:
    """One row a rung, from the model as it stands to the model with everything added.

    Args:
        rungs: at least one.
        scale: how values are written.
        floors: noise floors of the fitted and of the check runs [output's unit].
    """
    figure = blank(WIDTH, 76 + ROW * len(rungs))
    axes = panel(figure, (LEFT, 38, WIDTH - LEFT - 70, ROW * len(rungs)))
    fitted, checked = floors.fitted, floors.checked
    for noise, style, label in ((fitted, "-", "noise floor"), (checked, ":", "of the check runs")):
        if noise and not (style == ":" and fitted and 0.9 < noise / fitted < 1.1):
            axes.axvline(noise * scale.factor, color=FLOOR, lw=1.6, ls=style, label=label, zorder=1)
    any_checked = any(rung.rms_check is not None for rung in rungs)
    _series(axes, [rung.rms for rung in rungs], FITTED, scale, floors.of("fit"), -8 if any_checked else 0)
    if any_checked:
        _series(axes, [rung.rms_check for rung in rungs], CHECKED, scale, floors.of("check"), 8)
    kind = _values(axes, [value * scale.factor for rung in rungs for value in (rung.rms, rung.rms_check, fitted, checked) if value])
    axes.annotate(f"RMS [{scale.label}], {kind}", (0, 1), (1 - LEFT, 10), "axes fraction", textcoords="offset points", fontsize=11, weight="bold")
    _rows(axes, rungs)
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), borderpad=0.9, ncols=4, handlelength=1.4)
    return figure


def _series(axes: Axes, values: list[float | None], look: tuple[str, str, str], scale: Scale, floor: float | None, offset: float) -> None:
    """Marks with their values beside them and a stem from the noise floor; two series keep apart vertically by some pixels."""
    color, marker, label = look
    known = [(value, i + offset / ROW) for i, value in enumerate(values) if value is not None]
    for value, y in known:
        x, start = value * scale.factor, (floor or value) * scale.factor
        axes.plot([start, x], [y, y], color=color, lw=3, alpha=0.35, solid_capstyle="butt")
        axes.annotate(scale.text(value), (max(x, start), y), (9, 0), textcoords="offset points", va="center", color=color, fontsize=11, zorder=4)
    xs, ys = [value * scale.factor for value, _ in known], [y for _, y in known]
    axes.plot(xs, ys, marker, color=color, ms=8, mec="white", mew=0.8, label=label, zorder=3)


def _values(axes: Axes, values: list[float]) -> str:
    """Sets the axis, and says what kind it is."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator

    if not values or max(values) / min(values) <= SPREAD:
        axes.set_xlim(0, 1.15 * max(values, default=1.0))
        return "linear axis"
    decades = max(values) / min(values) > 300
    axes.set_xscale("log")
    axes.set_xlim(min(values) / 1.35, max(values) * 1.5)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if decades else (1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: significant(value, 1)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_locator(FixedLocator([]))
    return "logarithmic axis"


def _rows(axes: Axes, rungs: list[Rung]) -> None:
    names = [f"+ {_short(rung.added)}" if rung.added else "as it stands" for rung in rungs]
    axes.set_yticks(range(len(rungs)), names, color=INK)
    axes.set_ylim(len(rungs) - 0.45, -0.55)
    axes.grid(visible=False, axis="y")


def _short(name: str) -> str:
    """A name in lines that fit beside the axis; only a word longer than a line is cut, or what no line is left for."""
    lines = textwrap.wrap(name, LONGEST_NAME, break_long_words=False)
    return "\n".join(_cut(line, i == LINES - 1 < len(lines) - 1) for i, line in enumerate(lines[:LINES]))


def _cut(line: str, more: bool) -> str:
    """A line that fits, with dots where something of it or after it is left out."""
    return f"{line[: LONGEST_NAME - 1]}…" if more or len(line) > LONGEST_NAME else line


def program_figure(legs: list[Any]) -> Figure:
    """Temperature against time of a chamber program.

    Args:
        legs: [[from °C, to °C, seconds], …].
    """
    figure = blank(WIDTH, 210)
    axes = panel(figure, (62, 34, 664, 124), "Chamber temperature [°C]")
    hours, temperatures, now = [], [], 0.0
    for start, end, seconds in legs:
        later = now + float(convert(float(seconds), "s", "h"))
        hours += [now, later]
        temperatures += [float(start), float(end)]
        now = later
    axes.plot(hours, temperatures, color=CHECK, lw=1.8)
    axes.set_xlim(0, now)
    axes.set_xlabel("Time [h]")
    return figure
