"""The right verdict on gyros whose secret is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Generator

from zoo import side_by_side
from zoo.catalog import build, names
from zoo.diagnosis.diagnose import diagnose
from zoo.simulator.in_process import as_run
from zoo.simulator.noise import SILENT

BASE = ("static_bias", "shupe", "mohr")
ABSORBED = {
    "sensor_lag": "to first order Mohr's column; the coil's lag takes up the rest",
    "thermal_gradient": "Mohr's column but for the time that heat takes",
    "fixture_rotation": "the same",
}
"""Effects that a model of the three in BASE makes up for: what is left of them is less than noise."""
NOISES = {"hysteresis": 12.0}
"""Size over the white noise of a block where 3.5 is too little: most of a hysteresis is a function of temperature, and the static bias takes that."""
FAINT = 0.3
"""Size over the white noise of those that are absorbed: made fifty times larger to be seen, they are as large as the base's effects even so."""
HIDDEN = [name for name in names("effects") if name not in BASE and name not in ABSORBED and not build("effects", name).needs_varied_reference]


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_nothing_hidden_is_complete(diagnosis, white, seed) -> None:
    record = diagnosis("", seed).record
    assert (record["verdict"], record["missing"]) == ("complete", [])
    assert record["rms"] == pytest.approx(record["noise_floor"], rel=0.1)
    assert record["noise_floor"] == pytest.approx(white, rel=0.15), "and the floor is the noise that was put in"


@pytest.mark.parametrize("name", HIDDEN)
def test_a_hidden_effect_is_named(diagnosis, simulation, white, name) -> None:
    given = (name, 1, NOISES.get(name, 3.5))
    record = diagnosis(*given).record
    assert simulation(*given).hidden == (name,)
    assert record["verdict"] == "missing"
    best = record["candidates"][0]
    assert name in {best["effect"], *best["indistinguishable_from"]}
    assert record["missing"] == [best["effect"]]
    assert sum(one["probability"] for one in record["candidates"] if one["effect"] in {best["effect"], *best["indistinguishable_from"]}) > 0.9
    assert best["delta_bic"] < -20
    assert record["rms_final"] == pytest.approx(white, rel=0.15)
    assert record["rms"] > 1.15 * record["rms_final"]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_bias_that_goes_with_a_stress_that_relaxes_is_viscoelastic(simulation, catalogue, white, seed) -> None:
    """Not with its rate, as the simulator's does; step by step at the true coil's temperature, τ of 1.5 h at 20 °C, a decade less every 25 K."""
    runs, stresses = [], []
    for recorded in simulation("", seed).runs:
        run, coil = as_run(recorded), recorded.truth["temperature_coil_c"].numpy()
        speed = 10 ** (4 * (coil - 20) / 100) / 5400
        stress = np.zeros(len(run.time))
        for i, (step_s, warmer) in enumerate(zip(np.diff(run.time.numpy()), np.diff(coil), strict=True)):
            left = np.exp(-step_s * (speed[i] + speed[i + 1]) / 2)
            stress[i + 1] = left * stress[i] + warmer * np.sqrt(left)
        runs.append(run)
        stresses.append(stress)
    scale = 3.5 * white / np.sqrt(np.mean(np.concatenate(stresses) ** 2))
    hidden = [replace(run, error=run.error + torch.from_numpy(scale * stress)) for run, stress in zip(runs, stresses, strict=True)]
    record = diagnose(hidden, list(BASE), catalogue).record
    assert (record["verdict"], record["missing"]) == ("missing", ["viscoelastic"])
    assert record["candidates"][0]["parameters"]["of_stress"]["value"] == 1
    assert record["rms_final"] == pytest.approx(white, rel=0.15)


@pytest.mark.parametrize(("name", "seed"), [("aging", 1), ("aging", 2), ("moisture", 1), ("moisture", 2), ("warm_up", 1), ("warm_up", 2)])
def test_what_does_not_start_anew_with_every_run_is_named(simulation, catalogue, white, name, seed) -> None:
    """Ageing and drying that go on, across a pause that no file tells of; a warm-up in the first run, after which the gyro is left on."""
    runs, clock, heat = [], [], []
    for recorded in simulation("", seed).runs:
        run = as_run(recorded)
        runs.append(run)
        clock.append(run.time.numpy() / 3600 + (clock[-1][-1] + 1.0 if clock else 0.0))
        heat.append(recorded.truth["temperature_coil_c"].numpy())
    hours, celsius = np.concatenate(clock), np.concatenate(heat)
    pace = np.exp(45e3 / 8.314 * (1 / 293.15 - 1 / (celsius + 273.15)))
    dried = np.concatenate([[0.0], np.cumsum((pace[1:] + pace[:-1]) / 2 * np.diff(hours))]) / 12.0
    signal = {"aging": np.log1p(hours / 3.0), "moisture": pace * np.exp(-dried), "warm_up": np.exp(-hours / 0.4)}[name]
    shares = np.split(3.5 * white * signal / signal.std(), [len(clock[0])])
    hidden = [replace(run, error=run.error + torch.from_numpy(share)) for run, share in zip(runs, shares, strict=True)]
    record = diagnose(hidden, list(BASE), catalogue).record
    assert (record["verdict"], record["missing"]) == ("missing", [name])
    found = record["candidates"][0]["parameters"]
    assert found["run" if name == "warm_up" else "goes_on"] == {"value": 1.0, "stderr": None, "unit": "1"}


