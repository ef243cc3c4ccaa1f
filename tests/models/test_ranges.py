"""Ranges of what a model was fitted to, saved beside it."""

import math

import pytest
import torch
from omegaconf import OmegaConf

from zoo.catalog import RANGES_FILE, build, load, load_ranges, save_model
from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.features import Features
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.ranges import ROOM, Watched, fitted_ranges, outside, unknown_ranges


def run(temperature: list[float], block: list[int]) -> Run:
    """A run whose thermometer reads as given."""
    value = torch.tensor(temperature, dtype=torch.float64)
    time = torch.arange(len(value), dtype=torch.float64)
    table = torch.stack([time, value, torch.full_like(time, 9.66)], dim=-1)
    names = ("time_s", "temperature_c", "reference_dph")
    return Run("run", "dph", 1.0, names, table, 0 * time, torch.ones(len(time), dtype=torch.int64), torch.tensor(block))


def test_what_was_fitted_counts_and_what_was_left_out_does_not() -> None:
    model = build("model", "bp")
    runs = [run([5.0, 20.0, 60.0], [-1, 0, 0]), run([-40.0, 30.0], [0, 1])]
    found = fitted_ranges(model, runs)
    assert found["temperature_c"] == (-40.0, 60.0)
    # What is left out counts as past: 55 K in two seconds, through two lags of a minute.
    low, high = found["temperature_rate"]
    assert low == 0.0
    assert 0.0 < high < 60 * 70 / 60


def test_rates_and_lags_have_ranges_in_a_network_by_itself_and_beside_effects() -> None:
    network = build("model", "wavelet", features=["temperature", "temperature_rate", "temperature_lag600"])
    ramp = run((20 + 0.05 * torch.arange(1200)).tolist(), [0] * 1200)
    alone = fitted_ranges(network, [ramp])
    assert alone["temperature_rate"] == pytest.approx((0.0, 3.0), abs=1e-3)
    assert alone["temperature_lag600"] == pytest.approx((20.0, 20 + 60 - 0.05 * 600 * (1 - math.exp(-2))), abs=0.1)
    together = fitted_ranges(Hybrid(network, {"mohr": build("effects", "mohr")}, ["time_s", "temperature_c", "reference_dph"]), [ramp])
    assert together == alone | {"reference_dph": (9.66, 9.66)}
    by_itself = fitted_ranges(GrayBox({"mohr": build("effects", "mohr")}, ["time_s", "temperature_c", "reference_dph"]), [ramp])
    assert by_itself["temperature_rate"] == alone["temperature_rate"], "it goes by the rate as well, at whichever of its places"
    assert [*fitted_ranges(build("model", "bp", features=["temperature"]), [ramp])] == ["temperature_c"]


def test_outside_is_beyond_the_room_for_noise() -> None:
    x = torch.tensor([[0.0, -40.0], [1e9, 60.0 + 99 * ROOM], [2.0, 60.0 + 101 * ROOM], [3.0, -40.0 - 101 * ROOM]], dtype=torch.float64)
    found = outside(x, ["time_s", "temperature_c"], {"temperature_c": (-40.0, 60.0)})
    assert found[:, 1].tolist() == [False, False, True, True]
    assert not found[:, 0].any()


def test_they_are_saved_with_the_model(tmp_path) -> None:
    model = build("model", "bp")
    config = OmegaConf.to_container(load("model", "bp"))
    save_model(tmp_path, config, model)
    assert load_ranges(tmp_path) == {}
    ranges = {"temperature_c": (-40.123456789012345, 60.0)}
    save_model(tmp_path, config, model, ranges)
    assert load_ranges(tmp_path) == ranges


NO_RANGES = [
    "[1, 2]",
    '{"temperature_c": 3}',
    "{",
    '{"temperature_c": ["a", "b"]}',
    '{"temperature_c": [NaN, 1]}',
    '{"temperature_c": [2, 1]}',
]


@pytest.mark.parametrize("text", NO_RANGES)
def test_a_file_that_holds_something_else_is_told(tmp_path, text) -> None:
    (tmp_path / RANGES_FILE).write_text(text)
    with pytest.raises(InputError, match=RANGES_FILE):
        load_ranges(tmp_path)


class Slower(Features):
    """Features of a user's own, with names and columns that do not tell what they are."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return 0.1 * super().forward(x)


class Two(Model):
    """A model of two networks, each with features of its own."""

    def __init__(self, *features: Features) -> None:
        super().__init__()
        self.inputs = ["time_s", "temperature_c"]
        self.networks = torch.nn.ModuleList(features)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return sum((one(x).sum(-1) for one in self.networks), torch.zeros_like(x[:, 0]))


def test_what_several_networks_are_made_of_is_watched_and_what_is_made_in_another_way_is_not() -> None:
    model = Two(Features(["temperature_rate"]), Features(["temperature", "temperature_rate", "temperature_lag90"]), Slower(["temperature_lag600"]))
    assert Watched(model).names == ["time_s", "temperature_c", "temperature_rate", "temperature_lag90"]
    other = Two(Features(["temperature_rate"], 60.0), Features(["temperature_rate", "temperature_outer_lag90"], 90.0))
    assert Watched(other).names == ["time_s", "temperature_c", "temperature_rate"]
    x = torch.tensor([[0.0, 20.0], [60.0, 30.0], [120.0, 30.0]], dtype=torch.float64)
    assert torch.equal(Watched(other)(x)[:, 2:], Features(["temperature_rate"], 60.0)(x))
    assert Watched(model).of(["temperature_c"]) == Watched(model).names[1:]
    assert Watched(model).of(["time_s"]) == ["time_s"]
    assert unknown_ranges(model, {"temperature_rate": (0.0, 1.0)}) == ["temperature_lag90"]
