"""One run over time: the error as measured and what each method leaves of it, with the temperature between."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from zoo.report.canvas import blank, curve, panel
from zoo.report.comparison_figure import COLORS, UNCOMPENSATED, WIDTH, colors_of, legend_above, legend_columns
from zoo.report.palette import FLOOR
from zoo.report.time_figure import draw_temperature, limits
from zoo.report.wording import Scale
from zoo.scoring.stages import stage_names

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure
    from torch import Tensor

    from zoo.measurements.run import Run
    from zoo.scoring.stages import Stage

CLOSE = 3
"""Methods shown close to the noise."""


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
        time, temperature = run.block_mean(run.time) / 3600, run.block_mean(run.temperature)
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
    names = [name for name in curves.left if name != UNCOMPENSATED][: len(COLORS)]
    colors = colors_of(names)
    named = colors | {"± noise floor": FLOOR}
    head = 30 + 18 * -(-len(named) // legend_columns(list(named)))
    figure = blank(WIDTH, head + 500)
    error = panel(figure, (62, head, 664, 150), f"{curves.run}: error before and after [{scale.label}]", 12)
    temperature = panel(figure, (62, head + 194, 664, 70), "Temperature [°C]", 12, sharex=error)
    close = panel(figure, (62, head + 308, 664, 150), f"After, the best {min(CLOSE, len(names))} [{scale.label}]", 12, sharex=error)
    close.axhspan(-floor * scale.factor, floor * scale.factor, color=FLOOR, alpha=0.22, lw=0)
    for axes, shown in ((error, [UNCOMPENSATED, *reversed(names)]), (close, list(reversed(names[:CLOSE])))):
        for name in shown:
            axes.plot(*curve(curves.hours, curves.left[name] * scale.factor), color=colors[name], lw=2.2 if name == UNCOMPENSATED else 1.1)
    draw_temperature(temperature, curves.hours, curves.temperature_c, curves.stage)
    for axes in (error, temperature):
        axes.tick_params(labelbottom=False)
    close.set_xlim(*limits(curves.hours))
    close.set_xlabel("Time [h]")
    legend_above(figure, named)
    return figure
