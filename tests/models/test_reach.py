"""What other runs reach beyond the fitted ones is told of what a model goes by, and of nothing else."""

from __future__ import annotations

import pytest
import torch

from zoo.catalog import build
from zoo.measurements.run import Run
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.reach import beyond

INPUTS = ("time_s", "temperature_c", "supply_v", "reference_dph")
SAMPLES = 1200


def run(rate: float, supply: float) -> Run:
    """A ramp of so many K/s from 20 °C up and back down again, at one supply voltage that swings a little."""
    time = torch.arange(SAMPLES, dtype=torch.float64)
    up_and_down = rate * torch.minimum(time, SAMPLES - time)
    table = torch.stack([time, 20 + up_and_down, supply + 0.01 * torch.sin(time / 50), torch.full_like(time, 9.66)], dim=-1)
    return Run("run", "dph", 10.0, INPUTS, table, 0 * time, torch.ones(SAMPLES, dtype=torch.int64), torch.arange(SAMPLES) // 10)


def graybox(*effects: str) -> GrayBox:
    model = GrayBox({name: build("effects", name) for name in effects}, list(INPUTS))
    for _, effect in model.named_effects():
        effect.amplitude.data.fill_(0.3)
    return model


@pytest.mark.parametrize(("effects", "told"), [(["static_bias", "mohr"], []), (["static_bias", "supply_voltage"], ["supply_v"])])
def test_a_column_that_was_recorded_and_decides_nothing_is_not_told(effects, told) -> None:
    found = beyond(graybox(*effects), [run(0.05, 5.0)], [run(0.05, 6.0)])
    assert list(found) == told
    for one in found.values():
        assert one["fitted"] == pytest.approx([4.99, 5.01], abs=1e-4)
        assert one["reached"] == pytest.approx([5.99, 6.01], abs=1e-4)
        assert one["share"] == 1.0


def test_a_model_without_weight_on_an_effect_does_not_go_by_its_column() -> None:
    model = graybox("static_bias", "supply_voltage")
    dict(model.named_effects())["supply_voltage"].amplitude.data.zero_()
    assert beyond(model, [run(0.05, 5.0)], [run(0.05, 6.0)]) == {}


def test_rates_of_a_network_beside_effects_are_told() -> None:
    network = build("model", "polynomial", features=["temperature", "temperature_rate"])
    network.weight.data.fill_(0.1)
    hybrid = Hybrid(network, {"mohr": build("effects", "mohr")}, list(INPUTS))
    found = beyond(hybrid, [run(0.05, 5.0), run(0.004, 5.0)], [run(0.1, 6.0)])
    assert list(found) == ["temperature_c", "temperature_rate"]
    assert found["temperature_rate"]["fitted"] == pytest.approx([-3.0, 3.0], rel=3e-3)
    assert found["temperature_rate"]["reached"] == pytest.approx([-6.0, 6.0], rel=3e-3)


def test_within_what_was_fitted_and_without_other_runs_there_is_nothing_to_tell() -> None:
    model = graybox("static_bias", "supply_voltage")
    assert beyond(model, [run(0.05, 5.0)], [run(0.05, 5.0)]) == {}
    assert beyond(model, [run(0.05, 5.0)], []) == {}
