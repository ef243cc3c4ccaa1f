"""Whole simulations: what the truth says against what the tables hold."""

from __future__ import annotations

from typing import Any

import pytest
import torch

from zoo.catalog import build, names
from zoo.effects.base import Effect, History, Parameter
from zoo.errors import InputError
from zoo.simulator.gyro_class import MEDIUM, TACTICAL
from zoo.simulator.noise import SILENT
from zoo.simulator.profiles import legs
from zoo.simulator.simulate import Simulation, simulate

CATALOGUE = {name: build("effects", name) for name in names("effects")}
SHORT = legs([[20, 20, 1800], [20, 50, 1800], [50, 50, 1800], [50, 0, 3000], [0, 0, 1800], [0, 15, 900], [15, 15, 1800]])


def run(effects: tuple[str, ...] = ("static_bias", "shupe", "mohr"), profile: Any = SHORT, gyro: Any = MEDIUM, **rest: Any) -> Simulation:
    return simulate(gyro, profile, {name: CATALOGUE[name] for name in effects}, catalogue=CATALOGUE, **rest)


def test_the_effects_sum_to_the_truth_and_the_rest_is_noise() -> None:
    done = run(("static_bias", "shupe", "mohr", "hysteresis"), runs=2, reference_dph=9.67)
    for one in [*done.runs, done.check]:
        parts = [value for name, value in one.truth.items() if name.endswith("_dph") and name != "sum_dph"]
        assert len(parts) == 4
        assert torch.allclose(torch.stack(parts).sum(0), one.truth["sum_dph"], atol=1e-12)
        white = 60 * done.device["random_walk"] / 10**0.5
        steps = torch.diff(one.noise).std() / 2**0.5
        assert float(steps) == pytest.approx(white, rel=0.1)


def test_without_noise_the_error_is_the_sum_of_the_effects() -> None:
    one = run(noise=SILENT).runs[0]
    assert float(one.noise.abs().max()) < 1e-12


def test_at_rest_the_dynamic_effects_are_nothing() -> None:
    done = run(("shupe", "mohr", "rate_temperature_coupling", "sensor_lag"), legs([[20, 20, 7200]]), noise=SILENT, runs=1)
    assert float(done.runs[0].table["rate_dph"].abs().max()) < 1e-10


def test_hidden_effects_are_hidden_from_the_measurement_file() -> None:
    done = run(hidden=2, runs=1, seed=4)
    assert len(done.hidden) == 2
    assert not set(done.hidden) & {"static_bias", "shupe", "mohr"}
    assert done.present == ("static_bias", "shupe", "mohr")
    assert list(done.runs[0].table) == ["time_s", "temperature_c", "temperature_outer_c", "rate_dph", "reference_dph", "supply_v", "field_ut"]


def test_all_effects_get_hidden_sooner_or_later() -> None:
    seen = {name for seed in range(60) for name in run(hidden=1, runs=1, seed=seed, sample_s=300.0).hidden}
    assert seen == set(CATALOGUE) - {"static_bias", "shupe", "mohr"}


@pytest.mark.parametrize("name", sorted(set(CATALOGUE) - {"static_bias"}))
@pytest.mark.parametrize("gyro", [MEDIUM, TACTICAL])
def test_a_hidden_effect_has_the_rms_asked_for(name: str, gyro: Any) -> None:
    done = run(("static_bias",), gyro=gyro, hidden=name, amplitude=0.07, runs=2)
    part = torch.cat([one.truth[f"{name}_dph"] for one in done.runs])
    assert float((part - part.mean()).square().mean().sqrt()) == pytest.approx(0.07)
    assert done.shares[name].rms == pytest.approx(0.07)


def test_a_hidden_effect_stands_out_of_the_white_noise_by_default() -> None:
    for seed in range(20):
        done = run(hidden="hysteresis", runs=1, seed=seed)
        assert 0.999 < done.shares["hysteresis"].rms / (6 * done.device["random_walk"]) < 4.001


@pytest.mark.parametrize("name", sorted(CATALOGUE))
def test_every_drawn_parameter_lies_within_its_declared_bounds(name: str) -> None:
    for seed in range(15):
        share = run((name,), runs=1, seed=seed, sample_s=60.0).shares[name]
        for one in (*share.effect.shape, *share.effect.amplitudes):
            if one.name in share.parameters():
                assert one.low <= share.parameters()[one.name][0] <= one.high


