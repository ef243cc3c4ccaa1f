"""The temperature field in the cross-section of a winding at chosen moments, and where in the program these are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from zoo.physics.winding import Winding
from zoo.report.canvas import DPI, blank, curve, panel
from zoo.report.palette import INK, MEASURED, MUTED
from zoo.report.truth.moments import Moment
from zoo.report.truth.winding_heat import Snapshots
from zoo.report.truth.winding_section import ROOMY, extent_mm, millimetres
from zoo.report.wording import fixed
from zoo.units import convert

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

WIDTH, LEFT, RIGHT, STRIP = 1150, 62, 1134, 90
SLOT, BETWEEN, HIGHEST, PER_ROW = 164, 30, 230, 6
"""From field to field, the space between, the most height, how many side by side [px]."""
TOP, HEAD, FOOT = 210, 46, 44
"""Above the first row of fields; above each field for its title; below it for its axis [px]."""
MAP = "RdBu_r"
FLAT_K = 1e-3
"""The scale of colours reaches at least so far."""
CROWDED = 18
"""A number closer than this to the one before goes above it [px]."""
STEPS, KEY_HIGH = 10, 150
"""Between lines of equal temperature, over the whole scale; height of the key of colours [px]."""


def heat_figure(shown: Snapshots, winding: Winding) -> Figure:
    """The program on top, the fields below it in the winding's proportions and one scale of colours.

    Args:
        shown: what to draw.
        winding: of the gyro.
    """
    wide, high, inner = extent_mm(winding)
    scale = min((SLOT - BETWEEN) / wide, HIGHEST / high)
    size = (max(1, round(wide * scale)), max(1, round(high * scale)))
    rows = -(-len(shown.moments) // PER_ROW)
    figure = blank(WIDTH, max(TOP + rows * (HEAD + size[1] + FOOT) - HEAD, TOP + KEY_HIGH + 12))
    _draw_program(panel(figure, (LEFT, 34, RIGHT - LEFT, STRIP), "Chamber and coil [°C]", 12), shown)
    differences = shown.field_c - shown.mean_c[:, None, None]
    limit = max(FLAT_K, float(np.abs(differences).max()))
    for number, moment in enumerate(shown.moments):
        place = (LEFT + number % PER_ROW * SLOT, TOP + number // PER_ROW * (HEAD + size[1] + FOOT))
        axes = panel(figure, (*place, *size))
        image = _draw_field(axes, differences[number], (inner, inner + wide, 0, high), limit)
        millimetres(axes.xaxis, size[0], "Radius [mm]")
        millimetres(axes.yaxis, size[1], "Height [mm]" if number % PER_ROW == 0 and size[1] >= ROOMY else "")
        axes.tick_params(labelleft=number % PER_ROW == 0)
        _name(axes, number + 1, moment, float(shown.mean_c[number]))
    _key(figure, image, LEFT + min(PER_ROW, len(shown.moments)) * SLOT)
    return figure


def _draw_program(axes: Axes, shown: Snapshots) -> None:
    times = [convert(one.time_s, "s", "h") for one in shown.moments]
    margin = 0.08 * (times[-1] - times[0]) or 0.5
    low, high = max(float(shown.hours[0]), times[0] - margin), min(float(shown.hours[-1]), times[-1] + margin)
    near = (shown.hours >= low) & (shown.hours <= high)
    axes.plot(*curve(shown.hours[near], shown.asked_c[near]), color=MEASURED, lw=2.6, label="asked of the chamber")
    axes.plot(*curve(shown.hours[near], shown.coil_c[near]), color=INK, lw=1.1, label="coil")
    axes.set(xlim=(low, high), xlabel="Time [h]")
    axes.margins(y=0.15)
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), ncols=2, borderpad=0.9)
    _number(axes, np.array(times), np.interp(times, shown.hours, shown.coil_c), (RIGHT - LEFT) / (high - low))


def _number(axes: Axes, hours: np.ndarray, coil_c: np.ndarray, px_per_h: float) -> None:
    """Numbers of the moments on the coil's curve."""
    up = 0
    for number, (time, temperature) in enumerate(zip(hours, coil_c, strict=True), 1):
        crowded = number > 1 and (time - hours[number - 2]) * px_per_h < CROWDED
        up = up + CROWDED if crowded else 0
        look: dict[str, Any] = {"ha": "center", "va": "center", "color": "white", "weight": "bold", "fontsize": 9}
        box = {"boxstyle": "circle,pad=0.22", "fc": INK, "ec": "white"}
        axes.annotate(str(number), (time, temperature), (0, up), textcoords="offset points", bbox=box, annotation_clip=False, **look)


def _draw_field(axes: Axes, values: np.ndarray, extent: tuple[float, float, float, float], limit: float) -> AxesImage:
    """A rectangle a turn, the spool to the left, and lines of equal temperature."""
    look: dict[str, Any] = {"extent": extent, "origin": "lower"}
    image = axes.imshow(values.T, cmap=MAP, vmin=-limit, vmax=limit, aspect="auto", interpolation="nearest", **look)
    # Lines of a field that hardly differs would only show how its numbers were rounded.
    if min(values.shape) > 1 and np.ptp(values) > 2 * limit / STEPS and axes.bbox.width > ROOMY:
        levels = np.linspace(-limit, limit, STEPS + 1)
        axes.contour(values.T, levels=levels, colors=INK, linewidths=0.5, alpha=0.55, linestyles="solid", **look)
    axes.grid(visible=False)
    return image


def _name(axes: Axes, number: int, moment: Moment, mean_c: float) -> None:
    place: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    axes.annotate(f"{number} · {moment.label}", (0, 1), (0, 22), fontsize=10.5, weight="bold", **place)
    axes.annotate(f"{fixed(convert(moment.time_s, 's', 'h'), 2)} h, mean {fixed(mean_c, 1)} °C", (0, 1), (0, 7), fontsize=10.5, color=MUTED, **place)


def _key(figure: Figure, image: AxesImage, left: int) -> None:
    width, height = figure.get_size_inches() * DPI
    bar = figure.colorbar(image, cax=figure.add_axes((left / width, 1 - (TOP + KEY_HIGH) / height, 12 / width, KEY_HIGH / height)))
    bar.ax.annotate("T − mean [K]", (0, 1), (0, 10), "axes fraction", textcoords="offset points", fontsize=10.5, color=INK)
    bar.outline.set_visible(False)
