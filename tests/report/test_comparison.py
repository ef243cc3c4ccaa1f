"""Any number of models side by side, on a narrow terminal and in a figure."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from zoo.report.comparison_figure import COLORS, OTHERS, colors_of, residual_figure, rms_figure
from zoo.report.comparison_table import print_comparison
from zoo.report.palette import MEASURED, styled

STAGES = ("hold", "heating", "cooling", "edge", "whole")


def many(models: int) -> tuple[list[dict[str, Any]], list[str], dict[str, float]]:
    columns = ["uncompensated", *(f"a_network_called_{i}" for i in range(models))]
    values = {name: 0.123456 + i for i, name in enumerate(columns)}
    rows = [{"run": run, "stage": stage, "blocks": 50, **values} for run in ("check", "other") for stage in STAGES]
    return rows, columns, values


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize(("models", "width"), [(1, 80), (12, 80), (40, 80), (12, 62), (12, 50), (12, 40), (12, 25)])
def test_names_and_numbers_are_whole(models: int, width: int, terminal: bool) -> None:
    rows, columns, pooled = many(models)
    console = Console(file=io.StringIO(), width=width, force_terminal=terminal, color_system=None)
    print_comparison("RMS", rows, columns, pooled, console)
    lines = console.file.getvalue().splitlines()  # type: ignore[attr-defined]
    assert not any("…" in line for line in lines)
    numbers = [line for line in lines if line.count(".") == len(STAGES)]
    assert len(numbers) == 2 * len(columns)
    for line, i in zip(numbers, 2 * list(range(len(columns))), strict=True):
        assert line.split()[-len(STAGES) :] == [f"{0.123456 + i:#.3g}"] * len(STAGES)
    if width >= 62:
        assert [line.split()[0] for line in numbers] == 2 * columns
        assert max(map(len, lines)) <= width
    assert sum(line.startswith("all runs") for line in lines) == 1


def test_one_run_needs_no_sum() -> None:
    rows, columns, pooled = many(2)
    console = Console(file=io.StringIO(), width=80)
    print_comparison("RMS", rows[:5], columns, pooled, console)
    assert "all runs" not in console.file.getvalue()  # type: ignore[attr-defined]


@pytest.mark.parametrize("models", [1, 8, 9, 30])
def test_no_two_models_of_one_colour_but_the_grey_ones(models: int) -> None:
    pooled = {"uncompensated": 9.0} | {f"m{i}": float(models - i) for i in range(models)}
    colors = colors_of(pooled)
    assert list(colors) == list(pooled)
    assert colors["uncompensated"] == MEASURED
    vivid = [color for color in colors.values() if color in COLORS]
    assert len(set(vivid)) == len(vivid) == min(models, len(COLORS))
    assert {name for name, color in colors.items() if color == OTHERS} == {f"m{i}" for i in range(models - len(COLORS))}  # the worst


@pytest.mark.parametrize("models", [1, 12, 30])
def test_nothing_in_a_figure_touches_its_edge(models: int) -> None:
    rows, columns, pooled = many(models)
    with styled():
        curves = {name: np.full(3, pooled[name]) for name in columns}
        for figure in (rms_figure(rows, pooled, "°/h"), residual_figure("check", np.arange(3.0), curves, "°/h", colors_of(pooled))):
            width, height = figure.get_size_inches() * figure.dpi
            figure.draw_without_rendering()
            boxes = [axes.texts[0].get_window_extent() for axes in figure.axes] + [figure.legends[0].get_window_extent()]
            assert min(box.x0 for box in boxes) >= 5
            assert max(box.x1 for box in boxes) <= width
            assert max(box.y1 for box in boxes) <= height
            legend = figure.legends[0].get_window_extent()
            assert all(axes.texts[0].get_window_extent().y1 <= legend.y0 for axes in figure.axes)