def test_noise_and_gyro_do_not_depend_on_the_effects() -> None:
    # Counting the angle in steps makes the last digits depend on the sum.
    plain, more = run(runs=1, seed=9), run(runs=1, seed=9, hidden="aging")
    assert torch.allclose(plain.runs[0].noise, more.runs[0].noise, atol=0.005)
    assert plain.device == more.device
    assert torch.equal(plain.runs[0].truth["mohr_dph"], more.runs[0].truth["mohr_dph"])


def test_truth_differs_over_seeds() -> None:
    first, second = run(runs=1, seed=1), run(runs=1, seed=2)
    assert first.shares["mohr"].parameters() != second.shares["mohr"].parameters()
    assert not torch.equal(first.runs[0].noise, second.runs[0].noise)


def test_given_parameters_are_taken_as_they_are() -> None:
    done = run(hidden="polarization", parameters={"polarization": {"period": 13.0}, "mohr": {"coefficient": -0.2}}, runs=1, amplitude=0.05)
    assert done.shares["polarization"].parameters()["period"] == (13.0, "K")
    assert done.shares["polarization"].rms == pytest.approx(0.05)
    assert done.shares["mohr"].parameters()["coefficient"] == (-0.2, "°/h/(K/min)")


def test_one_thermometer() -> None:
    assert "temperature_outer_c" not in run(runs=1, thermometers=1).runs[0].table


def test_effects_are_left_as_they_were() -> None:
    before = {name: effect.amplitude.clone() for name, effect in CATALOGUE.items()}
    run(tuple(CATALOGUE), runs=1)
    assert all(torch.equal(before[name], effect.amplitude) for name, effect in CATALOGUE.items())


class Tide(Effect):
    """An effect from outside the repository, for which no class has numbers."""

    name = "tide"
    shape = (Parameter("period", 12.0, "h", 6.0, 24.0),)
    amplitudes = (Parameter("height", 0.0, "unit", -1.0, 1.0),)

    def columns(self, history: History, shape: torch.Tensor) -> torch.Tensor:
        return torch.sin(2 * torch.pi * history.time / 3600 / shape[..., 0:1]).unsqueeze(-1)


def test_an_effect_that_no_class_knows_is_scaled_to_be_seen() -> None:
    done = simulate(MEDIUM, SHORT, {"tide": Tide()}, runs=2)
    assert 0.999 < done.shares["tide"].rms / (6 * done.device["random_walk"]) < 4.001


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"runs": 0}, "runs=0"),
        ({"runs": 2.5}, "runs=2.5"),
        ({"seed": -1}, "seed=-1"),
        ({"sample_s": 0}, "sample_s=0"),
        ({"sample_s": -10.0}, "sample_s=-10"),
        ({"sample_s": 1e6}, "longer than a run"),
        ({"sample_s": 1e-5}, "rows of a run"),
        ({"sample_s": "fast"}, "sample_s=fast"),
        ({"chamber_s": -1}, "chamber_s"),
        ({"amplitude": -0.1}, "amplitude"),
        ({"thermometers": 0}, "thermometers=0"),
        ({"hidden": -1}, "hidden=-1"),
        ({"hidden": 1.5}, "hidden=1.5"),
        ({"hidden": True}, "hidden=True"),
        ({"cold_start": "maybe"}, "cold_start"),
        ({"hidden": 99}, "hidden=99"),
        ({"hidden": "hysterisis"}, "no such effect"),
        ({"hidden": "mohr"}, "already"),
        ({"hidden": ["aging", "aging"]}, "twice"),
        ({"parameters": {"aging": {"drift": 1}}}, "does not have"),
        ({"parameters": {"mohr": {"coeficient": 1}}}, "coefficient"),
        ({"parameters": {"mohr": {"coefficient": "big"}}}, "parameters.mohr.coefficient"),
        ({"parameters": 3}, "parameters=3"),
        ({"parameters": {"mohr": 1}}, "parameters.mohr"),
    ],
)
def test_absurd_settings_are_refused(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        run(**settings)


def test_a_hidden_effect_that_cannot_show_is_refused() -> None:
    with pytest.raises(InputError, match="no trace"):
        run(("static_bias",), legs([[20, 20, 3600]]), hidden="mohr", noise=SILENT)
