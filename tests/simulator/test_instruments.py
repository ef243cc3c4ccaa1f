"""Thermometers, recorded inputs and the classes gyros are drawn from."""

from __future__ import annotations

import math
from typing import Any

import pytest
import torch

from zoo.catalog import build
from zoo.errors import InputError
from zoo.physics.winding import shupe_weight, wind
from zoo.simulator.gyros.device import draw
from zoo.simulator.gyros.gyro_class import SPANS
from zoo.simulator.gyros.presets import MEDIUM, PRESETS, gyro_class
from zoo.simulator.inputs import recorded_inputs
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.laboratory.profiles import legs
from zoo.simulator.noise import SILENT, Noise
from zoo.simulator.settings import PLACES
from zoo.simulator.simulate import simulate
from zoo.simulator.simulation import Simulation
from zoo.simulator.streams import stream
from zoo.simulator.thermal.heat import heat
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


# Where thermometers sit

PROFILE = legs([[20, 20, 1200], [20, 50, 1800], [50, 50, 1200]])
INSTANT = {"sensor_s": 1e-3, "sensor_offset_c": 0.0}


def recorded(thermometers: Any, chamber: Chamber | None = None, **changes: Any) -> Simulation:
    """Without noise or steps."""
    gyro = gyro_class("medium", **changes)
    return simulate(gyro, PROFILE, {}, SILENT, thermometers=thermometers, chamber=chamber or Chamber(120.0), runs=1)


def columns(done: Simulation) -> list[str]:
    return [name for name in done.runs[0].table if name.startswith("temperature")]


@pytest.mark.parametrize(
    ("thermometers", "names"),
    [
        (1, ["temperature_c"]),
        (2, ["temperature_c", "temperature_outer_c"]),
        (5, ["temperature_c", "temperature_outer_c", "temperature_inner_layer_c", "temperature_outer_layer_c", "temperature_air_c"]),
        (["housing", "spool"], ["temperature_c", "temperature_spool_c"]),
        (["air", "outer_layer", "housing"], ["temperature_c", "temperature_outer_layer_c", "temperature_outer_c"]),
    ],
)
def test_the_first_place_has_the_main_thermometer(thermometers, names) -> None:
    done = recorded(thermometers)
    assert columns(done) == names
    assert len(done.device.sensors) == len(names)


def test_each_shows_its_place_and_by_how_much_it_warms_itself() -> None:
    done = recorded(list(PLACES), **INSTANT, sensor_heating_k=0.2)
    table, time = done.runs[0].table, done.runs[0].table["time_s"]
    body = heat([done.device], time, Chamber(120.0).air(done.runs[0].program, time, stream(1)))
    places = (body.spool[0], body.housing[0], body.inner[0], body.outer[0], body.air)
    for column, place in zip(columns(done), places, strict=True):
        assert float((table[column] - place - 0.2).abs().max()) < 2e-5, "1 K/min in a millisecond"


def test_self_heating_is_part_of_the_offset() -> None:
    device = draw(gyro_class("medium", sensor_offset_c=0, sensor_heating_k=[0.1, 0.3]), 1, 5)
    assert all(0.1 <= offset <= 0.3 for _, offset in device.sensors)
    assert len({offset for _, offset in device.sensors}) == 5


def test_thermometers_are_drawn_one_by_one() -> None:
    """Asking for more does not change those that were there."""
    assert draw(MEDIUM, 1, 2).sensors == draw(MEDIUM, 1, 5).sensors[:2]
    assert torch.equal(recorded(1).runs[0].table["temperature_c"], recorded(5).runs[0].table["temperature_c"])


def test_the_one_in_the_air_sees_the_chamber() -> None:
    """At rest it is colder than the gyro by what the electronics make, and it shows the cycling that hardly gets to the spool."""
    done = recorded(["air", "spool"], Chamber(120.0, cycling_k=0.4, cycling_s=300), **INSTANT, sensor_heating_k=1e-6)
    air, spool = (done.runs[0].table[column][:120] for column in columns(done))
    assert float((spool - air).mean()) == pytest.approx(done.device["self_heating_k"], abs=0.1)
    assert float(air.std()) == pytest.approx(0.4 / 2**0.5, rel=0.1)
    assert float(spool.std()) < 0.1 * float(air.std())


