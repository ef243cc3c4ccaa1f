"""No line is drawn, and nothing shaded, where nothing was fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from zoo.report.canvas import LONG, curve
from zoo.report.gaps import covered, interrupted, pieces
from zoo.report.palette import WORST, styled
from zoo.report.time_figure import INNER, NUMBER_WIDTH, Shade, time_figure
from zoo.report.trace import Trace
from zoo.report.wording import DIAGNOSED, Scale

X = np.array([0.0, 1.0, 2.0, 6.0, 7.0, 9.0, 10.0])


def test_a_long_step_is_a_gap() -> None:
    assert pieces(X) == [slice(0, 3), slice(3, 5), slice(5, 7)]
    assert pieces(X * 1.4 + np.array([0, 0.1, 0, 0.1, 0, 0.1, 0])) == pieces(X)  # jitter is none
    assert pieces(np.arange(3.0)) == [slice(0, 3)]
    assert pieces(np.empty(0)) == []
    assert pieces(np.zeros(1)) == [slice(0, 1)]


def test_a_curve_is_interrupted_there() -> None:
    x, y = interrupted(X, X**2)
    assert x.tolist() == [0, 1, 2, 4, 6, 7, 8, 9, 10]
    assert np.flatnonzero(np.isnan(y)).tolist() == [3, 6]


def test_a_long_curve_keeps_gaps_and_extremes() -> None:
    x = np.concatenate([np.arange(3.0 * LONG), np.arange(4.0 * LONG, 8.0 * LONG)])
    y = 5.0 + np.random.default_rng(1).random(len(x))
    thin_x, thin_y = curve(x, y)
    assert len(thin_x) <= 1.5 * LONG
    assert np.isnan(thin_y).sum() == 1
    assert 3 * LONG - 1 < thin_x[np.isnan(thin_y)][0] < 4 * LONG
    assert (np.nanmin(thin_y), np.nanmax(thin_y)) == (y.min(), y.max())
    assert (np.diff(thin_x) > 0).all()


def test_what_is_covered_of_a_stretch() -> None:
    assert covered(X, 1.5, 9.2) == [(1.5, 2.5), (5.5, 7.5), (8.5, 9.2)]
    assert covered(X, 3.0, 5.0) == []


@pytest.fixture
def gappy(traces: list[Trace]) -> Trace:
    """Blocks 100 to 299 are held out."""
    keep = np.r_[0:100, 300:420]
    arrays = {name: getattr(traces[1], name)[keep] for name in ("time_s", "temperature_c", "rate_k_per_min", "error", "model", "refined")}
    return replace(traces[1], stage=[traces[1].stage[i] for i in keep], **arrays)


def test_the_drawing_leaves_the_gap_out(gappy: Trace) -> None:
    with styled():
        figure = time_figure(gappy, [Shade(1, 2.0, 9.0)], Scale("°/h"), 0.01, DIAGNOSED)
    first, last = gappy.hours[99], gappy.hours[100]
    lines = [line for axes in figure.axes for line in axes.lines]
    assert len(lines) >= 7
    for line in lines:
        x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        bridged = np.isfinite(y[:-1]) & np.isfinite(y[1:]) & (x[1:] - x[:-1] > 1.0)
        assert not bridged.any(), line.get_label()
    for axes in (figure.axes[0], figure.axes[2]):
        spans = [patch.get_extents().transformed(axes.transData.inverted()) for patch in axes.patches if _is(patch, WORST)]
        assert [(span.x0 < first, span.x1 > last) for span in spans] == [(True, False), (False, True)]
        assert all(span.x1 < first + 0.02 or span.x0 > last - 0.02 for span in spans)


def _is(patch, color: str) -> bool:
    from matplotlib.colors import to_rgb

    return patch.get_facecolor()[:3] == to_rgb(color)


@pytest.mark.parametrize("start", [0.0, 5.0, 9.8])
def test_numbers_of_neighbours_stand_side_by_side(traces: list[Trace], start: float) -> None:
    with styled():
        figure = time_figure(traces[2], [Shade(i, start + 0.02 * i, start + 0.1 + 0.02 * i) for i in (1, 2, 3, 4)], Scale("°/h"), 0.01, DIAGNOSED)
    numbers = [text for text in figure.axes[0].texts if text.get_text().isdigit()]
    left, right = figure.axes[0].get_xlim()
    pixels = sorted((text.xy[0] - left) / (right - left) * INNER for text in numbers)
    assert len({text.get_position()[1] for text in numbers}) == 1  # one line: a second would run into the legend below
    assert np.diff(pixels) == pytest.approx(np.maximum(np.diff(pixels), NUMBER_WIDTH))
    assert 0 <= pixels[0] < pixels[-1] <= INNER + 1e-6
