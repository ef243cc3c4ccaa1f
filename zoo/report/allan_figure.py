"""What is left by averaging time, beside what the noise leaves: the drawing by which gyros are judged."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import torch
from markupsafe import Markup

from zoo.report.canvas import blank, inline_svg, panel
from zoo.report.comparison_figure import scaled
from zoo.report.gaps import pieces, usual_step
from zoo.report.palette import FLOOR, MODEL, REFINED, styled
from zoo.report.trace import Trace
from zoo.report.verdict import Record
from zoo.report.wording import Scale, Sides, finite
from zoo.scoring.allan import expected_allan_deviation, pooled_allan_deviation
from zoo.units import convert

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, LEFT, TOP, INNER, HIGH, FOOT = 740, 62, 36, 664, 230, 48
SHARE = 4
"""The longest averaging time is one in so many of the longest piece: beyond, one difference decides."""
FEWEST = 16
"""Blocks of the longest piece below which there is nothing to average."""


def allan_drawing(traces: list[Trace], noise: Record, scale: Scale, sides: Sides) -> Markup | None:
    """The figure for the page; None where no run is long enough.

    Args:
        traces: the runs; those fitted are drawn.
        noise: white RMS of a block, bias instability B [output's unit] and random walk K [unit/√h], as far as they are known.
        scale: how values are written.
        sides: what the two models are called.
    """
    fitted = [trace for trace in traces if trace.role != "check" and len(trace.time_s)]
    longest = max((piece.stop - piece.start for trace in fitted for piece in pieces(trace.time_s)), default=0)
    if longest < FEWEST:
        return None
    with styled("allan"):
        figure = allan_figure(fitted, noise, longest, scale, sides)
        return inline_svg(figure, "Allan deviation of the residual of the fitted runs against averaging time")


def allan_figure(fitted: list[Trace], noise: Record, longest: int, scale: Scale, sides: Sides) -> Figure:
    """Residuals of both models and the noise, on logarithmic axes; arguments as of `allan_drawing`, and the blocks of the longest piece."""
    figure = blank(WIDTH, TOP + HIGH + FOOT)
    axes = panel(figure, (LEFT, TOP, INNER, HIGH), f"Allan deviation of the residual [{scale.label}]")
    step, factors = usual_step(fitted[0].time_s), [2**power for power in range(int(np.log2(longest / SHARE)) + 1)]
    drawn: list[np.ndarray] = []

    def line(of: Callable[[Trace], np.ndarray | None], color: str, marker: str, label: str) -> torch.Tensor:
        parts = [torch.from_numpy(np.asarray(of(trace), dtype=float)[piece]) for trace in fitted for piece in pieces(trace.time_s)]
        tau, deviation = pooled_allan_deviation(parts, step, factors)
        drawn.append(scale.factor * deviation.numpy())
        axes.plot(convert(tau.numpy(), "s", "min"), drawn[-1], f"{marker}-", color=color, lw=1.6, ms=5, label=label)
        return tau

    tau = line(lambda trace: trace.residual, MODEL, "o", sides.stands)
    minutes = convert(tau.numpy(), "s", "min")
    if all(trace.residual_after is not None for trace in fitted):
        line(lambda trace: trace.residual_after, REFINED, "D", sides.added)
    white, flicker, walk = (finite(noise.get(key)) or 0.0 for key in ("white", "flicker", "walk"))
    if white:
        expected = scale.factor * expected_allan_deviation(tau, step, white, flicker, walk).numpy()
        drawn.append(expected)
        axes.plot(minutes, expected, color=FLOOR, lw=5, alpha=0.3, label="noise" if flicker or walk else "white noise", zorder=1)
    scaled(axes.yaxis, [float(value) for values in drawn for value in values if np.isfinite(value)])
    scaled(axes.xaxis, minutes.tolist())
    axes.set_xlabel("Averaging time [min]")
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1.0), borderpad=0.9, ncols=3, handlelength=1.6)
    return figure
