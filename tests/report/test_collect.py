"""What is drawn of a model: predictions, and where it was fitted what it left there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from zoo.catalog import build
from zoo.measurements.run import Run
from zoo.models.graybox import GrayBox
from zoo.models.prediction import predict_blocks
from zoo.report.collect import traces

BLOCK, STEP_S = 10, 10.0


def recorded(name: str, blocks: int) -> Run:
    time = STEP_S * torch.arange(blocks * BLOCK, dtype=torch.float64)
    table = torch.stack([time, 20 + 5 * torch.sin(time / 900), torch.zeros_like(time)], dim=-1)
    columns = ("time_s", "temperature_c", "reference_dph")
    return Run(name, "dph", STEP_S * BLOCK, columns, table, torch.cos(time / 700), torch.ones_like(time), torch.arange(blocks * BLOCK) // BLOCK)


@pytest.fixture
def model() -> GrayBox:
    """With an effect that has values for each fitted run, and predicts nothing for any other."""
    return GrayBox(
        {"static_bias": build("effects", "static_bias"), "chamber_cycling": build("effects", "chamber_cycling")},
        ["time_s", "temperature_c", "reference_dph"],
    )


def test_what_a_fit_left_is_believed_run_by_run(model) -> None:
    runs = [recorded("run_1", 12), recorded("run_2", 9)]
    left, refined = 0.01 * torch.arange(21, dtype=torch.float64), torch.full((21,), 0.002, dtype=torch.float64)
    drawn = traces(runs, "fit", model, model, left, refined)
    for trace, part in zip(drawn, left.split([12, 9]), strict=True):
        np.testing.assert_allclose(trace.residual, part, atol=1e-12)
        np.testing.assert_allclose(trace.residual_after, 0.002, atol=1e-12)


def test_elsewhere_the_model_predicts(model) -> None:
    run = recorded("check", 12)
    (trace,) = traces([run], "check", model)
    assert trace.refined is None
    np.testing.assert_array_equal(trace.model, predict_blocks(model, run))


def test_hours_are_those_of_the_run_whatever_its_clock_counts_from(model) -> None:
    """Also of a piece of it, as is held out: that begins later in the run."""
    run = recorded("run_1", 12)
    run.block[: 4 * BLOCK], run.block[4 * BLOCK :] = -1, torch.arange(8 * BLOCK) // BLOCK
    later = replace(run, table=run.table + torch.tensor([1.7e9, 0.0, 0.0], dtype=torch.float64))
    own, other = (traces([one], "check", model)[0].hours for one in (run, later))
    np.testing.assert_allclose(own, other, atol=1e-6)
    assert own[0] == pytest.approx(4.5 * BLOCK * STEP_S / 3600, rel=0.02)
