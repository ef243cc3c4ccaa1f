"""A paper's figures, redrawn: what was recorded, what every method makes of it, what it leaves."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from zoo.papers.study import Claim, Row, Study
from zoo.report.canvas import blank, curve, panel
from zoo.report.comparison_figure import COLORS, legend_above, legend_columns
from zoo.report.palette import INK, MEASURED
from zoo.report.wording import joined, significant
from zoo.scoring.comparison import UNCOMPENSATED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT, HEAD, FOOT, INDENT, LEFT, LINE = 740, 190, 50, 44, 12, 62, 18
MARGIN = 0.25
"""Free space above and below a measured curve, of its range."""
FAR = 1000.0
"""A size this many times the middle one, or a part of it, is off the scale."""
LETTER = 8
"""Width of a letter under an axis [px]."""
LINES = (*COLORS[:-1], "#882255")
"""Of curves: yellow is too light for them."""


def drift_figure(study: Study, unit: str) -> Figure:
    """The error against temperature, run by run."""
    names = {run.name: COLORS[place] for place, run in enumerate(study.runs)}
    figure, axes = _single(names, f"error before compensation [{unit}]")
    for place, run in enumerate(study.runs):
        axes.plot(run.block_mean(run.temperature).numpy(), study.left[UNCOMPENSATED][place][0].numpy(), lw=1.1, color=names[run.name])
    axes.set_xlabel("Temperature [°C]")
    return figure


def fits_figure(study: Study, sample: int, unit: str) -> Figure:
    """The error of one run and what every method predicts: median and 90 % band over the seeds, as far as they stay on its scale."""
    run, colors = study.runs[sample], _colors(study.methods)
    hours, error = run.block_mean(run.time).numpy() / 3600, study.left[UNCOMPENSATED][sample][0].numpy()
    predicted, ends = {name: error - study.left[name][sample].numpy() for name in colors}, _around(error)
    gone = [name for name, values in predicted.items() if _off(np.quantile(values, 0.5, axis=0), ends).any()]
    title = f"{run.name}: error and predictions [{unit}]" + (f"; off the scale at times: {joined(gone)}" if gone else "")
    figure, axes = _single({"measured": MEASURED, **colors}, title)
    axes.plot(*curve(hours, error), color=MEASURED, lw=2.4)
    for name, color in colors.items():
        _band(axes, hours, predicted[name], color, ends)
    axes.set_ylim(*ends)
    axes.set_xlabel("Time [h]")
    return figure


def compensated_figure(study: Study, sample: int, unit: str) -> Figure:
    """What every method leaves of one run, one panel a method, all to one scale, that of the error before."""
    run, colors = study.runs[sample], _colors(study.methods)
    step = HEIGHT + HEAD
    figure = blank(WIDTH, step * len(colors) + FOOT)
    hours, error = run.block_mean(run.time).numpy() / 3600, study.left[UNCOMPENSATED][sample][0].numpy()
    low, high = _around(np.append(error, 0.0))
    for place, (name, color) in enumerate(colors.items()):
        left = study.left[name][sample].numpy()
        title = f"{run.name} before (grey) and after {name} [{unit}]"
        axes = panel(figure, (LEFT, HEAD + place * step, WIDTH - LEFT - 14, HEIGHT), title + _beyond(left, low, high), INDENT)
        axes.plot(*curve(hours, error), color=MEASURED, lw=1.4)
        _band(axes, hours, left, color)
        axes.set_ylim(low, high)
    axes.set_xlabel("Time [h]")
    return figure


def table_figure(rows: list[Row], quantity: str, stage: str) -> Figure:
    """One figure of merit, the paper's beside ours with its band, method by method and sample by sample; logarithmic, by size.

    What lies far from all the others is shown at the edge, as an arrow.
    """
    chosen = [row for row in rows if row.quantity == quantity and row.stage == stage]
    samples, models = (list(dict.fromkeys(getattr(row, key) for row in chosen)) for key in ("sample", "model"))
    names = {f"sample {sample}" if sample.isdigit() else sample: COLORS[place] for place, sample in enumerate(samples)}
    size = "|" if any(row.ours < 0 for row in chosen) else ""
    low, high = _kept([abs(value) for row in chosen for value in (row.ours, row.paper) if value])
    title = f"{size}{quantity}{size}, {stage} run [{chosen[0].unit}]{_signs(chosen, low, high)}"
    figure, axes = _single({**names, "paper (diamonds)": INK}, title, LINE)
    for row in chosen:
        place = samples.index(row.sample)
        x = models.index(row.model) + (place - (len(samples) - 1) / 2) * 0.8 / max(len(samples), 1)
        _mark(axes, x, row, list(names.values())[place], (low, high))
    _logarithmic(axes, low, high)
    letters = (WIDTH - LEFT - 14) // (len(models) * LETTER)
    axes.set_xticks(range(len(models)), ["before" if model == UNCOMPENSATED else fill(model, letters, break_long_words=False) for model in models])
    axes.grid(visible=False, axis="x")
    return figure


def _single(colors: dict[str, str], title: str, below: int = 0) -> tuple[Figure, Axes]:
    """A figure of one panel under its legend; `below` is for a second line under the axis [px]."""
    head = 32 + LINE * -(-len(colors) // legend_columns(list(colors)))
    figure = blank(WIDTH, head + 280 + FOOT + below)
    legend_above(figure, colors)
    return figure, panel(figure, (LEFT, head, WIDTH - LEFT - 14, 280), title, INDENT)


def _colors(names: list[str]) -> dict[str, str]:
    return {name: LINES[place % len(LINES)] for place, name in enumerate(names)}


def _signs(rows: list[Row], low: float, high: float) -> str:
    """What to add to a title where bars and arrows are drawn."""
    bars, arrows = any(row.high > row.low for row in rows), any(not low <= abs(row.ours) <= high for row in rows)
    return f"{'; bars: 90 % of the seeds' if bars else ''}{'; arrows: off the scale' if arrows else ''}"


def _off(values: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Where values lie beyond the ends of an axis."""
    beyond: np.ndarray = (values < ends[0]) | (values > ends[1])
    return beyond


