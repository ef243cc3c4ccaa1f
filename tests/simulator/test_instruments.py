"""Thermometers, recorded inputs and the classes gyros are drawn from."""

from __future__ import annotations

import math

import pytest
import torch

from zoo.catalog import build
from zoo.errors import InputError
from zoo.simulator.device import draw
from zoo.simulator.gyro_class import CLASSES, MEDIUM, SPANS, gyro_class
from zoo.simulator.inputs import recorded_inputs
from zoo.simulator.noise import SILENT, Noise
from zoo.simulator.streams import stream
from zoo.simulator.thermometers import reading

TIME = torch.arange(0, 20000, 10.0, dtype=torch.float64)
RISING = 20 + TIME / 600


def test_readings_are_whole_multiples_of_the_resolution() -> None:
    shown = reading(TIME, RISING, (30.0, 0.11), Noise(), stream(1, "t"))
    assert torch.equal(shown / 0.0625, (shown / 0.0625).round())


def test_a_reading_is_late_and_offset() -> None:
    shown = reading(TIME, RISING, (60.0, 0.25), SILENT, stream(1, "t"))
    assert float(shown[-1] - RISING[-1]) == pytest.approx(0.25 - 60 / 600)


def test_the_noise_of_a_reading() -> None:
    shown = reading(TIME, torch.full_like(TIME, 20.0), (60.0, 0.0), Noise(thermometer_c=0.1, resolution_c=0.0), stream(1, "t"))
    assert float(shown.std()) == pytest.approx(0.1, rel=0.06)


def test_inputs_are_slow_rounded_and_their_own() -> None:
    first, second = (recorded_inputs(TIME, 10.0, 1, run) for run in (1, 2))
    assert 4.7 < float(first["supply_v"].min()) < float(first["supply_v"].max()) < 5.3
    assert float(first["supply_v"].std()) > 0.01
    assert torch.allclose(first["field_ut"] * 100, (first["field_ut"] * 100).round(), atol=1e-9)
    assert not torch.equal(first["supply_v"], second["supply_v"])
    assert float(torch.diff(first["supply_v"]).abs().max()) < 0.05


def test_the_medium_of_the_yaml_is_the_medium_of_the_code() -> None:
    for name, preset in CLASSES.items():
        assert build("gyro", name) == preset


def test_every_parameter_of_a_class_can_be_set() -> None:
    for key in SPANS:
        value = 0.5 * (getattr(MEDIUM, key).low + getattr(MEDIUM, key).high)
        device = draw(gyro_class("medium", **{key: value}), 1)
        if not key.startswith("sensor_"):
            assert device[key] == pytest.approx(value)


def test_fixing_one_parameter_changes_no_other() -> None:
    plain, fixed = draw(MEDIUM, 5), draw(gyro_class("medium", package_s=1000), 5)
    assert {key for key in plain.values if plain[key] != fixed[key]} == {"package_s"}


def test_devices_differ_and_stay_within_their_class() -> None:
    devices = [draw(MEDIUM, seed) for seed in range(30)]
    for key in devices[0].values:
        values = [device[key] for device in devices]
        span = getattr(MEDIUM, key)
        assert len(set(values)) == 30
        assert span.low <= min(values) < max(values) <= span.high


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"package_s": 0}, "above 0"),
        ({"package_s": [900, 600]}, "low <= high"),
        ({"package_s": "long"}, "a number or"),
        ({"package_s": math.inf}, "finite"),
        ({"packages": 3}, "package_s"),
        ({"random_walk": -1}, "too small"),
        ({"effects": {"mohr": "big"}}, "a number or"),
    ],
)
def test_impossible_gyros_are_refused(changes: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        gyro_class("medium", **changes)  # type: ignore[arg-type]


def test_unknown_class_and_number_of_thermometers() -> None:
    with pytest.raises(InputError, match="medium"):
        gyro_class("mediun")
    with pytest.raises(InputError, match="thermometers=3"):
        draw(MEDIUM, 1, thermometers=3)
