"""A figure measured in pixels, its panels, and the way into the page: inline SVG."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup, escape

from zoo.artifacts import replacing
from zoo.report.gaps import interrupted
from zoo.report.palette import INK

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 72
"""SVG's points; so that one unit of a drawing is one pixel of the page at full width."""
PNG_DPI = 90
"""Dots an inch of images, as files and in TensorBoard."""
FINE = 2.5
"""Dense scatters are rasterised with so many dots a pixel."""
DENSE = 300
"""From here on a scatter is smaller as an image than as shapes."""
LONG = 1600
"""Longer curves are thinned to the extremes of as many pieces."""


def blank(width: int, height: int) -> Figure:
    """An empty figure [px]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width / DPI, height / DPI), dpi=DPI)


def panel(figure: Figure, box: tuple[int, int, int, int], title: str = "", indent: int = 1, **keywords: Any) -> Axes:
    """Axes at a place, with their title above the left end, where it can be read without turning the head.

    Args:
        figure: to draw on.
        box: left, top, width, height [px] of the area inside the axes.
        title: quantity and unit.
        indent: where it starts [px]; an image that stands alone needs a margin.
        keywords: for `Figure.add_axes`.
    """
    from matplotlib.ticker import MaxNLocator

    width, height = figure.get_size_inches() * DPI
    left, top, wide, high = box
    axes = figure.add_axes((left / width, 1 - (top + high) / height, wide / width, high / height), **keywords)
    axes.yaxis.set_major_locator(MaxNLocator(max(4, high // 28), steps=(1, 2, 4, 5, 10)))
    axes.xaxis.set_major_locator(MaxNLocator(max(4, wide // 50), steps=(1, 2, 5, 10)))
    axes.tick_params(pad=5)
    if title:
        axes.annotate(title, (0, 1), (indent - left, 10), "axes fraction", textcoords="offset points", color=INK, fontsize=11, weight="bold")
    return axes


def curve(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What to plot of a curve: interrupted where the recording was, and a long one thinned to the extremes of its pieces, which looks the same.

    Args:
        x: (N,) abscissa, increasing.
        y: (N,) ordinate.
    """
    x, y = interrupted(x, y)
    if len(x) <= LONG:
        return x, y
    kept: list[int] = []
    for piece in np.array_split(np.arange(len(x)), LONG // 2):
        known = np.isfinite(y[piece])
        low, high = np.where(known, y[piece], np.inf).argmin(), np.where(known, y[piece], -np.inf).argmax()
        kept += sorted({int(piece[i]) for i in (low, high, *np.flatnonzero(~known)[:1])})
    return x[kept], y[kept]


def inline_svg(figure: Figure, description: str) -> Markup:
    """A drawing as an element of the page: no header, no links, two decimals of a pixel, a text for those who do not see it."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", dpi=FINE * DPI, transparent=True, metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    drawing = stream.getvalue()
    body = drawing[drawing.index(">", drawing.index("<svg")) + 1 :]
    body = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", body, count=1, flags=re.DOTALL)
    body = re.sub(r'<g id="[^"]*"', "<g", body)
    body = re.sub(r' d="[^"]*"', lambda match: re.sub(r"(\d\.\d\d)\d+", r"\1", match[0]).replace("\n", ""), body)
    body = re.sub(r"\n\s*", "\n", body)
    width, height = figure.get_size_inches() * DPI
    label = escape(description)
    return Markup(f'<svg class="plot" viewBox="0 0 {width:g} {height:g}" role="img" aria-label="{label}"><title>{label}</title>{body}')


def png(figure: Figure) -> bytes:
    """A drawing as an image."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=PNG_DPI, facecolor="white", pil_kwargs={"compress_level": 2})
    return stream.getvalue()


def write_png(path: Path, figure: Figure) -> None:
    """A figure as an image file, whole or not at all.

    Raises:
        InputError: the folder cannot be written to.
        WorkError: writing failed half-way.
    """
    with replacing(path) as part:
        part.write_bytes(png(figure))
