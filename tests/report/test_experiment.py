"""The proposed run on the page and on the terminal."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import pytest

from zoo.report.experiment import experiment_drawing, experiment_line, experiment_settings, separated
from zoo.report.wording import Scale

SCALE = Scale.of("dph", 0.008, 0.07)
CURVES = {
    "compared": ["fixture_rotation", "mohr"],
    "time_s": [0.0, 1800.0, 3600.0, 5400.0],
    "temperature_c": [20.0, 30.0, 40.0, 50.0],
    "reference": [10.0, -10.0, 10.0, -10.0],
    "difference": [0.0, 0.05, -0.05, 0.05],
}
EXPERIMENT: dict[str, Any] = {
    "separates": ["fixture_rotation", "mohr"],
    "why": "turning the axis over",
    "name": "a cycle with the axis turned over",
    "profile": {"legs": [[20.0, 50.0, 5400.0]]},
    "input": "axis_flip",
    "duration_s": 5400.0,
    "expected_evidence": 51.3,
    "command": "fogzoo simulate profile=legs",
    "alternatives": [{"name": "a rest", "duration_s": 14400.0, "expected_evidence": 12.0}],
    "prediction": CURVES,
}


def test_the_drawing_shows_temperature_input_and_difference() -> None:
    drawing = str(experiment_drawing(EXPERIMENT, SCALE))
    assert "a cycle with the axis turned over" in drawing
    for title in ("Temperature", "chamber", "True input", "fixture_rotation, less mohr"):
        assert title in drawing


def test_an_input_that_stays_is_not_drawn() -> None:
    still = {**EXPERIMENT, "prediction": {**CURVES, "reference": [10.0] * 4}}
    drawing = str(experiment_drawing(still, SCALE))
    assert "True input" not in drawing
    assert "Temperature" in drawing


@pytest.mark.parametrize(
    "broken", [None, {}, {**CURVES, "difference": None}, {**CURVES, "time_s": [0.0]}, {**CURVES, "reference": [1.0, 2.0, None, 4.0]}]
)
def test_nothing_is_drawn_of_curves_that_are_not_whole(broken: Any) -> None:
    assert experiment_drawing({**EXPERIMENT, "prediction": broken}, SCALE) is None


def test_a_program_that_is_not_legs_is_left_out() -> None:
    drawing = str(experiment_drawing({**EXPERIMENT, "profile": {"legs": [[20.0, None, 5400.0]]}}, SCALE))
    assert "thermometer, as expected" in drawing
    assert ">chamber<" not in drawing
    assert ">chamber<" in str(experiment_drawing(EXPERIMENT, SCALE))


def test_one_line_for_the_terminal() -> None:
    line = experiment_line(EXPERIMENT)
    assert line == "to separate fixture_rotation and mohr: a cycle with the axis turned over (1.50 h, log Bayes factor 51)"
    assert experiment_line(None) is None
    assert experiment_line({"separates": ["a", "b"], "why": "", "profile": {}}) is None


@pytest.mark.parametrize(
    ("names", "alike", "told"),
    [
        ("abc", [], "a, b and c"),
        ("abc", ["bc"], "a and (b or c)"),
        ("abcd", ["ac", "de"], "(a or c), b and d"),
        ("abc", ["ab", "bc"], "a, b and c"),
        ("abcd", ["ad", "bc", "cd"], "a, b, c and d"),
        ("", [], ""),
    ],
)
def test_what_stays_alike_is_one_side(names: str, alike: list[str], told: str) -> None:
    assert separated({"separates": list(names), "not_separated": [list(pair) for pair in alike]}) == told


def test_what_else_a_reader_should_know() -> None:
    rows = dict(experiment_settings(EXPERIMENT))
    assert rows == {
        "Needs besides a chamber": "a fixture that turns the input axis over",
        "Alternative 1": "a rest (4.00 h, log Bayes factor 12)",
    }
    bare = deepcopy(EXPERIMENT)
    bare.update(input=None, alternatives=None)
    assert experiment_settings(bare) == []


@pytest.mark.parametrize(
    ("hours", "evidence", "enough", "why"),
    [(7.0, 130.0, True, ": longer, for more than is needed"), (7.0, 40.0, True, ""), (1.0, 130.0, True, ""), (7.0, 130.0, False, "")],
)
def test_a_run_that_would_tell_more_is_told_to_take_longer(hours, evidence, enough, why) -> None:
    other = {"name": "a cycle", "duration_s": 3600 * hours, "expected_evidence": evidence}
    rows = dict(experiment_settings({**EXPERIMENT, "enough": enough, "alternatives": [other]}))
    assert rows["Alternative 1"] == f"a cycle ({hours:.2f} h, log Bayes factor {evidence:.0f}){why}"
