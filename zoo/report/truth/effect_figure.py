"""What each effect adds to a simulated gyro's output over time, with the temperatures that make it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from zoo.report.canvas import blank, curve, panel
from zoo.report.palette import INK, MEASURED
from zoo.report.truth.effect_stack import MOST, OTHERS, stacked
from zoo.report.truth.effect_trace import EffectTrace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, LEFT, INNER, INDENT = 1150, 62, 1072, 12
ALONE, ROW, BETWEEN = 598, 104, 72
"""Where the panels of single effects begin; from one row of them to the next; between the two columns [px]."""
BELOW = 20
"""What the last row needs less [px]."""
AIR = "air"
"""A thermometer there is no measure of the coil."""
COLORS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442")
"""Okabe & Ito (2008); black is the sum, grey what is left over."""
LEFT_OVER, RECORDED = "#767c86", "#3d4854"
SENSORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")


def colors_of(order: Sequence[str]) -> dict[str, str]:
    """A colour for each effect that is drawn by itself.

    Args:
        order: all effects, the largest first.
    """
    own = order if len(order) <= MOST else order[: MOST - 1]
    return dict(zip(own, COLORS, strict=False)) | {OTHERS: LEFT_OVER}


def effect_figure(trace: EffectTrace, colors: Mapping[str, str]) -> Figure:
    """Panels over one time axis: temperatures, thermometers, all effects on one scale, and below each on its own.

    Args:
        trace: the run.
        colors: by effect, see `colors_of`.
    """
    rows = -(-len(trace.change) // 2) if len(trace.change) > 1 else 0
    figure = blank(WIDTH, ALONE + rows * ROW - BELOW)
    together = panel(figure, (LEFT, 284, INNER, 240), "Bias by effect, change from rest [°/h]", INDENT)
    temperature = panel(figure, (LEFT, 34, INNER, 84), "Temperature [°C]", INDENT, sharex=together)
    sensors = panel(figure, (LEFT, 162, INNER, 70), "Thermometers − coil [K]", INDENT, sharex=together)
    _draw_temperature(temperature, trace)
    _draw_sensors(sensors, trace)
    _draw_effects(together, trace, colors)
    for axes in (temperature, sensors):
        axes.tick_params(labelbottom=False)
    for axes in (temperature, sensors, together):
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), ncols=10, borderpad=0.35, handlelength=1.5)
    together.set_xlim(float(trace.hours[0]), float(trace.hours[-1]))
    together.set_xlabel("Time [h]", labelpad=2)
    for number, name in enumerate(list(trace.change)[: 2 * rows]):
        _draw_alone(figure, number, name, trace, colors[name])
    return figure


def _draw_temperature(axes: Axes, trace: EffectTrace) -> None:
    axes.plot(*curve(trace.hours, trace.asked_c), color=MEASURED, lw=2.6, label="asked of the chamber")
    if AIR in trace.thermometers_k:
        axes.plot(*curve(trace.hours, trace.coil_c + trace.thermometers_k[AIR]), color=SENSORS[0], lw=1.1, label="thermometer in the air")
    axes.plot(*curve(trace.hours, trace.coil_c), color=INK, lw=1.1, label="coil")


def _draw_sensors(axes: Axes, trace: EffectTrace) -> None:
    axes.axhline(0, color=INK, lw=0.8)
    inside = {place: values for place, values in trace.thermometers_k.items() if place != AIR}
    for (place, values), color in zip(inside.items(), SENSORS, strict=False):
        axes.plot(*curve(trace.hours, values), color=color, lw=1.1, label=place.replace("_", " "))


def _draw_effects(axes: Axes, trace: EffectTrace, colors: Mapping[str, str]) -> None:
    seen = curve(trace.hours_recorded, trace.recorded)
    axes.plot(*seen, color="white", lw=2.0, alpha=0.55, zorder=2.4)
    axes.plot(*seen, color=RECORDED, lw=0.7, label="recorded", zorder=2.5)
    for name, areas in stacked(trace.change).items():
        for place, (inner, outer) in enumerate(areas):
            label = f"_{name}" if place else name
            axes.fill_between(trace.hours, inner, outer, color=colors[name], alpha=0.85, lw=0, label=label, zorder=2)
    axes.plot(*curve(trace.hours, trace.total), color=INK, lw=1.2, label="sum of effects", zorder=3)


def _draw_alone(figure: Figure, number: int, name: str, trace: EffectTrace, color: str) -> None:
    """A small panel for one effect, two side by side."""
    left = LEFT + number % 2 * (INNER + BETWEEN) // 2
    box = (left, ALONE + number // 2 * ROW, (INNER - BETWEEN) // 2, ROW - 44)
    axes = panel(figure, box, f"{name} [°/h]", left - LEFT + INDENT)
    values = trace.change[name]
    axes.fill_between(trace.hours, values, color=color, alpha=0.3, lw=0)
    axes.plot(*curve(trace.hours, values), color=color, lw=1.2)
    axes.set_xlim(float(trace.hours[0]), float(trace.hours[-1]))
    axes.tick_params(labelbottom=number >= len(trace.change) - 2)
