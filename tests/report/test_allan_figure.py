"""What is left by averaging time: drawn of the fitted runs, beside the noise, across no gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from zoo.report.allan_figure import allan_drawing, allan_figure
from zoo.report.trace import Trace
from zoo.report.wording import DIAGNOSED, Scale

SCALE = Scale.of("dph", 0.0081, 0.07)
WHITE = {"white": 0.0081}


def lines(traces: list[Trace], noise: dict[str, float]) -> dict[str, np.ndarray]:
    axes = allan_figure(traces, noise, min(len(trace.time_s) for trace in traces), SCALE, DIAGNOSED).axes[0]
    return {str(line.get_label()): np.asarray(line.get_ydata()) for line in axes.lines}


def test_what_is_missing_rises_above_the_noise_and_the_rest_lies_on_it(traces: list[Trace]) -> None:
    drawn = lines([trace for trace in traces if trace.role == "fit"], WHITE)
    before, after, noise = (drawn[name] for name in ("as it stands", "with the missing effects", "white noise"))
    assert after[:4] == pytest.approx(noise[:4], rel=0.2)
    assert max(before / noise) > 3
    assert noise[2] == pytest.approx(noise[0] / 2)


def test_a_jump_in_a_gap_is_no_step(traces: list[Trace]) -> None:
    """The two sides of a gap may be far apart: no difference is taken across it."""
    trace = replace(traces[0], refined=None)
    half = np.arange(len(trace.time_s)) >= len(trace.time_s) // 2
    later = replace(trace, time_s=trace.time_s + 7200.0 * half)
    far = replace(later, error=trace.error + 5.0 * half)
    assert lines([far], WHITE)["as it stands"] == pytest.approx(lines([later], WHITE)["as it stands"], rel=1e-9)


def test_without_fitted_runs_or_with_short_ones_there_is_no_drawing(traces: list[Trace]) -> None:
    short = replace(traces[0], **{key: getattr(traces[0], key)[:12] for key in ("time_s", "error", "model", "refined")})
    assert allan_drawing([short], WHITE, SCALE, DIAGNOSED) is None
    assert allan_drawing([replace(traces[0], role="check")], WHITE, SCALE, DIAGNOSED) is None
    assert allan_drawing([], WHITE, SCALE, DIAGNOSED) is None
    assert "<title>Allan deviation" in str(allan_drawing(traces, {}, SCALE, DIAGNOSED))
