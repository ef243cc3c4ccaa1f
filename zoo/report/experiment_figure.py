"""A proposed run: temperature and true input against time, and what two explanations would come to differ by."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any

from zoo.report.canvas import blank, panel
from zoo.report.palette import CHECK, FIT, INK, MUTED, RULE
from zoo.report.wording import Scale
from zoo.units import convert

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CURVES = ("time_s", "temperature_c", "reference", "difference")
WIDTH, LEFT, RIGHT, TOP, HIGH, LOW, APART = 740, 62, 14, 34, 116, 64, 56


def experiment_figure(curves: dict[str, Any], scale: Scale, legs: Sequence[Sequence[float]] = ()) -> Figure:
    """Two panels, three where the true input changes.

    Args:
        curves: lists of equal length by name, see `CURVES`, and ``compared``, the names of both explanations.
        scale: how the output's values are written.
        legs: the chamber's program, from °C, to °C, seconds.
    """
    hours = [float(convert(value, "s", "h")) for value in curves["time_s"]]
    reference = [value * scale.factor for value in curves["reference"]]
    turned = max(reference) > min(reference)
    heights = [HIGH, *([LOW] if turned else []), HIGH]
    figure = blank(WIDTH, TOP + sum(heights) + APART * (len(heights) - 1) + 42)
    titles = ["Temperature [°C]", f"True input [{scale.label}]", _title(curves, scale)]
    rows = _panels(figure, heights, titles if turned else titles[::2])
    _draw_program(rows[0], legs)
    rows[0].plot(hours, curves["temperature_c"], color=CHECK, lw=1.8, label="thermometer, as expected")
    rows[0].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
    if turned:
        rows[1].step(hours, reference, color=INK, lw=1.2, where="mid")
    rows[-1].axhline(0.0, color=RULE, lw=1.2)
    rows[-1].plot(hours, [value * scale.factor for value in curves["difference"]], color=FIT, lw=1.4)
    for axes in rows:
        axes.set_xlim(0.0, hours[-1])
    rows[-1].set_xlabel("Time [h]")
    return figure


def _draw_program(axes: Axes, legs: Sequence[Sequence[float]]) -> None:
    """What the chamber is asked for."""
    if not legs:
        return
    ends = [0.0, *accumulate(float(convert(leg[2], "s", "h")) for leg in legs)]
    times = [time for begin, end in pairwise(ends) for time in (begin, end)]
    axes.plot(times, [value for leg in legs for value in leg[:2]], color=MUTED, lw=1.0, label="chamber")


def _panels(figure: Figure, heights: list[int], titles: list[str]) -> list[Axes]:
    top, made = TOP, []
    for height, title in zip(heights, titles, strict=True):
        made.append(panel(figure, (LEFT, top, WIDTH - LEFT - RIGHT, height), title))
        top += height + APART
    return made


def _title(curves: dict[str, Any], scale: Scale) -> str:
    compared = curves.get("compared")
    if isinstance(compared, list) and len(compared) == 2:
        return f"Output if it is {compared[0]}, less {compared[1]} refitted [{scale.label}]"
    return f"Difference of both explanations [{scale.label}]"
