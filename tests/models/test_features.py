"""Features by name."""

import pytest
import torch

from zoo.errors import InputError
from zoo.models.features import Features
from zoo.models.scaler import Scaler
from zoo.physics.differentiator import temperature_rate
from zoo.physics.lag import lagged


def test_names_choose_columns_and_rates(raw) -> None:
    features = Features(["temperature_outer_rate", "temperature", "supply_v", "temperature_outer"], smoothing_s=30.0)
    assert features.inputs == ["time_s", "temperature_outer_c", "temperature_c", "supply_v"]
    x = raw(features.inputs)
    found = torch.jit.script(features)(x)
    torch.testing.assert_close(found[:, 0], temperature_rate(x[:, 0], x[:, 1], 30.0))
    assert torch.equal(found[:, 1:], x[:, [2, 3, 1]])


def test_a_ramp_has_its_slope_as_rate() -> None:
    time = torch.arange(0.0, 3600.0, 7.0, dtype=torch.float64)
    features = Features(["temperature_rate"])(torch.stack([time, 20 + 0.8 * time / 60], dim=-1))
    torch.testing.assert_close(features[len(time) // 2 :, 0], torch.full((len(time) - len(time) // 2,), 0.8, dtype=torch.float64))


def test_a_lag_is_that_of_physics_whatever_the_smoothing_of_rates(raw) -> None:
    features = Features(["temperature_lag600", "temperature_outer_lag7.5", "temperature_rate", "reference_dph"], smoothing_s=30.0)
    assert features.inputs == ["time_s", "temperature_c", "temperature_outer_c", "reference_dph"]
    x = raw(features.inputs)
    found = torch.jit.script(features)(x)
    for place, (column, seconds) in enumerate([(1, 600.0), (2, 7.5)]):
        assert torch.equal(found[:, place], lagged(x[:, 0], x[:, column], torch.tensor(seconds, dtype=torch.float64)))
    assert torch.equal(found[:, 2:], Features(["temperature_rate", "reference_dph"], 30.0)(x[:, [0, 1, 3]]))


def test_a_lagged_ramp_is_late_by_its_time_constant() -> None:
    time = torch.arange(0.0, 3600.0, 7.0, dtype=torch.float64)
    x = torch.stack([time, 20 + 0.8 * time / 60], dim=-1)
    expected = 20 + 0.8 / 60 * (time - 100 * -torch.expm1(-time / 100))
    torch.testing.assert_close(Features(["temperature_lag100"])(x)[:, 0], expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("names", "smoothing_s", "message"),
    [
        ([], 60.0, "at least one"),
        (["temperature", "temperature"], 60.0, "once"),
        (["supply_v_rate"], 60.0, "only temperatures"),
        (["temperature"], 0.0, "above 0"),
        (["supply_v_lag600"], 60.0, "only temperatures have a lag.*temperature_lag600"),
        (["temperature_lag"], 60.0, "temperature_lag'.*with its seconds.*temperature_NAME_lag600"),
        (["temperature_lag-5"], 60.0, "above 0"),
        (["temperature_outer_lag0"], 60.0, "above 0"),
        (["temperature_lag600_rate"], 60.0, "a lag has no rate"),
    ],
)
def test_impossible_features_are_named(names, smoothing_s, message) -> None:
    with pytest.raises(InputError, match=message):
        Features(names, smoothing_s)


def test_the_scaler_standardises_and_restores() -> None:
    features = torch.randn(200, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * torch.tensor([5.0, 0.01]) + 30
    features = torch.cat([features, torch.full((200, 1), 7.0)], dim=-1)
    error = 1e-6 * features[:, 0] - 3
    scaler = Scaler(3)
    scaler.fit(features, error)
    standardised = scaler(features)
    torch.testing.assert_close(standardised[:, :2].mean(0), torch.zeros(2, dtype=torch.float64), atol=1e-9, rtol=0)
    torch.testing.assert_close(standardised[:, :2].std(0, correction=0), torch.ones(2, dtype=torch.float64))
    assert float(standardised[:, 2].abs().max()) == 0
    torch.testing.assert_close(scaler.restore((error - error.mean()) / error.std(correction=0)), error, rtol=1e-12, atol=0)
