"""One run against time: error and model, temperature, and what the model leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.report.canvas import blank, panel, thinned
from zoo.report.palette import FLOOR, INK, MEASURED, MODEL, REFINED, STAGES, WORST
from zoo.report.trace import Trace
from zoo.report.wording import Scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 740, 560
LEFT, INNER = 62, 664
NUMBER_WIDTH = 12


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


def time_figure(trace: Trace, shades: list[Shade], scale: Scale, floor: float | None) -> Figure:
    """Three panels over one time axis.

    Args:
        trace: the run.
        shades: where the model fails worst.
        scale: how values are written.
        floor: noise floor [output's unit].
    """
    figure = blank(WIDTH, HEIGHT)
    error = panel(figure, (LEFT, 34, INNER, 170), f"Error [{scale.label}]")
    temperature = panel(figure, (LEFT, 248, INNER, 74), "Temperature [°C]", sharex=error)
    residual = panel(figure, (LEFT, 364, INNER, 150), f"Residual [{scale.label}]", sharex=error)
    _draw_error(error, trace, scale.factor)
    _draw_temperature(temperature, trace)
    _draw_residual(residual, trace, scale.factor, floor)
    for axes in (error, temperature):
        axes.tick_params(labelbottom=False)
    residual.set_xlim(*_limits(trace.hours))
    _shade([error, residual], shades)
    residual.set_xlabel("Time [h]")
    return figure


def _limits(hours: np.ndarray) -> tuple[float, float]:
    step = float(np.median(np.diff(hours))) if len(hours) > 1 else 0.1
    return float(hours[0]) - step / 2, float(hours[-1]) + step / 2


def _draw_error(axes: Axes, trace: Trace, factor: float) -> None:
    axes.plot(*thinned(trace.hours, trace.error * factor), color=MEASURED, lw=2.6, label="measured", solid_capstyle="round")
    axes.plot(*thinned(trace.hours, trace.model * factor), color=MODEL, lw=1.1, label="model as it stands")
    if trace.refined is not None:
        axes.plot(*thinned(trace.hours, trace.refined * factor), color=REFINED, lw=1.1, label="with the missing effects")
    _legend(axes)


def _draw_residual(axes: Axes, trace: Trace, factor: float, floor: float | None) -> None:
    if floor:
        axes.axhspan(-floor * factor, floor * factor, color=FLOOR, alpha=0.18, lw=0, label="± noise floor")
    axes.plot(*thinned(trace.hours, trace.residual * factor), color=MODEL, lw=1.0, label="as it stands")
    if trace.residual_after is not None:
        axes.plot(*thinned(trace.hours, trace.residual_after * factor), color=REFINED, lw=1.0, label="with the missing effects")
    _legend(axes)


def _draw_temperature(axes: Axes, trace: Trace) -> None:
    """The curve in the colours of the stages; each piece reaches to the next one's first block, so that no gaps show."""
    kinds = np.array(trace.stage)
    for kind, (color, _) in STAGES.items():
        here = kinds == kind
        here[1:] |= here[:-1]
        if here.any():
            axes.plot(trace.hours, np.where(here, trace.temperature_c, np.nan), color=color, lw=1.8, label=kind)
    _legend(axes)


def _legend(axes: Axes) -> None:
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), bbox_transform=axes.transAxes, ncols=4, borderpad=0.35, handlelength=1.6)


def _shade(panels: list[Axes], shades: list[Shade]) -> None:
    """Yellow behind the curves, numbered below the first panel; a number too near the one before goes one line down."""
    per_hour = INNER / max(panels[0].get_xlim()[1] - panels[0].get_xlim()[0], 1e-9)
    before, line = -np.inf, 0
    for shade in sorted(shades, key=lambda shade: shade.from_h + shade.to_h):
        middle = (shade.from_h + shade.to_h) / 2
        line = line + 1 if (middle - before) * per_hour < NUMBER_WIDTH else 0
        before = middle
        for axes in panels:
            axes.axvspan(shade.from_h, shade.to_h, color=WORST, alpha=0.4, lw=0, zorder=0)
        place: dict[str, Any] = {"xycoords": panels[0].get_xaxis_transform(), "textcoords": "offset points", "ha": "center", "va": "top"}
        panels[0].annotate(str(shade.rank), (middle, 0), (0, -3 - 11 * line), weight="bold", fontsize=10, color=INK, **place)