@pytest.mark.parametrize("name", ABSORBED)
def test_an_effect_that_the_model_absorbs_is_not_invented(diagnosis, name) -> None:
    record = diagnosis(name, 1, *([] if name == "sensor_lag" else [FAINT])).record
    assert record["verdict"] in {"complete", "missing"}
    assert set(record["missing"]) <= {name}
    assert record["rms_final"] < 1.1 * record["noise_floor"]


@pytest.mark.parametrize("seed", [1])
def test_a_square_of_the_rate_is_unknown(simulation, runs, white, catalogue, base, seed) -> None:
    """No effect of the catalogue is even in the rate."""
    found = []
    for run, recorded in zip(runs("", seed), simulation("", seed).runs, strict=True):
        coil = recorded.truth["temperature_coil_c"]
        square = torch.gradient(coil, spacing=(recorded.truth["time_s"] / 60,))[0].square()
        found.append(replace(run, error=run.error + 4 * white * (square - square.mean()) / square.std()))
    record = diagnose(found, base, catalogue).record
    assert record["verdict"] == "unknown"
    assert record["rms_final"] > 1.3 * record["noise_floor"]
    assert any("rate" in item["depends_on"] for item in record["unexplained"]), "and it says what the rest depends on"
    assert all(entry["probability"] <= 0.5 for entry in record["candidates"]), "no candidate is believed where the rest is unexplained"


def test_a_random_telegraph_is_unknown(runs, white, catalogue, base) -> None:
    chance, found = Generator().manual_seed(7), []
    for run in runs():
        flips = torch.rand(len(run.time), generator=chance, dtype=torch.float64) < 20.0 / 1500.0
        telegraph = 1.0 - 2.0 * (flips.cumsum(0) % 2)
        found.append(replace(run, error=run.error + 4 * white * telegraph))
    record = diagnose(found, base, catalogue).record
    assert record["verdict"] == "unknown"
    assert record["rms_final"] > 1.3 * record["noise_floor"]


@pytest.mark.parametrize(("period_s", "noises"), [(1500.0, 1.0), (3000.0, 1.5)])
def test_a_line_in_time_is_named_and_without_a_name_unknown(runs, white, catalogue, base, period_s, noises) -> None:
    """A chamber that cycles: one frequency, in no noise, though much flicker would hold its variance."""
    found = [replace(run, error=run.error + noises * white * 2**0.5 * torch.sin(2 * torch.pi * run.time / period_s)) for run in runs()]
    few = {name: catalogue[name] for name in (*base, "chamber_cycling", "polarization", "bias_step", "warm_up", "hysteresis")}
    record = diagnose(found, base, few).record
    assert (record["verdict"], record["missing"]) == ("missing", ["chamber_cycling"])
    assert record["parameters"]["chamber_cycling"]["period"]["value"] == pytest.approx(period_s, rel=0.01)
    nameless = diagnose(found, base, {name: effect for name, effect in catalogue.items() if name != "chamber_cycling"}).record
    assert nameless["verdict"] == "unknown"
    recurs = [float(item["depends_on"].split()[-2]) for item in nameless["unexplained"] if "recurs every" in item["depends_on"]]
    assert recurs == [pytest.approx(period_s, rel=0.06)], "a bin of the periodogram wide"


@pytest.mark.parametrize("seed", [1, 3, 4])
def test_two_hidden_effects_are_both_named(simulation, catalogue, base, white, seed) -> None:
    """Each alone looks like flicker while the other is there, and the coil is bent to make up for both."""
    first, second = (simulation(name, seed) for name in ("polarization", "aging"))
    runs = []
    for one, other in zip(first.runs, second.runs, strict=True):
        run = as_run(one)
        runs.append(replace(run, error=run.error + other.truth["aging_dph"]))
    record = diagnose(runs, base, catalogue).record
    assert record["verdict"] == "missing"
    assert set(record["missing"]) == {"polarization", "aging"}
    assert record["rms_final"] == pytest.approx(white, rel=0.15)


@pytest.mark.parametrize("onset_h", [1.9031, 3.3337])
def test_a_large_step_is_found_to_the_second(runs, white, catalogue, base, onset_h) -> None:
    """Thirty times the noise, in every run: a hundredth of a run off would leave more than the noise."""
    found = [replace(run, error=run.error + 30 * white * (run.time - run.time[0] > onset_h * 3600)) for run in runs()]
    record = diagnose(found, base, catalogue).record
    assert (record["verdict"], record["missing"]) == ("missing", ["bias_step"])
    assert record["parameters"]["bias_step"]["onset"]["value"] == pytest.approx(onset_h, abs=20 / 3600)
    assert record["rms_final"] == pytest.approx(white, rel=0.15)


