"""Reliability of the probabilities, and detection against amplitude beside what an ideal detector would find."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from hidden_effects.acceptance import Rows, of
from hidden_effects.limits import calibration_error, ideal, reliability, share_interval
from hidden_effects.recipe import LARGEST, SMALLEST
from hidden_effects.verdicts import Row, hidden_names, right, stated
from matplotlib.axes import Axes
from matplotlib.figure import Figure

BINS, TICKS = 6, (0.2, 0.5, 1, 2, 5)
OURS, LIMIT = "#1f5fa8", "#c2571a"


def reliability_figure(rows: Rows, path: Path) -> None:
    """Share right against the probability stated."""
    said, hit = [stated(row) for row in rows], [right(row) for row in rows]
    figure = Figure(figsize=(5, 5), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], color="0.7", lw=1)
    for p, share, count in reliability(said, hit):
        low, high = share_interval(round(share * count), count)
        axes.errorbar(p, share, yerr=[[max(share - low, 0)], [max(high - share, 0)]], fmt="o", color=OURS, capsize=3)
        axes.annotate(str(count), (p, share), textcoords="offset points", xytext=(6, 4), fontsize=8)
    axes.set(xlabel="probability of the stated verdict", ylabel="share right", xlim=(0, 1.02), ylim=(0, 1.02))
    axes.set_title(f"{len(rows)} cases, calibration error {calibration_error(said, hit):.3f}; bars 90 %", fontsize=10)
    _save(figure, path)


def detection_figure(rows: Rows, path: Path) -> None:
    """One panel an effect: share right in bins of the amplitude, and the ideal detector's on the same cases."""
    single = [row for kind in ("one", "outside") for row in of(rows, kind)]
    names = sorted({hidden_names(row)[0] for row in single}, key=lambda name: (name == "outside", name))
    across = 4
    figure = Figure(figsize=(3 * across, 2.4 * -(-len(names) // across) + 0.4), layout="constrained")
    panels = figure.subplots(-(-len(names) // across), across, squeeze=False, sharex=True, sharey=True).ravel()
    for axes, name in zip(panels, names, strict=False):
        _panel(axes, name, [row for row in single if hidden_names(row) == [name]])
    for axes in panels[len(names) :]:
        axes.set_visible(False)
    figure.supxlabel("amplitude [white noise of a mean over 10 s]")
    figure.supylabel("share right (bars 90 %); ideal detector (orange)")
    _save(figure, path)


def _panel(axes: Axes, name: str, rows: Sequence[Row]) -> None:
    edges = np.geomspace(SMALLEST, LARGEST, BINS + 1)
    size = np.array([row["hidden"][0]["amplitude"] for row in rows])
    hit = np.array([right(row) for row in rows])
    best = ideal(np.array([row["hidden"][0]["z"] for row in rows]), np.array([row["candidates_tried"] for row in rows]))
    axes.scatter(size, best, s=8, color=LIMIT, alpha=0.35)
    place = np.clip(np.searchsorted(edges, size) - 1, 0, BINS - 1)
    for i in np.unique(place):
        own, middle = place == i, float(np.sqrt(edges[i] * edges[i + 1]))
        low, high = share_interval(int(hit[own].sum()), int(own.sum()))
        share = float(hit[own].mean())
        axes.errorbar(middle, share, yerr=[[max(share - low, 0)], [max(high - share, 0)]], fmt="o", ms=4, color=OURS, capsize=2)
        axes.plot(middle, float(best[own].mean()), "_", ms=14, color=LIMIT)
    axes.set(xscale="log", ylim=(-0.05, 1.05))
    axes.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
    axes.minorticks_off()
    axes.set_title(f"{name} ({len(rows)})", fontsize=9)


def _save(figure: Figure, path: Path) -> None:
    with mpl.rc_context({"font.size": 9}):
        figure.savefig(path, dpi=130)
