"""Rows of the tables that set models side by side."""

import pytest
import torch

from zoo.scoring.comparison import alike, residuals, rms_by_kind, rms_by_stage
from zoo.scoring.stages import Stage


def stages() -> list[Stage]:
    kinds = [("hold", 0, 2), ("edge", 2, 3), ("heating", 3, 5), ("edge", 5, 6)]
    return [Stage(a, b, kind, 100.0 * a, 100.0 * (b - 1), (20.0 + a, 20.0 + b)) for kind, a, b in kinds]


ERROR = torch.tensor([1.0, 1.0, 2.0, 3.0, -3.0, 4.0], dtype=torch.float64)


def test_kinds_are_pooled_and_the_whole_run_comes_last() -> None:
    rows = rms_by_kind(residuals(ERROR, {"half": ERROR / 2}), stages())
    assert [(row["stage"], row["blocks"]) for row in rows] == [("hold", 2), ("heating", 2), ("edge", 2), ("whole", 6)]
    assert [row["uncompensated"] for row in rows] == pytest.approx([1.0, 3.0, 10**0.5, (40 / 6) ** 0.5])
    assert [row["half"] for row in rows] == pytest.approx([0.5 * row["uncompensated"] for row in rows])


def test_squares_of_the_stages_add_up_to_the_whole() -> None:
    *parts, whole = rms_by_kind({"a": ERROR}, stages())
    assert sum(row["blocks"] * row["a"] ** 2 for row in parts) == pytest.approx(whole["blocks"] * whole["a"] ** 2)


def test_single_stages_tell_where_they_are() -> None:
    rows = rms_by_stage(residuals(ERROR, {"perfect": ERROR}), stages())
    assert len(rows) == 4
    assert rows[2] == {
        "stage": "heating",
        "from_s": 300.0,
        "to_s": 400.0,
        "temperature_c": [23.0, 25.0],
        "rms": {"uncompensated": 3.0, "perfect": 0.0},
        "bias_stability": {"uncompensated": pytest.approx(18**0.5), "perfect": 0.0},
    }


def test_models_that_predict_the_same_are_one() -> None:
    other = ERROR / 2 + 1e-7 * torch.arange(6)
    runs = [
        residuals(ERROR, {"a": ERROR / 2, "b": other, "c": ERROR / 2 + 1e-12, "d": ERROR / 2}),
        residuals(ERROR, dict.fromkeys("abc", ERROR) | {"d": other}),
    ]
    assert alike(runs[:1], ["a", "b", "c", "d"]) == [["a", "c", "d"], ["b"]]
    assert alike(runs, ["a", "b", "c", "d"]) == [["a", "c"], ["b"], ["d"]]  # in every run