def test_fast_fringes_do_not_pass_for_noise(simulation, runs, white, catalogue, base) -> None:
    """Three block means a fringe in the ramps: differences of the error are many times the white noise, the residual's are not."""
    coils = [one.truth["temperature_coil_c"] for one in simulation().runs]
    found = [replace(run, error=run.error + 5 * white * torch.cos(2 * torch.pi * coil / 5)) for run, coil in zip(runs(), coils, strict=True)]
    record = diagnose(found, base, catalogue).record
    assert (record["verdict"], record["missing"]) == ("missing", ["polarization"])
    assert record["noise"]["white"] == pytest.approx(white, rel=0.15)


@pytest.mark.parametrize("heat", ["lumped", "radial"])
def test_a_drift_without_noise_is_complete(simulation, catalogue, base, heat) -> None:
    """What the formulas leave, of a coil of one temperature or of one of many layers, is far below what any gyro's noise would be."""
    record = diagnose([as_run(one) for one in simulation(noise=SILENT, heat=heat).runs], base, catalogue).record
    assert (record["verdict"], record["missing"]) == ("complete", [])
    assert record["rms"] < 3e-3 * record["rms_uncompensated"]


def test_one_thermometer_is_enough_for_a_gyro_without_secrets(runs, catalogue, base) -> None:
    record = diagnose(runs(thermometers=1), base, catalogue).record
    assert (record["verdict"], record["missing"]) == ("complete", [])


@pytest.mark.parametrize(("hidden", "factor"), [("", 3.0), ("hysteresis", 2.0), ("bias_step", 3.0)])
def test_one_run_may_be_noisier_than_the_others(simulation, catalogue, base, white, hidden, factor) -> None:
    recorded, chance = [as_run(one) for one in simulation(hidden, runs=3).runs], Generator().manual_seed(5)
    fine = white * (100 / 20) ** 0.5
    more = (factor**2 - 1) ** 0.5 * fine * torch.randn(len(recorded[1].error), generator=chance, dtype=torch.float64)
    found = diagnose([recorded[0], replace(recorded[1], error=recorded[1].error + more), recorded[2]], base, catalogue)
    named = [hidden] if hidden else []
    assert (found.verdict, found.record["missing"]) == ("missing" if hidden else "complete", named)
    assert found.record["noise_floor"] == pytest.approx(white * ((2 + factor**2) / 3) ** 0.5, rel=0.15)
    floors = found.record["noise_floor_by_run"]
    assert floors["run_2"] / floors["run_1"] == pytest.approx(factor, rel=0.15)
    ratios = [one["excess"] for one in found.record["where"]]
    assert ratios == sorted(ratios, reverse=True), "worst first, each by its own noise"
    assert any("run_2 has" in note and "times the noise of" in note for note in found.record["notes"])


def test_the_unit_of_the_output_does_not_matter(diagnosis, runs, catalogue, base) -> None:
    """°/h into rad/s: a factor of 4.848e-6 on every number with a unit, and nothing else."""
    factor = 4.84813681109536e-06
    scaled = [replace(run, unit="rad_per_s", error=factor * run.error) for run in runs("aging")]
    first, second = diagnosis("aging").record, diagnose(scaled, base, catalogue).record
    assert (second["unit"], second["verdict"], second["missing"]) == ("rad_per_s", first["verdict"], first["missing"])
    for key in ("rms", "rms_final", "noise_floor", "rms_uncompensated"):
        assert second[key] == pytest.approx(factor * first[key], rel=1e-3)
    assert second["candidates"][0]["delta_bic"] == pytest.approx(first["candidates"][0]["delta_bic"], abs=0.5)


def test_a_constant_or_the_order_of_the_runs_does_not_matter(diagnosis, runs, catalogue, base) -> None:
    moved = [replace(run, error=run.error + 9.66) for run in runs("warm_up")[::-1]]
    first, second = diagnosis("warm_up").record, diagnose(moved, base, catalogue).record
    assert (second["verdict"], second["missing"]) == (first["verdict"], first["missing"])
    assert second["rms_final"] == pytest.approx(first["rms_final"], rel=0.01)


@pytest.mark.skipif(not side_by_side.COPIES, reason="no copies of a process on this system")
def test_on_two_cores_everything_is_found_to_the_last_digit_as_on_one(diagnosis, runs, catalogue, base, monkeypatch) -> None:
    monkeypatch.setattr(side_by_side, "ALLOWED", 2)
    assert diagnose(runs("hysteresis", 1, 12.0), base, catalogue).record == diagnosis("hysteresis", 1, 12.0).record
