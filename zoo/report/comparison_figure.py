"""Methods side by side: every seed's RMS on one axis, and RMS by run and stage; beside each the noise floor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.report.canvas import DENSE, blank, panel
from zoo.report.palette import FLOOR, INK, MEASURED, MUTED
from zoo.report.wording import Scale, significant
from zoo.scoring.comparison import UNCOMPENSATED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

FLOOR_NAME = "noise floor"
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#1d2733", "#F0E442")
"""Okabe & Ito (2008); the uncompensated error is grey."""
OTHERS = "#c3cbd3"
"""Where there are more methods than colours, the best are coloured."""
WIDTH, HEIGHT, HEAD, FOOT, INDENT, LEFT = 740, 150, 40, 16, 12, 62
STAGES_WIDE = 570
"""Two of them stand side by side on the page."""
LETTER, HANDLE = 7, 46
"""Width of an entry of the legend: so much a letter, and so much for its mark [px]."""
ROW, NAMES, LONGEST = 38, 200, 26
SPREAD = 6.0
"""A wider range of values is drawn on a logarithmic axis."""
SHOWN = 40
"""Rows of the figure of seeds."""


def colors_of(names: list[str]) -> dict[str, str]:
    """A colour for every name, no two alike but those that are not among the best.

    Args:
        names: of the methods, best first.
    """
    coloured = dict(zip(names, COLORS, strict=False))
    return {UNCOMPENSATED: MEASURED} | {name: coloured.get(name, OTHERS) for name in names}


def best_of(methods: int) -> str:
    """Says that only the best of so many methods are drawn; empty where all are."""
    return f", the best {len(COLORS)} of {methods} methods" if methods > len(COLORS) else ""


def seeds_figure(methods: list[dict[str, Any]], uncompensated: float, floor: float, scale: Scale, runs: str) -> Figure:
    """One row a method: a point a seed, the 90 % range, the median with its 95 % interval; the noise floor as a line.

    Args:
        methods: as in `comparison.json`, best first.
        uncompensated: RMS of the error as measured [output's unit].
        floor: noise floor [output's unit].
        scale: how values are written.
        runs: what the runs are called that all this is of.
    """
    from matplotlib.lines import Line2D

    shown, colors = methods[:SHOWN], colors_of([one["name"] for one in methods])
    rows = len(shown) + 1
    figure = blank(WIDTH, 84 + ROW * rows)
    axes = panel(figure, (NAMES, 38, WIDTH - NAMES - 34, ROW * rows))
    axes.axvline(floor * scale.factor, color=FLOOR, lw=1.6, zorder=1)
    for place, one in enumerate(shown):
        _seeds_row(axes, place, one, colors[one["name"]], scale)
    axes.plot([uncompensated * scale.factor], [rows - 1], "D", color=MEASURED, ms=8)
    _above(axes, scale.text(uncompensated), uncompensated * scale.factor, rows - 1, MUTED)
    everything = [value * scale.factor for one in shown for value in (*one["by_seed"], *(one["rms"]["interval"] or ()))]
    kind = scaled(axes.xaxis, [*everything, floor * scale.factor, uncompensated * scale.factor])
    title = f"RMS over {runs} [{scale.label}], {kind}"
    axes.annotate(title, (0, 1), (INDENT - NAMES, 10), "axes fraction", textcoords="offset points", fontsize=11, weight="bold")
    axes.set_yticks(range(rows), [*(_short(one["name"], LONGEST) for one in shown), UNCOMPENSATED], color=INK)
    axes.set_ylim(rows - 0.5, -0.6)
    axes.grid(visible=False, axis="y")
    marks = [Line2D([], [], color=FLOOR, lw=1.6, label="noise floor")]
    if any(len(one["by_seed"]) > 1 for one in shown):
        marks += [Line2D([], [], color=MUTED, lw=1.4, label="90 % of seeds"), Line2D([], [], color=MUTED, lw=6, alpha=0.4, label="median, 95 %")]
    axes.legend(handles=marks, loc="lower right", bbox_to_anchor=(1, 1.0), borderpad=0.9, ncols=len(marks))
    return figure


def _seeds_row(axes: Axes, place: int, one: dict[str, Any], color: str, scale: Scale) -> None:
    values = np.array(one["by_seed"]) * scale.factor
    spread = {key: one["rms"][key] * scale.factor for key in ("median", "low", "high")}
    if len(values) > 1:
        # A fixed pattern keeps neighbours apart; chance would move them from one page to the next.
        order = np.argsort(np.argsort(values))
        lift = 0.27 * (((order * 0.618034) % 1.0) - 0.5)
        axes.plot(values, place + lift, "o", color=color, ms=3.2, alpha=0.45, mew=0, rasterized=len(values) > DENSE)
        axes.plot([spread["low"], spread["high"]], [place, place], color=color, lw=1.4)
    ends = one["rms"]["interval"]
    if ends is not None:
        axes.plot([end * scale.factor for end in ends], [place, place], color=color, lw=6, alpha=0.4, solid_capstyle="butt")
    axes.plot([spread["median"]], [place], "o", color=color, ms=8, mec="white", mew=0.8, zorder=3)
    _above(axes, scale.text(one["rms"]["median"]), spread["median"], place, INK)


def _above(axes: Axes, text: str, x: float, y: float, color: str) -> None:
    """A value over its mark, readable where lines cross."""
    behind = {"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 0.4}
    axes.annotate(text, (x, y), (0, 6), textcoords="offset points", ha="center", va="bottom", color=color, fontsize=11, zorder=4, bbox=behind)


def _short(name: str, longest: int) -> str:
    """A name less its middle where it is too long: what tells it from others stands at the end."""
    return name if len(name) <= longest else f"{name[: longest // 2]}…{name[len(name) - (longest - 1) // 2 :]}"


def stages_figure(rows: list[dict[str, Any]], names: list[str], floors: dict[str, float], scale: Scale) -> Figure:
    """One panel a run, one group a stage, a mark a method with its 90 % range over seeds; the noise floor as a line.

    Args:
        rows: ``{"run": ..., "stage": ..., NAME: (median, low, high) [output's unit]}``.
        names: of the methods, best first; the best have colours and are drawn.
        floors: noise floor by run [output's unit].
        scale: how values are written.
    """
    runs, colors = list(dict.fromkeys(row["run"] for row in rows)), colors_of(names[: len(COLORS)])
    head = HEAD + legend_height([*colors, FLOOR_NAME], STAGES_WIDE)
    figure = blank(STAGES_WIDE, head + (HEIGHT + HEAD + FOOT) * len(runs))
    for index, run in enumerate(runs):
        chosen = [row for row in rows if row["run"] == run]
        title = f"{run}: RMS of the error [{scale.label}]{best_of(len(names))}"
        axes = panel(figure, (LEFT, head + index * (HEIGHT + HEAD + FOOT), STAGES_WIDE - LEFT - 14, HEIGHT), title, INDENT)
        for place, (name, color) in enumerate(colors.items()):
            offset = (place - (len(colors) - 1) / 2) * 0.8 / len(colors)
            for group, row in enumerate(chosen):
                median, low, high = (value * scale.factor for value in row[name])
                axes.plot([group + offset] * 2, [low, high], color=color, lw=2.2, solid_capstyle="butt")
                axes.plot([group + offset], [median], "D" if name == UNCOMPENSATED else "o", color=color, ms=6)
        if run in floors:
            axes.axhline(floors[run] * scale.factor, color=FLOOR, lw=1.4, zorder=1)
        levels = [value * scale.factor for row in chosen for name in colors for value in row[name]]
        scaled(axes.yaxis, [*levels, *([floors[run] * scale.factor] if run in floors else [])])
        axes.set_xlim(-0.5, len(chosen) - 0.5)
        axes.set_xticks(range(len(chosen)), [row["stage"] for row in chosen])
        axes.grid(visible=False, axis="x")
    legend_above(figure, colors | {FLOOR_NAME: FLOOR}, STAGES_WIDE)
    return figure


def scaled(axis: Axis, values: list[float]) -> str:
    """Sets one axis so that all values and what is written beside them fit, and says what kind it is."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    sideways = axis is axis.axes.xaxis
    set_limits = axis.axes.set_xlim if sideways else axis.axes.set_ylim
    positive = [value for value in values if value > 0]
    low, high = min(positive, default=1.0), max(positive, default=1.0)
    if high / low <= SPREAD:
        set_limits(0, 1.15 * high)
        return "linear axis"
    (axis.axes.set_xscale if sideways else axis.axes.set_yscale)("log")
    set_limits(low / 1.3, high * (1.5 if sideways else 1.3))
    axis.set_major_locator(LogLocator(subs=(1.0,) if high / low > 300 else (1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: significant(value, 1)))
    axis.set_minor_locator(NullLocator())
    return "logarithmic axis"


def legend_columns(names: Sequence[str], width: int = WIDTH) -> int:
    """How many names fit side by side in a figure of this width [px]."""
    return max(1, min(4, len(names), (width - INDENT) // (LETTER * max(len(name) for name in names) + HANDLE)))


def legend_above(figure: Figure, colors: dict[str, str], width: int = WIDTH) -> None:
    """All names with their colours, at the figure's top, to be read row by row."""
    from matplotlib.lines import Line2D

    columns = legend_columns(list(colors), width)
    names = [name for first in range(columns) for name in list(colors)[first::columns]]  # matplotlib goes down each column first
    marks = [Line2D([], [], color=colors[name], lw=4, solid_capstyle="butt") for name in names]
    longest = (width - INDENT - HANDLE) // LETTER
    figure.legend(marks, [_short(name, longest) for name in names], loc="upper right", ncols=columns, borderaxespad=0.6)


def legend_height(names: Sequence[str], width: int = WIDTH) -> int:
    """How much of a figure its legend takes [px]."""
    return 18 * -(-len(names) // legend_columns(names, width))
