"""How a coil is wound: its cross-section, and layer by layer what it weighs in Shupe's integral."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.physics.winding import PERIODS, Winding
from zoo.report.canvas import blank, panel
from zoo.report.palette import CHECK, INK
from zoo.report.truth.winding_numbers import WEIGHT, excess_turns, layer_weights, radial_weight, summed_weight
from zoo.report.truth.winding_section import SUPPLIES, TOP, draw_section
from zoo.report.wording import significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT, LEFT, RIGHT = 1150, 550, 610, 1134
"""Of the figure, and where the panels beside the section begin and end [px]."""
MOST_MARKS = 20
EXACT = 1e-9
"""Smaller errors of a winding are none [turns]."""


def winding_figure(winding: Winding) -> Figure:
    """The cross-section in its proportions, and beside it two or three quantities layer by layer.

    Args:
        winding: of one gyro.
    """
    figure, uneven = blank(WIDTH, HEIGHT), excess_turns(winding)
    draw_section(figure, winding)
    wound_badly = bool(np.nanmax(np.abs(uneven)) > EXACT)
    high, step = (108, 174) if wound_badly else (190, 262)
    weights = _beside(figure, TOP, high, f"Weight of each layer in Shupe's integral [{WEIGHT}]")
    _draw_weights(weights, layer_weights(winding))
    title = f"Times its place (−½ to ½), summed from the spool outwards: C_w = {significant(radial_weight(winding))} {WEIGHT}"
    _draw_sum(_beside(figure, TOP + step, high, title, sharex=weights), summed_weight(winding))
    if wound_badly:
        _draw_errors(_beside(figure, TOP + 2 * step, high, "Winding errors: fibre too much in a layer [turns]", sharex=weights), uneven)
    weights.set_xlim(0.4, winding.coil.layers + 0.6)
    weights.xaxis.set_major_locator(_periods(winding))
    figure.axes[-1].set_xlabel("Layer, counted from the spool")
    return figure


def _beside(figure: Figure, top: int, high: int, title: str, **keywords: Any) -> Axes:
    return panel(figure, (LEFT, top, RIGHT - LEFT, high), title, LEFT - 50, **keywords)


def _periods(winding: Winding) -> Any:
    """Marks at the end of every period of the pattern, where it has one."""
    from matplotlib.ticker import MaxNLocator, MultipleLocator

    period = len(PERIODS.get(winding.coil.pattern, "A"))
    if period > 1 and 1 < winding.coil.layers / period <= MOST_MARKS:
        return MultipleLocator(period)
    return MaxNLocator(12, integer=True, steps=(1, 2, 5, 10))


def _draw_weights(axes: Axes, weights: np.ndarray) -> None:
    layer = np.arange(1, len(weights) + 1)
    for column, (name, color) in enumerate(SUPPLIES.items()):
        axes.bar(layer, weights[:, column], 0.86, color=color, label=f"laid by {name}")
    if (weights != 0).all(1).any():
        axes.plot(layer, weights.sum(1), "o", ms=3, color=INK, label="both")
    axes.axhline(0, color=INK, lw=0.8)
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), ncols=3, borderpad=0.35, handlelength=1.0)


def _draw_sum(axes: Axes, total: np.ndarray) -> None:
    layer = np.arange(1, len(total) + 1)
    axes.axhline(0, color=INK, lw=0.8)
    axes.plot(layer, total, color=INK, lw=1.2, marker="o", ms=2.6)
    axes.plot(layer[-1], total[-1], "o", color=CHECK, ms=6, clip_on=False)


def _draw_errors(axes: Axes, uneven: np.ndarray) -> None:
    axes.axhline(0, color=INK, lw=0.8)
    for column, color in enumerate(SUPPLIES.values()):
        axes.plot(np.arange(1, len(uneven) + 1), uneven[:, column], "os"[column], ms=4, color=color)
