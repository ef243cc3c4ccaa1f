"""Single blocks: which ones a condition keeps, and which are drawn to fit and to check on."""

from __future__ import annotations

from typing import Any

import pytest
import torch

from zoo.errors import InputError
from zoo.measurements.points import Points
from zoo.measurements.run import OUTPUT, Run
from zoo.models.polynomial import Polynomial
from zoo.models.prediction import predict_blocks
from zoo.training.least_squares import LeastSquares

RATES = (-20.0, -10.0, 0.0, 10.0, 20.0)
SAMPLES = 3  # a block


def table(name: str = "run_1", levels: int = 4) -> Run:
    """A rate table at some temperatures: the error is 0.5 + 0.1 × the output, so that reference = 0.9 × output − 0.5; three samples a point."""
    reference = torch.tensor(RATES * levels, dtype=torch.float64).repeat_interleave(SAMPLES)
    temperature = torch.arange(levels, dtype=torch.float64).repeat_interleave(len(RATES) * SAMPLES)
    time = torch.arange(len(reference), dtype=torch.float64)
    error = (reference + 0.5) / 0.9 - reference
    block = torch.arange(levels * len(RATES)).repeat_interleave(SAMPLES)
    columns = ("time_s", "temperature_c", "reference_dph")
    return Run(name, "dph", 3.0, columns, torch.stack([time, temperature, reference], 1), error, torch.ones_like(block), block, len(time))


def points_of(run: Run) -> list[tuple[float, float]]:
    return list(zip(run.block_mean(run.temperature).tolist(), run.block_mean(run.column("reference_dph")).tolist(), strict=True))


def test_only_blocks_that_meet_the_condition_are_left_in_their_order() -> None:
    (kept,) = Points("reference_dph != 0 and temperature_c >= 1").meeting([table()])
    assert points_of(kept) == [(level, rate) for level in (1.0, 2.0, 3.0) for rate in RATES if rate]
    assert len(kept.time) == len(table().time)  # what remembers still sees all


def test_a_condition_may_ask_for_the_output() -> None:
    (kept,) = Points("abs(output) > 15").meeting([table()])
    assert {rate for _, rate in points_of(kept)} == {-20.0, 20.0}


def test_fitted_and_checked_are_drawn_once_without_an_overlap() -> None:
    runs = [table("a"), table("b", levels=6)]
    fitted, checked = Points(fitted=30, checked=12, seed=3).drawn(runs)
    drawn = [(one.name.split()[0], point) for one in (*fitted, *checked) for point in points_of(one)]
    assert [sum(one.blocks for one in part) for part in (fitted, checked)] == [30, 12]
    assert len(set(drawn)) == 42
    again = Points(fitted=30, checked=12, seed=3).drawn(runs)
    assert [points_of(one) for part in again for one in part] == [points_of(one) for part in (fitted, checked) for one in part]
    other = Points(fitted=30, checked=12, seed=4).drawn(runs)
    assert points_of(other[1][0]) != points_of(checked[0])


def test_whoever_is_not_checked_on_is_fitted() -> None:
    fitted, checked = Points(checked=5).drawn([table()])
    assert sorted(points_of(fitted[0]) + points_of(checked[0])) == sorted(points_of(table()))
    assert Points().drawn([table()])[1] == []


def chosen(settings: dict[str, Any]) -> None:
    points = Points(**settings)
    points.drawn(points.meeting([table()]))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"where": 3}, "data.points.where=3"),
        ({"where": "reference_dph"}, "is no condition"),
        ({"where": "rate != 0"}, "'rate' is not defined; run_1 has time_s, temperature_c, reference_dph, output"),
        ({"where": "reference_dph !="}, "SyntaxError"),
        ({"where": "temperature_c > 99"}, "no block of run_1 meets it"),
        ({"fitted": 0}, "data.points.fitted=0: a whole number from 1"),
        ({"checked": 0.3}, "data.points.checked=0.3: a whole number from 0"),
        ({"checked": 20}, "data.points.checked=20: the runs have 20 blocks"),
        ({"where": "reference_dph != 0", "fitted": 10, "checked": 7}, "fitted=10 and checked=7: the runs have 16 blocks where"),
    ],
)
def test_what_cannot_be_is_said(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        chosen(settings)


def test_an_error_that_goes_with_the_input_is_known_from_the_output_alone() -> None:
    """The reference is not known in flight; the output is, and tells this error exactly."""
    fitted, checked = Points(checked=5).drawn([table()])
    model = Polynomial([OUTPUT])
    LeastSquares().fit(model, fitted, torch.Generator().manual_seed(1))
    assert model.inputs == ["time_s", OUTPUT]
    for one in checked:
        assert torch.allclose(predict_blocks(model, one), one.block_mean(one.error), rtol=0, atol=1e-12)
