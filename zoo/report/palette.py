"""Colours and marks of all figures: Okabe & Ito (2008), told apart also without colour by lightness or shape."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

INK, MUTED, RULE = "#1d2733", "#5b6875", "#e3e7ec"
MEASURED, MODEL, REFINED = "#a3adb8", "#1d2733", "#009E73"
FIT, CHECK, FLOOR = "#0072B2", "#D55E00", "#5b6875"
WORST = "#F0E442"
STAGES = {"hold": ("#767c86", "o"), "heating": ("#D55E00", "^"), "cooling": ("#0072B2", "v"), "edge": ("#b3bbc4", "x")}
"""Colour and marker of every kind of stage."""

_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",
    "font.family": "DejaVu Sans",
    "font.size": 11,
    "text.color": INK,
    "text.parse_math": False,
    "axes.edgecolor": "#9aa5b1",
    "axes.linewidth": 0.8,
    "axes.labelcolor": MUTED,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "grid.color": RULE,
    "grid.linewidth": 0.8,
    "xtick.color": "#9aa5b1",
    "ytick.color": "#9aa5b1",
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "ytick.major.size": 0,
    "xtick.major.size": 3,
    "legend.frameon": False,
    "legend.fontsize": 10.5,
    "legend.borderpad": 0,
    "legend.borderaxespad": 0,
    "legend.handletextpad": 0.5,
    "legend.columnspacing": 1.4,
    "path.simplify_threshold": 0.2,
    "image.composite_image": True,
}


@contextmanager
def styled(salt: str = "fogzoo") -> Iterator[None]:
    """Draws in the report's style, and leaves matplotlib's settings as they were.

    Args:
        salt: makes the identifiers in one drawing differ from those in another on the same page.
    """
    import matplotlib as mpl

    settings: Any = {**_SETTINGS, "svg.hashsalt": salt}
    with mpl.rc_context(settings):
        yield
