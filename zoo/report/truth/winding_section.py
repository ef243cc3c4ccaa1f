"""The cross-section of a winding: every turn at its place, coloured by its place along the fibre."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.physics.winding import Winding
from zoo.report.canvas import DPI, panel
from zoo.report.palette import INK, MUTED
from zoo.report.wording import fixed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

LEFT, TOP, WIDEST, HIGHEST = 62, 40, 360, 440
"""Where the picture begins, and the most that the section may take [px]."""
BAND, KEY, KEY_HIGH = 18, 34, 220
"""Between the title and the section for the supplies' names; between the section and the key of colours; height of the key [px]."""
SUPPLIES = {"A": "#d9720b", "B": "#6f58a8"}
ALONG = ("#8a3d04", SUPPLIES["A"], "#f3b66b", "#e9e6e1", "#b3a5d6", SUPPLIES["B"], "#3a1d70")
"""From the end of A through the middle of the fibre to that of B."""
FILLED = 0.96
"""Diameter of a turn in the picture, relative to the smaller pitch."""
SHADES = 2
"""Decimals of a place that are told apart by colour."""
ROOMY = 60
"""Shorter axes take one mark [px]."""
LEGIBLE, LONG = 7.0, 40.0
"""Layers at least so wide take a letter each; else only what reaches over so much [px]."""


def draw_section(figure: Figure, winding: Winding) -> None:
    """Draw at the left end, in the winding's own proportions.

    Args:
        figure: to draw on.
        winding: of one gyro.
    """
    wide, high, inner = extent_mm(winding)
    scale = min(WIDEST / wide, HIGHEST / high)
    size = (max(1, round(wide * scale)), max(1, round(high * scale)))
    axes = panel(figure, (LEFT, TOP + BAND, *size))
    title: dict[str, Any] = {"color": INK, "fontsize": 11, "weight": "bold"}
    axes.annotate("Place of every turn along the fibre", (0, 1), (12 - LEFT, BAND + 10), "axes fraction", textcoords="offset points", **title)
    axes.set(xlim=(inner, inner + wide), ylim=(0, high))
    millimetres(axes.xaxis, size[0], "Radius [mm]")
    millimetres(axes.yaxis, size[1], "Height [mm]" if size[1] >= ROOMY else "")
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    _draw_turns(axes, winding, inner, scale)
    _name_supplies(axes, winding, size)
    _key(figure, winding.fibre_m, LEFT + size[0] + KEY)


def extent_mm(winding: Winding) -> tuple[float, float, float]:
    """Thickness, height and inner radius [mm]."""
    coil = winding.coil
    return 1e3 * coil.radial_m, 1e3 * coil.height_m, 1e3 * (coil.diameter_m - coil.radial_m) / 2


def millimetres(axis: Axis, pixels: int, label: str) -> None:
    """Few marks and a label; only the middle is marked where there is hardly any room.

    Args:
        axis: of radius or height, with its limits set.
        pixels: its length.
        label: quantity and unit; may be empty.
    """
    from matplotlib.ticker import FixedLocator, FormatStrFormatter, MaxNLocator

    low, high = axis.get_view_interval()
    if pixels >= ROOMY:
        axis.set_major_locator(MaxNLocator(max(2, pixels // ROOMY), steps=(1, 2, 5, 10)))
    else:
        axis.set_major_locator(FixedLocator([(low + high) / 2]))
        axis.set_major_formatter(FormatStrFormatter("%.1f"))
    axis.set_label_text(label)


def _draw_turns(axes: Axes, winding: Winding, inner: float, scale: float) -> None:
    """A circle a turn; one that was cut off is empty."""
    coil = winding.coil
    across, along = 1e3 * coil.layer_pitch_m, 1e3 * coil.turn_pitch_m
    x, y = np.meshgrid(inner + across * (np.arange(coil.layers) + 0.5), along * (np.arange(coil.turns) + 0.5), indexing="ij")
    place = ((winding.start + winding.length / 2 - winding.first) / winding.fibre_m).numpy().ravel()
    area, left = (FILLED * min(across, along) * scale) ** 2, (place >= 0) & (place <= 1)
    axes.scatter(x.ravel()[left], y.ravel()[left], area, _map()(place[left].round(SHADES)), linewidths=0, clip_on=False)
    axes.scatter(x.ravel()[~left], y.ravel()[~left], 0.7 * area, "none", edgecolors=MUTED, linewidths=0.6)


def _map() -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("along the fibre", ALONG)


def _name_supplies(axes: Axes, winding: Winding, size: tuple[int, int]) -> None:
    """Which supply laid each layer, or each end of the layers, as a band with letters beside the section."""
    supply = winding.supply.numpy()
    by_layer = bool((supply == supply[:, :1]).all())
    letters = ["AB"[one] for one in (supply[:, 0] if by_layer else supply[0])]
    single = by_layer and size[0] / len(letters) >= LEGIBLE
    edges = [place for place in range(1, len(letters)) if single or letters[place] != letters[place - 1]]
    for begin, end in pairwise([0, *edges, len(letters)]):
        span = (begin / len(letters), end / len(letters))
        _band(axes, span, letters[begin], size, by_layer, single or (span[1] - span[0]) * size[not by_layer] >= LONG)


def _band(axes: Axes, span: tuple[float, float], letter: str, size: tuple[int, int], above: bool, named: bool) -> None:
    """One piece of the band, above the section or to the right of it."""
    across = (1 + 4 / size[above], 1 + 16 / size[above])
    x, y = (span, across) if above else (across, span)
    axes.fill_between(x, *y, color=SUPPLIES[letter], lw=0.6, ec="white", transform=axes.transAxes, clip_on=False)
    if named:
        look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "color": "white", "fontsize": 8, "weight": "bold"}
        axes.text(sum(x) / 2, sum(y) / 2, letter, transform=axes.transAxes, **look)


def _key(figure: Figure, fibre_m: float, left: int) -> None:
    """Colours of places along the fibre."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    width, height = figure.get_size_inches() * DPI
    place = (left / width, 1 - (TOP + BAND + KEY_HIGH + 40) / height, 12 / width, KEY_HIGH / height)
    bar = figure.colorbar(ScalarMappable(Normalize(0, fibre_m), _map()), cax=figure.add_axes(place), ticks=[0, fibre_m / 2, fibre_m])
    labels = ["0 m,\nend of A", f"{fixed(fibre_m / 2, 0)} m,\nmiddle", f"{fixed(fibre_m, 0)} m,\nend of B"]
    bar.ax.set_yticklabels(labels, color=MUTED, fontsize=10)
    bar.ax.tick_params(length=0)
    bar.outline.set_visible(False)
