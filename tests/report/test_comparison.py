"""Any number of methods side by side: on a narrow terminal, in figures, and in words that say no more than is known."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from zoo.report import comparison_page
from zoo.report.comparison_figure import COLORS, OTHERS, colors_of
from zoo.report.comparison_page import scale_of, seeds_drawn, stage_rows, stages_drawn, write_comparison
from zoo.report.comparison_table import print_comparison
from zoo.report.comparison_words import (
    distance,
    extrapolations,
    fitted_note,
    goes_with,
    headline,
    leaders,
    sentences,
    statement,
    too_good,
    useless,
)
from zoo.report.palette import MEASURED, styled
from zoo.report.run_figure import Curves, halves, run_figure
from zoo.report.wording import Scale

STAGES = ("hold", "heating", "cooling", "edge", "whole")
RUNS = ("check", "other")


def method(name: str, median: float, seeds: int = 1) -> dict[str, Any]:
    spread = {"median": median, "low": 0.9 * median, "high": 1.2 * median, "interval": [0.95 * median, 1.05 * median]}
    places = [(run, stage) for run in (*RUNS, "all runs") for stage in STAGES]
    return {
        "name": name,
        "models": [f"{name}_seed{i}" for i in range(seeds)],
        "seeds": list(range(seeds)),
        "distinct": seeds,
        "typical": f"{name}_seed0",
        "rms": spread,
        "interval_over": "seeds" if seeds > 1 else "time",
        "by_seed": list(np.linspace(0.9 * median, 1.2 * median, seeds)) if seeds > 1 else [median],
        "excess": median / 0.05,
        "removed": 1 - median / 200,
        "rows": [{"run": run, "stage": stage, "blocks": 50, **spread, "excess": median / 0.05} for run, stage in places],
        "where": [{"run": "check", "from_s": 0, "to_s": 3600, "stage": "hold", "temperature_c": [20, 20], "rms": 2 * median, "excess": 40 * median}],
        "goes_with": {"temperature": 0.6, "constant": 0.2, "time": 0.01},
        "fitted_runs": [],
        "held_out": 0.0,
        "beyond": {},
    }


def pair(first: str, second: str, verdict: str = "better", **more: Any) -> dict[str, Any]:
    known = {
        "ratio": 0.88,
        "interval": [0.82, 0.93],
        "interval_over": "seeds",
        "interval_over_time": [0.8, 0.96],
        "wins": 87,
        "ties": 0,
        "seeds": 100,
    }
    return {"first": first, "second": second, "verdict": verdict, "paired": True, **known, **more}


def document(methods: int, seeds: int = 1, verdict: str = "better") -> dict[str, Any]:
    found = [method(f"a_network_called_{i}", 0.123456 + i, seeds) for i in range(methods)]
    best = found[0]["name"]
    return {
        "unit": "dph",
        "average_s": 100.0,
        "rms": {"uncompensated": 200.0} | {one["name"]: one["rms"]["median"] for one in found},
        "rows": [{"run": run, "stage": stage, "blocks": 50, "uncompensated": 200.0} for run in RUNS for stage in STAGES],
        "runs": [{"run": run} for run in RUNS],
        "ranked_by": list(RUNS),
        "models": [{"name": name, "folder": f"outputs/{name}", "init": None, "optimizer": None} for one in found for name in one["models"]],
        "noise_floor": 0.05,
        "noise_floors": dict.fromkeys(RUNS, 0.05),
        "noise": None,
        "methods": found,
        "pairs": [pair(best, one["name"], verdict) for one in found[1:]],
        "skipped": ["outputs/7"],
    }


def curves(of: dict[str, Any]) -> list[Curves]:
    hours = np.linspace(0, 10, 200)
    left = {name: np.sin(hours + i) for i, name in enumerate(["uncompensated", *(one["name"] for one in of["methods"])])}
    return [Curves(run, hours, 20 + hours, ["hold"] * 100 + ["heating"] * 100, left) for run in RUNS]


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize(("methods", "width"), [(1, 80), (12, 80), (40, 80), (12, 62), (12, 50), (12, 40)])
def test_names_and_numbers_are_whole(methods: int, width: int, terminal: bool) -> None:
    console, of = Console(file=io.StringIO(), width=width, force_terminal=terminal, color_system=None), document(methods)
    print_comparison(of, console)
    lines = console.file.getvalue().splitlines()  # type: ignore[attr-defined]
    assert not any(line.rstrip().endswith("…") for line in lines)
    numbers = [line for line in lines if line.count(".") == len(STAGES)]
    assert len(numbers) == 2 * (methods + 1)
    for line, value in zip(numbers, 2 * [200.0, *(0.123456 + i for i in range(methods))], strict=True):
        assert line.split()[-len(STAGES) :] == [f"{value:#.3g}"] * len(STAGES)
    assert sum(line.startswith("all runs") for line in lines) == 1


@pytest.mark.parametrize("methods", [1, 8, 9, 30])
def test_no_two_methods_of_one_colour_but_the_grey_ones(methods: int) -> None:
    names = [f"m{i}" for i in range(methods)]
    colors = colors_of(names)
    assert list(colors) == ["uncompensated", *names]
    assert colors["uncompensated"] == MEASURED
    vivid = [color for color in colors.values() if color in COLORS]
    assert len(set(vivid)) == len(vivid) == min(methods, len(COLORS))
    assert {name for name, color in colors.items() if color == OTHERS} == set(names[len(COLORS) :])  # the worst


@pytest.mark.parametrize(("methods", "seeds"), [(1, 1), (12, 20), (30, 1)])
def test_nothing_in_a_figure_touches_its_edge(methods: int, seeds: int) -> None:
    of = document(methods, seeds)
    scale = scale_of(of)
    with styled():
        for figure in (stages_drawn(of, scale), seeds_drawn(of, scale), run_figure(curves(of)[0], 0.05, scale), *halves(curves(of)[0], 0.05, scale)):
            width, height = figure.get_size_inches() * figure.dpi
            figure.draw_without_rendering()
            boxes = [text.get_window_extent() for axes in figure.axes for text in axes.texts]
            boxes += [legend.get_window_extent() for legend in figure.legends]
            boxes += [label.get_window_extent() for axes in figure.axes for label in axes.get_yticklabels() if label.get_text()]
            assert min(box.x0 for box in boxes) >= 1
            assert max(box.x1 for box in boxes) <= width
            assert max(box.y1 for box in boxes) <= height
            if figure.legends:
                legend = figure.legends[0].get_window_extent()
                assert all(axes.texts[0].get_window_extent().y1 <= legend.y0 for axes in figure.axes)


@pytest.mark.parametrize(("methods", "told"), [(8, ""), (12, ", the best 8 of 12 methods")])
def test_methods_that_are_not_drawn_are_counted(methods: int, told: str) -> None:
    of = document(methods, 20)
    scale = scale_of(of)
    with styled():
        for figure in (stages_drawn(of, scale), run_figure(curves(of)[0], 0.05, scale), halves(curves(of)[0], 0.05, scale)[0]):
            assert figure.axes[0].texts[0].get_text().endswith(f"]{told}")


def test_a_legend_is_read_row_by_row_and_a_value_stands_at_its_median() -> None:
    of = document(4, 20)
    with styled():
        figures = [stages_drawn(of, scale_of(of)), *halves(curves(of)[0], 0.05, scale_of(of)), seeds_drawn(of, scale_of(of))]
        for figure in figures:
            figure.draw_without_rendering()
        for figure in figures[:3]:
            boxes = [(text.get_text(), text.get_window_extent()) for text in figure.legends[0].get_texts()]
            names = [name for name, _ in sorted(boxes, key=lambda one: (-round(one[1].y0), one[1].x0)) if name.startswith("a_")]
            assert names == sorted(names)
    axes, scale = figures[3].axes[0], scale_of(of)
    values = [text for text in axes.texts if text.get_text() in {scale.text(one["rms"]["median"]) for one in of["methods"]}]
    assert [text.xy[0] for text in values] == pytest.approx([one["rms"]["median"] * scale.factor for one in of["methods"]])


def test_the_page_stands_alone_and_says_the_headline_first(tmp_path: Path) -> None:
    of = document(5, 10)
    for one in of["pairs"]:
        one["statement"] = statement(one)
    page = write_comparison(tmp_path, of, curves(of)).read_text(encoding="utf-8")
    assert "src=" not in page
    assert "href=" not in page.replace("xlink:href", "")
    assert page.index("<h1>") < page.index("a_<wbr>network_<wbr>called_<wbr>0 is best: 12 % below") < page.index("<table>")
    assert page.count("<svg") == 1 + 3 + 2 * len(RUNS)
    assert "outputs/7" in page


def test_a_run_without_a_stage_keeps_its_columns() -> None:
    of = document(2)
    for one in of["methods"]:
        one["rows"] = [row for row in one["rows"] if (row["run"], row["stage"]) != ("other", "cooling")]
    of["rows"] = [row for row in of["rows"] if (row["run"], row["stage"]) != ("other", "cooling")]
    assert [row["stage"] for row in stage_rows(of) if row["run"] == "other"] == ["hold", "heating", "edge", "whole"]
    with styled():
        figure = stages_drawn(of, scale_of(of), ["other"])
    assert [label.get_text() for label in figure.axes[0].get_xticklabels()] == ["hold", "heating", "edge", "whole"]


@pytest.mark.parametrize(
    ("of", "words"),
    [
        (pair("ACO-BP", "BP"), "ACO-BP is 12 % below BP (95 %: 7 to 18 %), better in 87 of 100 seeds"),
        (pair("A", "B", ratio=0.01, interval=[0.005, 0.015]), "A is 99.0 % below B (95 %: 98.5 to 99.5 %), better in 87 of 100 seeds"),
        (pair("A", "B", "same"), "A and B predict the same"),
        (
            pair("A", "B", "open", ratio=0.98, interval=[0.9, 1.07], wins=55),
            "A and B cannot be told apart: ratio 0.98, 95 %: 0.90 to 1.07; A better in 55 of 100 seeds",
        ),
        (
            pair("A", "B", interval_over_time=[0.7, 1.1]),
            "A is 12 % below B (95 %: 7 to 18 %), better in 87 of 100 seeds; "
            "other runs may turn it, as over time the difference is uncertain (95 %: −10 to 30 %)",
        ),
        (
            pair("A", "B", interval=None, interval_over=None, wins=3, seeds=3),
            "A is 12 % below B, better in 3 of 3 seeds; too few seeds for an interval (6 at least, over time 95 %: 4 to 20 %)",
        ),
        (
            pair("A", "B", "open", interval=None, interval_over=None, wins=4, seeds=5),
            "A and B cannot be told apart: A is better in 4 of 5 seeds, and fewer than 6 decide only if all agree; "
            "that the seeds in the middle differ (ratio 0.88, 95 % over time: 0.80 to 0.96) says nothing of the others",
        ),
        (
            pair("A", "B", interval=[0.8, 0.96], interval_over="time", wins=None, seeds=None, ties=None),
            "A is 12 % below B (95 % over time: 4 to 20 %)",
        ),
        (
            pair("A", "B", "worse", ratio=1.25, interval=[1.111, 1.333], interval_over_time=[1.05, 1.4], wins=10),
            "B is 20 % below A (95 %: 10 to 25 %), better in 90 of 100 seeds",
        ),
        (
            pair("A", "B", "open", interval=None, interval_over=None, interval_over_time=None, wins=None, seeds=None),
            "A and B cannot be told apart: ratio 0.88; the runs are too short for an interval",
        ),
    ],
)
def test_a_pair_in_words(of: dict[str, Any], words: str) -> None:
    assert statement(of) == words


def test_as_many_pairs_are_in_words_as_there_is_room_beside_the_drawing(tmp_path: Path) -> None:
    """Those with the best come first; all pairs of seven are twenty-one, three times as high as the drawing of seven."""
    of, shown = document(7, 10), "<h3>Pair by pair</h3>"
    of["pairs"] = [pair(one["name"], other["name"], "open") for i, one in enumerate(of["methods"]) for other in of["methods"][i + 1 :]]
    page = write_comparison(tmp_path, of, curves(of)).read_text(encoding="utf-8")
    beside, _, below = page[page.index(shown) :].partition("<details")
    assert beside.count("<li>") == 6
    assert below.startswith(' class="more"><summary>15 more</summary>')


def test_the_headline_claims_no_more_than_the_pairs() -> None:
    assert headline(document(3)) == "a_network_called_0 is best: 12 % below a_network_called_1"
    both = document(3)
    both["pairs"][0]["verdict"] = "open"
    assert leaders(both) == ["a_network_called_0", "a_network_called_1"]
    assert headline(both) == "a_network_called_0 and a_network_called_1 are best and cannot be told apart"
    assert headline(document(3, verdict="open")) == "a_network_called_0 is ahead, but the other 2 cannot be told from it"
    assert headline(document(1)) == "a_network_called_0 removes > 99 % of the error"
    worse = document(2)
    worse["rms"]["uncompensated"] = 0.1
    assert headline(worse) == "No compensation is better than all of them"
    uncertain = document(2)
    uncertain["pairs"][0]["interval_over_time"] = [0.7, 1.1]
    assert headline(uncertain) == "a_network_called_0 is best on these runs: 12 % below a_network_called_1"


def test_what_is_above_white_noise_need_not_be_the_models_fault() -> None:
    """Where only white noise is known, a gyro that flickers is above it beside a complete model."""
    near, far = (method("graybox", median) for median in (0.05, 0.1))
    scale = scale_of(document(1))
    assert "what is left is noise" in distance(near, scale, whole=False)
    assert "2.0× the white noise" in distance(far, scale, whole=False)
    assert "flicker and random walk, or something to explain" in distance(far, scale, whole=False)
    assert "2.0× the noise floor, so there is more to explain" in distance(far, scale, whole=True)
    assert "what is left is noise" in distance(near, scale, whole=True)
    assert "what is left may be noise (1.4× the floor)" in distance(method("graybox", 0.07), scale, whole=True)


def test_what_extrapolates_is_said_once_for_all_that_do_so_alike() -> None:
    far = {"temperature_c": {"fitted": [-30.0, 55.0], "reached": [-30.0, 70.0], "share": 0.123}}
    farther = {"temperature_c": {"fitted": [-30.0, 55.0], "reached": [-30.0, 80.0], "share": 0.5}}
    of = document(4)
    assert extrapolations(of) == []
    told = "check in 12 % of its time (temperature_c is −30.0 … 70.0 there, −30.0 … 55.0 in the fitted runs)."
    of["methods"][1]["beyond"] = {"check": far}
    assert extrapolations(of) == [f"Extrapolated by a_network_called_1: {told}"]
    of["methods"][0]["beyond"] = {"check": far}
    of["methods"][3]["beyond"] = {f"run_{i}": farther if i == 4 else far for i in range(5)}
    both, other = extrapolations(of)
    assert both == f"Extrapolated by a_network_called_0 and a_network_called_1: {told}"
    assert other.startswith("Extrapolated by a_network_called_3: run_4 in 50 % of its time (")
    assert other.endswith("; and 2 more.")
    for one in of["methods"]:
        one["beyond"] = {"check": far}
    assert extrapolations(of) == [f"Extrapolated by every model: {told}"]
    assert extrapolations(of)[0] in sentences(of, scale_of(of))


def test_who_is_worse_than_no_compensation_is_said() -> None:
    of = document(5)
    assert useless(of) == []
    of["rms"]["uncompensated"] = 3.0
    told = "Worse than no compensation: a_network_called_3 and a_network_called_4, with 1.0× and 1.4× the uncompensated RMS."
    assert useless(of) == [told]
    assert told in sentences(of, scale_of(of))
    of["rms"]["uncompensated"] = 1.0
    assert useless(of) == ["Worse than no compensation: 4 of the models, with more than the uncompensated RMS."]
    of["rms"]["uncompensated"] = 0.1
    assert useless(of) == []  # the headline says so
    assert headline(of) == "No compensation is better than all of them"


def test_runs_that_were_fitted_are_no_judges() -> None:
    of = document(2)
    of["methods"][0]["fitted_runs"] = list(RUNS)
    assert "runs that no model has seen" in sentences(of, scale_of(of))[-1]
    of["methods"][0]["fitted_runs"] = ["check"]
    assert "check; that flatters" in sentences(of, scale_of(of))[-1]


def test_who_was_fitted_to_which_run_is_said() -> None:
    of = document(5)
    for one, runs in zip(of["methods"], (["run_1"], ["run_1"], ["run_2"], ["run_1", "run_2"], []), strict=True):
        one["fitted_runs"] = runs
    names = [one["name"] for one in of["methods"]]
    each = f"run_1 by {names[0]} and {names[1]}; run_2 by {names[2]}; run_1 and run_2 by {names[3]}"
    assert (fitted_note(of) or "").startswith(f"Fitted, to go by name and error: {each}; that flatters them there")
    of["methods"][4]["fitted_runs"] = ["run_3"]
    assert f"{each}; others by 1 more; that" in (fitted_note(of) or "")


def test_what_is_below_the_noise_is_not_praised() -> None:
    """It sees the output, most likely."""
    of = document(3)
    assert too_good(of) == []
    assert comparison_page._state(of) == "complete"
    of["methods"][0] |= {"excess": 0.02}
    (told,) = too_good(of)
    assert told.startswith("Below the noise that neighbouring means differ by: a_network_called_0.")
    assert told in sentences(of, scale_of(of))
    assert "less than the noise of these runs (0.0× the floor)" in distance(of["methods"][0], scale_of(of), whole=True)
    assert goes_with(of["methods"][0]) == "What is left is less than the noise of these runs."
    assert comparison_page._state(of) == "missing"


def test_what_is_left_goes_with_what_has_most_of_it() -> None:
    assert goes_with(method("m", 1.0)) == "Of the mean square that is left, 60 % goes with temperature and 20 % is a constant, which overlap."
    assert goes_with(method("m", 0.05)) == "What is left is about noise."


def test_small_values_have_one_power_of_ten_everywhere() -> None:
    of = document(2)
    for one in of["methods"]:
        one["rms"] = {key: [1e-6 * end for end in value] if key == "interval" else 1e-6 * value for key, value in one["rms"].items()}
    of |= {"noise_floor": 1e-7, "rms": {name: 1e-6 * value for name, value in of["rms"].items()}}
    scale = scale_of(of)
    assert scale.label == Scale.of("dph", 1e-7, 1e-7).label != "°/h"
    console = Console(file=io.StringIO(), width=80)
    print_comparison(of, console)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    assert f"[{scale.label}]" in text
    assert " 123. " in " ".join(text.split()) + " "
    assert "1123 " in text
    assert not {"e-", "e+"} & {text[i : i + 2] for i in range(len(text))}
