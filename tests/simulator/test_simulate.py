"""Whole simulations: what the truth says against what the tables hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import torch

from zoo.catalog import build, names
from zoo.effects.base import Effect, History, Parameter
from zoo.errors import InputError
from zoo.simulator.gyros.presets import MEDIUM, NAVIGATION, TACTICAL, gyro_class
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.laboratory.profiles import legs
from zoo.simulator.noise import LOSS_EXPONENT, SILENT, Noise
from zoo.simulator.shares import LEAST_VISIBLE
from zoo.simulator.simulate import fleet, simulate
from zoo.simulator.simulation import Simulation

CATALOGUE = {name: build("effects", name) for name in names("effects")}
BASE = {name: CATALOGUE[name] for name in ("static_bias", "shupe", "mohr")}
TURNED = {name for name, effect in CATALOGUE.items() if effect.needs_varied_reference}
SHORT = legs([[20, 20, 1800], [20, 50, 1800], [50, 50, 1800], [50, 0, 3000], [0, 0, 1800], [0, 15, 900], [15, 15, 1800]])


TURNING = [[-10, 4200], [10, 4200], [2, 4200]]


def turning() -> Any:
    """The same on a rate table [°/s, s]."""
    return legs([list(leg) for leg in SHORT.of(1).legs], rates=TURNING)


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
    """Those of the true input only where that changes."""
    still, turned = (
        {name for one in fleet(MEDIUM, profile, BASE, hidden=1, catalogue=CATALOGUE, runs=1, sample_s=300.0, devices=90) for name in one.hidden}
        for profile in (SHORT, turning())
    )
    assert still == set(CATALOGUE) - set(BASE) - TURNED
    assert turned == set(CATALOGUE) - set(BASE)


def rms_left(done: Simulation, name: str) -> float:
    """What a fit of the effects that are present leaves of a hidden one: a cubic in the coil's temperature with a constant, and their columns."""
    truth = {column: torch.cat([one.truth[column] for one in done.runs]).numpy() for column in done.runs[0].truth}
    celsius = truth["temperature_coil_c"] / 50
    columns = [celsius**k for k in range(4)] + [truth[f"{one}_dph"] for one in done.present if one != "static_bias"]
    scaled = np.stack([column / np.abs(column).max() for column in columns], axis=1)
    part = truth[f"{name}_dph"]
    left = part - scaled @ np.linalg.lstsq(scaled, part, rcond=None)[0]
    return float(np.sqrt(np.mean(left**2)))


@pytest.mark.parametrize("present", [("static_bias",), ("static_bias", "shupe", "mohr")], ids=len)
@pytest.mark.parametrize("gyro", [MEDIUM, TACTICAL, NAVIGATION])
def test_a_hidden_effect_has_the_rms_asked_for_beyond_what_the_others_take_up(gyro: Any, present: tuple[str, ...]) -> None:
    """Unless that were more than fifty times as much in all."""
    for name in sorted(set(CATALOGUE) - set(present)):
        done = run(present, turning(), gyro, hidden=name, amplitude=0.07, runs=2, sample_s=30.0)
        part = torch.cat([one.truth[f"{name}_dph"] for one in done.runs])
        total = float((part - part.mean()).square().mean().sqrt())
        assert done.shares[name].rms == pytest.approx(total)
        assert total <= 0.07 / LEAST_VISIBLE * (1 + 1e-9)
        if total < 0.07 / LEAST_VISIBLE * (1 - 1e-9):
            assert rms_left(done, name) == pytest.approx(0.07, rel=1e-3), name
        else:
            assert rms_left(done, name) < 0.07, name


def test_most_hidden_effects_can_be_made_visible() -> None:
    done = [run(profile=turning(), hidden=name, amplitude=0.07, runs=2, sample_s=30.0) for name in sorted(set(CATALOGUE) - set(BASE))]
    limited = {one.hidden[0] for one in done if rms_left(one, one.hidden[0]) < 0.0699}
    assert limited == {"thermal_gradient"}, "Mohr's twin, but for the time that heat takes from place to place"


def test_a_hidden_effect_stands_out_of_the_white_noise_by_default() -> None:
    """One to four times a mean over 100 s."""
    for done in fleet(MEDIUM, SHORT, BASE, hidden="hysteresis", catalogue=CATALOGUE, runs=1, devices=20):
        assert 0.999 < rms_left(done, "hysteresis") / (6 * done.device["random_walk"]) < 4.001


@pytest.mark.parametrize("name", sorted(CATALOGUE))
def test_every_drawn_parameter_lies_within_its_declared_bounds(name: str) -> None:
    for seed in range(15):
        share = run((name,), runs=1, seed=seed, sample_s=60.0).shares[name]
        declared = {one.name: one for one in (*share.effect.shape, *share.effect.amplitudes)}
        told = declared.keys() - {"diffusion_time"} if name == "shupe" else declared.keys()  # which the winding has, and nobody draws
        assert share.parameters().keys() == told
        for one in (declared[key] for key in told):
            assert one.low <= share.parameters()[one.name][0] <= one.high


def test_noise_and_gyro_do_not_depend_on_the_effects() -> None:
    # Counting the angle in steps makes the last digits depend on the sum.
    plain, more = run(runs=1, seed=9), run(runs=1, seed=9, hidden="aging")
    assert torch.allclose(plain.runs[0].noise, more.runs[0].noise, atol=0.005)
    assert plain.device == more.device
    assert torch.equal(plain.runs[0].truth["mohr_dph"], more.runs[0].truth["mohr_dph"])


