"""The figures of a chamber run: the drift over temperature, what every method predicts and what it leaves over time, and the figures of merit."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from zoo.papers.study import Row, Study
from zoo.report.paper_figures import compensated_figure, drift_figure, fits_figure, table_figure
from zoo.scoring.comparison import WHOLE
from zoo.units import symbol

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figures(study: Study, rows: list[Row]) -> dict[str, Figure]:
    """All of them, by the name of their file."""
    unit = symbol(study.runs[0].unit)
    found = {"drift": drift_figure(study, unit)}
    for sample, run in enumerate(study.runs):
        found |= {f"fits_{run.name}": fits_figure(study, sample, unit), f"compensated_{run.name}": compensated_figure(study, sample, unit)}
    quantities = dict.fromkeys(row.quantity for row in rows)
    return found | {re.sub(r"[^a-z]+", "_", quantity.lower()): table_figure(rows, quantity, WHOLE) for quantity in quantities}