def _around(values: np.ndarray) -> tuple[float, float]:
    """Ends of an axis for some values, so that a prediction that leaves them for good does not flatten all others."""
    low, high = float(values.min()), float(values.max())
    return low - MARGIN * (high - low), high + MARGIN * (high - low)


def _beyond(left: np.ndarray, low: float, high: float) -> str:
    """What to add to a title where a curve leaves its axes."""
    middle = np.quantile(left, 0.5, axis=0)
    outside = middle.min() < low or middle.max() > high
    return f", up to {significant(float(np.abs(middle).max()), 2)}" if outside else ""


def _kept(sizes: list[float]) -> tuple[float, float]:
    """Ends of a logarithmic axis, for all sizes that are within a factor of `FAR` of the middle one."""
    middle = float(np.median(sizes))
    near = [one for one in sizes if middle / FAR <= one <= middle * FAR]
    return min(near) / 1.6, max(near) * 1.6


def _mark(axes: Axes, x: float, row: Row, color: str, ends: tuple[float, float]) -> None:
    """One method's figure for one sample: median, band, and the paper's."""
    ours, band = abs(row.ours), sorted((abs(row.low), abs(row.high)))
    if row.low < 0 < row.high:
        band[0] = ends[0]
    axes.plot([x, x], band, color=color, lw=4, alpha=0.35, solid_capstyle="butt")
    shown = min(max(ours, ends[0] * 1.12), ends[1] / 1.12)
    axes.plot(x, shown, "o" if shown == ours else "^" if ours > shown else "v", color=color, ms=5)
    if row.paper is not None:
        axes.plot(x, abs(row.paper), "D", mfc="none", color=INK, ms=6)


def _logarithmic(axes: Axes, low: float, high: float) -> None:
    """A scale with numbers written out; the style knows no mathematics."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high / low < 100 else (1.0,)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())


def table_text(rows: list[Row], claims: list[Claim], title: str, remarks: Sequence[str] = ()) -> str:
    """The claims, what there is to know about them, and the tables as Markdown."""
    lines = [f"# {title}", "", "| | found | |", "|---|---|---|"]
    lines += [f"| {_plain(claim.text)} | {_plain(claim.value)} | {'yes' if claim.holds else '**no**'} |" for claim in claims]
    lines += ["", *(f"- {remark}" for remark in remarks)]
    for quantity in dict.fromkeys(row.quantity for row in rows):
        chosen = [row for row in rows if row.quantity == quantity]
        models = list(dict.fromkeys(row.model for row in chosen))
        lines += ["", f"## {quantity} [{chosen[0].unit}]", "", "Ours (5 % … 95 % of the seeds), and below it the paper's.", ""]
        lines += [f"| stage | sample | {' | '.join(models)} |", "|---" * (len(models) + 2) + "|"]
        for stage, sample in dict.fromkeys((row.stage, row.sample) for row in chosen):
            cells = {row.model: row for row in chosen if (row.stage, row.sample) == (stage, sample)}
            lines.append(f"| {stage} | {sample} | " + " | ".join(_cell(cells.get(model)) for model in models) + " |")
    return "\n".join([*lines, ""])


def _plain(text: str) -> str:
    """A sentence in a table of Markdown, where a bar would end the cell."""
    return text.replace("|", "\\|")


def _cell(row: Row | None) -> str:
    if row is None:
        return ""
    band = f" ({row.low:.4g} … {row.high:.4g})" if row.high > row.low else ""
    return f"{row.ours:.4g}{band}" + ("" if row.paper is None else f"<br>*{row.paper:.4g}*")


def _band(axes: Axes, hours: np.ndarray, values: np.ndarray, color: str, ends: tuple[float, float] = (-np.inf, np.inf)) -> None:
    """Median over the seeds (E, N), and the band in which 90 % of them lie; not where they pass the ends of the axis, on both sides for the band."""
    low, middle, high = np.quantile(values, (0.05, 0.5, 0.95), axis=0)
    if len(values) > 1:
        axes.fill_between(hours, low, high, where=(low >= ends[0]) | (high <= ends[1]), color=color, alpha=0.25, lw=0)
    axes.plot(*curve(hours, np.where(_off(middle, ends), np.nan, middle)), color=color, lw=1.1)
