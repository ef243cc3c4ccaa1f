"""The rate table's figures: what the paper prints in °/s, and what noise alone would leave."""

from __future__ import annotations

from itertools import pairwise

import pytest
import torch

from zoo.measurements.points import Points
from zoo.measurements.run import Run
from zoo.papers import liu2010
from zoo.papers.liu2010 import LARGEST, PRINTED, SPREAD, attainable
from zoo.papers.study import Study
from zoo.scoring.comparison import UNCOMPENSATED

SLOPE, THERMOMETER, GYRO = 1e-4, 0.02, 0.5  # relative change of the scale factor [1/K], noises [K], [°/h]


def study(kept: dict[str, list[float]]) -> Study:
    """A rate table whose scale factor changes by `SLOPE`; every method keeps shares of the error, one a seed."""
    chance = torch.Generator().manual_seed(1)
    level, rate = (one.flatten() for one in torch.meshgrid(torch.arange(-30.0, 61.0, 5.0), torch.arange(-180.0, 181.0, 10.0), indexing="ij"))
    level, reference = level.double(), 3600 * rate.double()
    error = SLOPE * level * reference + GYRO * torch.randn(len(level), generator=chance, dtype=torch.float64)
    seen = level + THERMOMETER * torch.randn(len(level), generator=chance, dtype=torch.float64)
    time = 600.0 * torch.arange(len(level), dtype=torch.float64)
    one = torch.arange(len(level))
    run = Run("run_1", "dph", 600.0, ("time_s", "temperature_c", "reference_dph"), torch.stack([time, seen, reference], 1), error, one * 0 + 1, one)
    fitted, checked = Points(fitted=448, checked=200).drawn([run])
    errors = [part.block_mean(part.error) for part in (*fitted, *checked)]
    predicted = {name: [torch.stack([(1 - share) * error for share in shares]) for error in errors] for name, shares in kept.items()}
    return Study.of([*fitted, *checked], 1, predicted)


def test_figures_are_in_degrees_a_second_beside_the_printed_ones() -> None:
    found = study({"T-S fuzzy": [0.01, 0.02, 0.03], "line": [0.5]})
    rows = {(row.model, row.quantity, row.sample): row for row in liu2010.rows(found)}
    assert len(rows) == 3 * 2 * 2
    assert rows[UNCOMPENSATED, LARGEST, "fitted"].ours == pytest.approx(float(found.runs[0].block_mean(found.runs[0].error).abs().max()) / 3600)
    assert rows["T-S fuzzy", SPREAD, "checked"].ours == pytest.approx(0.02 * rows[UNCOMPENSATED, SPREAD, "checked"].ours)
    assert rows["T-S fuzzy", SPREAD, "checked"].paper == 0.02856
    assert rows["line", LARGEST, "fitted"].paper == 3.4732


def test_noise_alone_leaves_the_gyros_and_the_thermometers_times_the_slope_at_each_rate() -> None:
    found = study({})
    rates = found.runs[1].block_mean(found.runs[1].table[:, -1])
    expected = (GYRO**2 + (SLOPE * THERMOMETER * rates).square().mean()).sqrt()
    assert attainable(found, GYRO) == pytest.approx(float(expected), rel=0.05)


def test_the_printed_order_holds_where_every_method_leaves_what_is_printed() -> None:
    before = PRINTED[UNCOMPENSATED][1][1]
    kept = {name: [PRINTED[name][1][1] / before] for name in liu2010.ORDER}
    claims = {claim.text: claim.holds for claim in liu2010.claims(study(kept), [GYRO, GYRO])}
    assert all(claims[f"{less} leaves less than {more}"] for more, less in pairwise(liu2010.ORDER))
    swapped = kept | {"BP": kept["T-S fuzzy"], "T-S fuzzy": kept["BP"]}
    claims = {claim.text: claim.holds for claim in liu2010.claims(study(swapped), [GYRO, GYRO])}
    assert claims["BP leaves less than LS-SVM"]
    assert not claims["T-S fuzzy leaves less than BP"]


def test_what_is_printed_as_a_variance_is_none() -> None:
    """No set of errors has a variance above the square of the largest."""
    assert [name for name, ((most, spread), _) in PRINTED.items() if spread > most**2] == ["BP", "T-S fuzzy"]