def test_inputs_are_slow_rounded_and_their_own() -> None:
    first, second = (recorded_inputs(TIME, 10.0, 1, run) for run in (1, 2))
    assert 4.7 < float(first["supply_v"].min()) < float(first["supply_v"].max()) < 5.3
    assert float(first["supply_v"].std()) > 0.01
    assert torch.allclose(first["field_ut"] * 100, (first["field_ut"] * 100).round(), atol=1e-9)
    assert not torch.equal(first["supply_v"], second["supply_v"])
    assert float(torch.diff(first["supply_v"]).abs().max()) < 0.05


@pytest.mark.parametrize("name", PRESETS)
def test_the_gyro_of_the_yaml_is_that_of_the_code(name) -> None:
    assert build("gyro", name) == PRESETS[name]


def test_every_parameter_of_a_class_can_be_set() -> None:
    for key in SPANS:
        value = 0.5 * (getattr(MEDIUM, key).low + getattr(MEDIUM, key).high)
        device = draw(gyro_class("medium", **{key: value}), 1)
        if not key.startswith("sensor_"):
            assert device[key] == pytest.approx(value)
    design = {"layers": 8, "turns": 10, "pattern": "dipolar"}
    coil = draw(gyro_class("medium", **design), 1).coil
    assert {key: getattr(coil, key) for key in design} == design


def test_fixing_one_parameter_changes_no_other() -> None:
    plain, fixed = draw(MEDIUM, 5), draw(gyro_class("medium", package_s=1000), 5)
    assert {key for key in plain.values if plain[key] != fixed[key]} == {"package_s"}


def test_devices_differ_and_stay_within_their_class() -> None:
    devices = [draw(MEDIUM, seed) for seed in range(30)]
    for key in devices[0].values:
        values = [device[key] for device in devices]
        span = getattr(MEDIUM, key)
        assert span.low * (1 - 1e-12) <= min(values) <= max(values) <= span.high * (1 + 1e-12)
        assert len(set(values)) == (30 if span.low < span.high else 1)


def test_a_conductivity_that_is_given_is_taken_and_otherwise_glass_and_glue_make_it() -> None:
    assert draw(gyro_class("medium", conductivity=0.7), 1).conductivity == 0.7
    assert draw(gyro_class("medium", glass_fraction=0.25, glue_conductivity=0.2), 1).conductivity == pytest.approx(0.29, abs=0.005)


def test_windings_have_errors_of_their_own_and_are_trimmed_by_the_share() -> None:
    for seed in range(10):
        wound, ideal = (draw(gyro_class("medium", winding_error_turns=turns), seed) for turns in (0.5, 0))
        assert shupe_weight(ideal.winding) == shupe_weight(wind(ideal.coil))
        assert shupe_weight(wound.winding) != shupe_weight(ideal.winding)
        trimmed = draw(gyro_class("medium", winding_error_turns=0.5, trimmed=0.9), seed)
        assert shupe_weight(trimmed.winding) / shupe_weight(wound.winding) == pytest.approx(0.1, abs=1e-3)
        assert trimmed.winding.fibre_m < wound.winding.fibre_m


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"package_s": 0}, "gyro.package_s=0: a number from 1 to"),
        ({"package_s": [900, 600]}, "low <= high"),
        ({"package_s": "long"}, "a number or"),
        ({"package_s": math.inf}, "gyro.package_s=inf"),
        ({"packages": 3}, "package_s"),
        ({"random_walk": -1}, "gyro.random_walk=-1: a number from 0 to"),
        ({"effects": {"mohr": "big"}}, "a number or"),
        ({"conductivity": -1}, "gyro.conductivity=-1: a number from 0 to"),
        ({"layers": 0}, "gyro.layers=0"),
        ({"layers": 2.5}, "gyro.layers=2.5"),
        ({"turns": True}, "gyro.turns=True"),
        ({"pattern": "quadrupole"}, "gyro.pattern=quadrupole: did you mean quadrupolar"),
        ({"glass_fraction": 1.5}, "gyro.glass_fraction=1.5: a number from 0.001 to 1 is"),
        ({"trimmed": [0.5, 1.1]}, "gyro.trimmed=1.1: a number from 0 to 1 is"),
        ({"index": 0}, "gyro.index=0: a number from 1 to 4 is"),
    ],
)
def test_impossible_gyros_are_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        gyro_class("medium", **changes)


def test_coils_that_cannot_be_wound_are_refused() -> None:
    for changes, words in (({"diameter_m": 0.005}, "diameter_m=0.005"), ({"winding_error_turns": 1e3}, "a layer has to have some fibre")):
        with pytest.raises(InputError, match=words):
            _ = draw(gyro_class("medium", **changes), 1).winding


def test_an_unknown_class() -> None:
    with pytest.raises(InputError, match="medium"):
        gyro_class("mediun")
