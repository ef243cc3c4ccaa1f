"""One run over time: the error as measured and what each method leaves of it, with the temperature between."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from zoo.report.canvas import blank, curve, panel
from zoo.report.comparison_figure import COLORS, INDENT, LEFT, STAGES_WIDE, WIDTH, best_of, colors_of, legend_above, legend_height
from zoo.report.palette import FLOOR
from zoo.report.time_figure import draw_temperature, limits
from zoo.report.wording import Scale
from zoo.scoring.comparison import UNCOMPENSATED
from zoo.scoring.stages import stage_names
from zoo.units import own_time

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from torch import Tensor

    from zoo.measurements.run import Run
    from zoo.scoring.stages import Stage

CLOSE = 3
"""Methods shown close to the noise."""
FLOOR_NAME = "± noise floor"


@dataclass(frozen=True, eq=False)
class Curves:
    """Block means of one run.

    Attributes:
        run: its name.
        hours: (N,) time [h].
        temperature_c: (N,) [°C].
        stage: of each block.
        left: (N,) what is left of the error by method, the uncompensated error first, then the best first [output's unit].
    """

    run: str
    hours: np.ndarray
    temperature_c: np.ndarray
    stage: list[str]
    left: dict[str, np.ndarray]

    @classmethod
    def of(cls, run: Run, stages: Sequence[Stage], left: Mapping[str, Tensor]) -> Curves:
        """From a run, its stages and (N,) residuals by method."""
        time, temperature = own_time(run.block_mean(run.time), float(run.time[0])) / 3600, run.block_mean(run.temperature)
        return cls(
            run.name, time.numpy(), temperature.numpy(), list(stage_names(list(stages))), {name: value.numpy() for name, value in left.items()}
        )


def run_figure(curves: Curves, floor: float, scale: Scale) -> Figure:
    """Three panels over one time axis: all before and after, the temperature by stage, and the best methods close to the noise.

    Args:
        curves: of the run.
        floor: its noise floor [output's unit].
        scale: how values are written.
    """
    colors = _colors(curves)
    named = colors | {FLOOR_NAME: FLOOR}
    head = 30 + legend_height([*named])
    figure = blank(WIDTH, head + 500)
    error = panel(figure, (LEFT, head, 664, 150), f"{curves.run}: error before and after [{scale.label}]{best_of(_methods(curves))}", INDENT)
    temperature = panel(figure, (LEFT, head + 194, 664, 70), "Temperature [°C]", INDENT, sharex=error)
    close = panel(figure, (LEFT, head + 308, 664, 150), _close_title(colors, scale), INDENT, sharex=error)
    _draw(error, curves, [*colors], colors, scale)
    _draw_close(close, curves, floor, colors, scale)
    _finish([error, temperature, close], temperature, curves)
    legend_above(figure, named)
    return figure


def halves(curves: Curves, floor: float, scale: Scale) -> tuple[Figure, Figure]:
    """The same as two figures that stand side by side on the page: all before and after, and the best methods; each over the temperature."""
    colors = _colors(curves)
    shown = {name: colors[name] for name in _closest(colors)} | {FLOOR_NAME: FLOOR}
    head = 30 + max(legend_height([*colors], STAGES_WIDE), legend_height([*shown], STAGES_WIDE))
    figures = []
    for named, title in ((colors, f"Error before and after [{scale.label}]{best_of(_methods(curves))}"), (shown, _close_title(colors, scale))):
        figure, wide = blank(STAGES_WIDE, head + 332), STAGES_WIDE - LEFT - 14
        axes = panel(figure, (LEFT, head, wide, 180), title, INDENT)
        temperature = panel(figure, (LEFT, head + 220, wide, 70), "Temperature [°C]", INDENT, sharex=axes)
        if FLOOR_NAME in named:
            _draw_close(axes, curves, floor, colors, scale)
        else:
            _draw(axes, curves, [*colors], colors, scale)
        _finish([axes, temperature], temperature, curves)
        legend_above(figure, named, STAGES_WIDE)
        figures.append(figure)
    return figures[0], figures[1]


def _colors(curves: Curves) -> dict[str, str]:
    """Of the uncompensated error and the best methods."""
    return colors_of([name for name in curves.left if name != UNCOMPENSATED][: len(COLORS)])


def _methods(curves: Curves) -> int:
    return sum(name != UNCOMPENSATED for name in curves.left)


def _closest(colors: Mapping[str, str]) -> list[str]:
    return [name for name in colors if name != UNCOMPENSATED][:CLOSE]


def _close_title(colors: Mapping[str, str], scale: Scale) -> str:
    return f"After, the best {len(_closest(colors))} [{scale.label}]"


def _draw(axes: Axes, curves: Curves, names: Sequence[str], colors: Mapping[str, str], scale: Scale) -> None:
    """The best last, above the others, but the uncompensated error, which is named first, below all."""
    below = names[:1] if names[0] == UNCOMPENSATED else []
    for name in [*below, *reversed(names[len(below) :])]:
        axes.plot(*curve(curves.hours, curves.left[name] * scale.factor), color=colors[name], lw=2.2 if name == UNCOMPENSATED else 1.1)


def _draw_close(axes: Axes, curves: Curves, floor: float, colors: Mapping[str, str], scale: Scale) -> None:
    axes.axhspan(-floor * scale.factor, floor * scale.factor, color=FLOOR, alpha=0.22, lw=0)
    _draw(axes, curves, _closest(colors), colors, scale)


def _finish(panels: Sequence[Axes], temperature: Axes, curves: Curves) -> None:
    """The temperature, and one time axis for all, told under the last."""
    draw_temperature(temperature, curves.hours, curves.temperature_c, curves.stage)
    for axes in panels[:-1]:
        axes.tick_params(labelbottom=False)
    panels[-1].set_xlim(*limits(curves.hours))
    panels[-1].set_xlabel("Time [h]")
