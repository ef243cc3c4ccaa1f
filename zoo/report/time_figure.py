"""One run against time: error and model, temperature, and what the model leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.report.canvas import blank, curve, panel
from zoo.report.gaps import covered, interrupted, usual_step
from zoo.report.palette import FLOOR, INK, MEASURED, MODEL, REFINED, STAGES, WORST
from zoo.report.trace import Trace
from zoo.report.wording import Scale, Sides

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 740, 560
LEFT, INNER = 62, 664
NUMBER_WIDTH = 12
"""Numbers of regions keep so far apart [px]."""


@dataclass(frozen=True)
class Shade:
    """A stretch of time in which the model fails.

    Attributes:
        rank: its number in the table of the worst.
        from_h: start [h].
        to_h: end [h].
    """

    rank: int
    from_h: float
    to_h: float


def time_figure(trace: Trace, shades: list[Shade], scale: Scale, floor: float | None, sides: Sides) -> Figure:
    """Three panels over one time axis.

    Args:
        trace: the run.
        shades: where the model fails worst.
        scale: how values are written.
        floor: noise floor [output's unit].
        sides: what the two models are called.
    """
    figure = blank(WIDTH, HEIGHT)
    error = panel(figure, (LEFT, 34, INNER, 170), f"Error [{scale.label}]")
    temperature = panel(figure, (LEFT, 248, INNER, 74), "Temperature [°C]", sharex=error)
    residual = panel(figure, (LEFT, 364, INNER, 150), f"Residual [{scale.label}]", sharex=error)
    _draw_error(error, trace, scale.factor, sides)
    draw_temperature(temperature, trace.hours, trace.temperature_c, trace.stage)
    _draw_residual(residual, trace, scale.factor, floor, sides)
    for axes in (error, temperature):
        axes.tick_params(labelbottom=False)
    residual.set_xlim(*limits(trace.hours))
    _shade([error, residual], shades, trace.hours)
    residual.set_xlabel("Time [h]")
    return figure


def limits(hours: np.ndarray) -> tuple[float, float]:
    """From where to where a run's axis reaches [h]."""
    step = usual_step(hours) or 0.1
    return float(hours[0]) - step / 2, float(hours[-1]) + step / 2


def _draw_error(axes: Axes, trace: Trace, factor: float, sides: Sides) -> None:
    axes.plot(*curve(trace.hours, trace.error * factor), color=MEASURED, lw=2.6, label="measured", solid_capstyle="round")
    axes.plot(*curve(trace.hours, trace.model * factor), color=MODEL, lw=1.1, label=f"model {sides.stands}")
    if trace.refined is not None:
        axes.plot(*curve(trace.hours, trace.refined * factor), color=REFINED, lw=1.1, label=sides.added)
    legend(axes)


def _draw_residual(axes: Axes, trace: Trace, factor: float, floor: float | None, sides: Sides) -> None:
    if floor:
        axes.axhspan(-floor * factor, floor * factor, color=FLOOR, alpha=0.18, lw=0, label="± noise floor")
    axes.plot(*curve(trace.hours, trace.residual * factor), color=MODEL, lw=1.0, label=sides.stands)
    if trace.residual_after is not None:
        axes.plot(*curve(trace.hours, trace.residual_after * factor), color=REFINED, lw=1.0, label=sides.added)
    legend(axes)


def draw_temperature(axes: Axes, hours: np.ndarray, temperature_c: np.ndarray, stage: Sequence[str]) -> None:
    """The curve in the colours of the stages; each piece reaches to the next one's first block, so that no gaps show but those in the recording.

    Args:
        axes: to draw on.
        hours: (N,) time [h].
        temperature_c: (N,) [°C].
        stage: kind of stage of each of the N blocks.
    """
    kinds = np.array(stage)
    for kind, (color, _) in STAGES.items():
        here = kinds == kind
        here[1:] |= here[:-1]
        if here.any():
            axes.plot(*interrupted(hours, np.where(here, temperature_c, np.nan)), color=color, lw=1.8, label=kind)
    legend(axes)


def legend(axes: Axes) -> None:
    """Names above the panel's right end."""
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), bbox_transform=axes.transAxes, ncols=4, borderpad=0.35, handlelength=1.6)


def _shade(panels: list[Axes], shades: list[Shade], hours: np.ndarray) -> None:
    """Yellow behind the curves where something was recorded, numbered below the first panel."""
    spans = {shade.rank: covered(hours, shade.from_h, shade.to_h) for shade in shades}
    for axes in panels:
        for start, end in (span for found in spans.values() for span in found):
            axes.axvspan(start, end, color=WORST, alpha=0.4, lw=0, zorder=0)
    longest = {rank: max(found, key=lambda span: span[1] - span[0]) for rank, found in spans.items() if found}
    middles = {rank: (start + end) / 2 for rank, (start, end) in longest.items()}
    ranks, (least, most) = sorted(middles, key=lambda rank: middles[rank]), panels[0].get_xlim()
    places = _apart([middles[rank] for rank in ranks], NUMBER_WIDTH * (most - least) / INNER, most)
    place: dict[str, Any] = {"xycoords": panels[0].get_xaxis_transform(), "textcoords": "offset points", "ha": "center", "va": "top"}
    for rank, x in zip(ranks, places, strict=True):
        panels[0].annotate(str(rank), (x, 0), (0, -3), weight="bold", fontsize=10, color=INK, **place)


def _apart(places: list[float], width: float, most: float) -> list[float]:
    """Increasing places moved so far that neighbours keep a width's distance, first to the right, and back where that is beyond the end."""
    moved: list[float] = []
    for x in places:
        moved.append(max(x, moved[-1] + width) if moved else x)
    for i in reversed(range(len(moved))):
        moved[i] = min(moved[i], most if i == len(moved) - 1 else moved[i + 1] - width)
    return moved
