"""What an unexplained residual goes with: one small panel a quantity, the free function as a curve and what it was fitted to as points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.report.canvas import blank, panel
from zoo.report.palette import CHECK, FIT, INK, REFINED
from zoo.report.wording import Scale, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HIGH, HEAD, FOOT = 380, 200, 52, 48
LEFT, INNER = 58, 308
COLORS = ((FIT, "o"), (INK, "s"), (CHECK, "^"))
"""Of the curves of one panel, cold to hot."""


def unknown_figure(entry: dict[str, Any], scale: Scale) -> Figure:
    """One quantity.

    Args:
        entry: one of the diagnosis' `unexplained`, with `curves`.
        scale: how values are written.
    """
    figure = blank(WIDTH, HEAD + HIGH + FOOT)
    axes = panel(figure, (LEFT, HEAD, INNER, HIGH), f"Unexplained [{scale.label}]")
    axes.set_title(f"explains {percent(entry.get('explains'))}", loc="right", fontsize=11, color=INK, pad=10)
    axes.axhline(0, color=INK, lw=0.8)
    curves = entry["curves"]
    for curve, (color, marker) in zip(curves, COLORS if len(curves) > 1 else ((REFINED, "o"),), strict=False):
        _draw(axes, curve, scale.factor, color, marker)
    axes.set_ylim(*_limits(curves, scale.factor))
    unit = str(entry.get("unit") or "").replace("unit", scale.label)
    axes.set_xlabel(f"{_short(str(entry['quantity']))}{f' [{unit}]' if unit else ''}")
    if len(curves) > 1:
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1.11), ncols=3, handlelength=1.4)
    return figure


def _draw(axes: Axes, curve: dict[str, Any], factor: float, color: str, marker: str) -> None:
    """One curve with its band, and points with error bars."""
    x, points = np.asarray(curve["x"]), curve["points"]
    low, high, y = (factor * np.asarray(curve[key]) for key in ("low", "high", "y"))
    axes.fill_between(x, low, high, color=color, alpha=0.18, lw=0)
    axes.plot(x, y, color=color, lw=1.6, label=curve["label"] or None)
    bars = factor * np.asarray(points["error"])
    axes.errorbar(points["x"], factor * np.asarray(points["y"]), bars, fmt=marker, color=color, ms=3.6, mew=0, elinewidth=0.9, alpha=0.75)


def _limits(curves: list[dict[str, Any]], factor: float) -> tuple[float, float]:
    """Room for curves and points; a band that opens at the ends does not flatten them."""
    values = np.concatenate([factor * np.asarray([*curve["y"], *curve["points"]["y"]]) for curve in curves])
    low, high = min(float(values.min()), 0.0), max(float(values.max()), 0.0)
    edge = 0.1 * (high - low) or 1.0
    return low - edge, high + edge


def _short(words: str) -> str:
    """An axis label: without the article and what follows a comma."""
    label = words.split(",", maxsplit=1)[0].removeprefix("the ")
    return label[:1].upper() + label[1:]