# What is asked for


def test_the_reference_is_the_earths_rate_the_tables_and_a_constant() -> None:
    done = run(profile=turning(), latitude_deg=30.0, axis="up", reference_dph=2.0, runs=1, sample_s=60.0)
    time, reference = done.runs[0].table["time_s"], done.runs[0].table["reference_dph"]
    for start, (rate, seconds) in zip((0, 4200, 8400), TURNING, strict=True):
        piece = reference[(time >= start) & (time < start + seconds)]
        assert piece.tolist() == pytest.approx([15.041 / 2 + 2.0 + 3600 * rate] * len(piece), abs=1e-3)
    # check.csv goes backwards.
    assert float(done.check.table["reference_dph"][-2]) == pytest.approx(15.041 / 2 + 2.0 - 3600 * 10, abs=1e-3)


def test_a_rate_is_no_error() -> None:
    still, turned = (run(profile=profile, noise=SILENT, runs=1, latitude_deg=50.0, axis="north") for profile in (SHORT, turning()))
    error = [one.runs[0].table["rate_dph"] - one.runs[0].table["reference_dph"] for one in (still, turned)]
    assert float((error[0] - error[1]).abs().max()) < 1e-10


def test_switched_on_at_the_first_row_it_is_as_cold_as_the_air() -> None:
    cold, warm = (run(runs=1, cold_start=cold, noise=SILENT) for cold in (True, False))
    coils = [one.runs[0].truth["temperature_coil_c"] for one in (cold, warm)]
    assert float(coils[0][0]) == pytest.approx(20.0, abs=1e-6)
    assert float(coils[1][0]) == pytest.approx(20.0 + warm.device["self_heating_k"], abs=1e-6)
    assert bool((coils[0] < coils[1]).all())
    assert float(cold.runs[0].truth["mohr_dph"][:60].abs().max()) > 100 * float(warm.runs[0].truth["mohr_dph"][:60].abs().max())


def test_rows_are_noisier_in_the_cold() -> None:
    """By 10^(k·L/20), L the light that is lost at the coil's temperature: all of L₋₄₀ at −40 °C."""
    gyro = gyro_class("medium", package_s=600, self_heating_k=0)
    noise = Noise(random_walk=0.01, flicker=0, rate_random_walk=0, cold_loss_db=6.0, angle_step_arcsec=0)
    profile = legs([[20, 20, 30000], [20, -40, 600], [-40, -40, 60000]])
    one = run(profile=profile, gyro=gyro, noise=noise, runs=1, sample_s=5.0).runs[0]
    warm, cold = one.noise[one.table["time_s"] < 30000], one.noise[one.table["time_s"] > 50000]
    assert float(warm.std()) == pytest.approx(0.01 * (3600 / 5) ** 0.5, rel=0.04)
    assert float(cold.std() / warm.std()) == pytest.approx(10 ** (LOSS_EXPONENT * 6.0 / 20), rel=0.05)


def test_shupes_effect_is_that_of_the_winding_unless_the_class_says_otherwise() -> None:
    own, other = run(runs=1), run(runs=1, gyro=gyro_class("medium", effects={"shupe": 0.5}))
    assert abs(other.shares["shupe"].parameters()["weight"][0]) == 0.5
    shapes = [one.runs[0].truth["shupe_dph"] / one.shares["shupe"].parameters()["weight"][0] for one in (own, other)]
    assert torch.allclose(shapes[0], shapes[1], atol=1e-12)


def test_a_fan_is_an_error_with_a_name_of_its_own() -> None:
    done = run(runs=1, noise=SILENT, chamber=Chamber(120.0, fan="in_motion", fan_dph=0.3))
    fan, asked = done.runs[0].truth["fan_dph"], done.runs[0].program.asked(done.runs[0].table["time_s"])
    moving = torch.diff(asked, append=asked[-1:]) != 0
    assert torch.equal(fan, 0.3 * moving.double())
    assert float(done.runs[0].noise.abs().max()) < 1e-12


def test_truth_differs_over_seeds() -> None:
    first, second = run(runs=1, seed=1), run(runs=1, seed=2)
    assert first.shares["mohr"].parameters() != second.shares["mohr"].parameters()
    assert not torch.equal(first.runs[0].noise, second.runs[0].noise)


def test_given_parameters_are_taken_as_they_are() -> None:
    done = run(hidden="polarization", parameters={"polarization": {"period": 13.0}, "mohr": {"coefficient": -0.2}}, runs=1, amplitude=0.05)
    assert done.shares["polarization"].parameters()["period"] == (13.0, "K")
    assert rms_left(done, "polarization") == pytest.approx(0.05, rel=1e-3)
    assert done.shares["mohr"].parameters()["coefficient"] == (-0.2, "°/h/(K/min)")


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
        ({"amplitude": -0.1}, "amplitude"),
        ({"thermometers": 0}, "thermometers=0"),
        ({"thermometers": 6}, "spool, housing, inner_layer, outer_layer, air"),
        ({"thermometers": []}, "thermometers="),
        ({"thermometers": ["roof"]}, "roof"),
        ({"thermometers": ["air", "air"]}, "thermometers="),
        ({"thermometers": True}, "thermometers=True"),
        ({"heat": "3d"}, "heat=3d.*radial_axial"),
        ({"latitude_deg": 100}, "latitude_deg=100"),
        ({"latitude_deg": 40, "axis": "sideways"}, "axis=sideways"),
        ({"reference_dph": "fast"}, "reference_dph=fast"),
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
