"""Many gyros at once: each is the one that its seed draws by itself, and they come one after the other."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
import torch

from zoo.catalog import build, names
from zoo.cli.application import run as fogzoo
from zoo.physics.conduction import FIDELITIES
from zoo.simulator import simulate as module
from zoo.simulator.gyros.device import draw
from zoo.simulator.gyros.presets import MEDIUM, NAVIGATION, TACTICAL
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.laboratory.profiles import legs
from zoo.simulator.noise import Noise
from zoo.simulator.recorded import Recorded
from zoo.simulator.simulate import fleet, simulate
from zoo.simulator.simulation import Simulation

CATALOGUE = {name: build("effects", name) for name in names("effects")}
PRESENT = {name: CATALOGUE[name] for name in ("static_bias", "shupe", "mohr")}
PROFILE = legs([[20, 20, 1200], [20, 45, 1500], [45, 45, 1200], [45, -10, 3300], [-10, -10, 1200]])
SMOOTH = Noise(angle_step_arcsec=0.0, resolution_c=0.0)
"""Noise, but nothing counted in steps, where the last digit of the heat may decide."""
SETTINGS = {"hidden": 2, "catalogue": CATALOGUE, "runs": 2, "sample_s": 20.0, "seed": 5}


@pytest.fixture
def few_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches of three."""
    monkeypatch.setattr(module, "AT_ONCE", 3)


def recordings(one: Simulation) -> list[Recorded]:
    return [*one.runs, one.check]


def assert_same(one: Simulation, other: Simulation) -> None:
    """To round-off, which matrix products of another size leave in the temperatures."""
    assert (one.device, one.hidden, one.noise, list(one.shares)) == (other.device, other.hidden, other.noise, list(other.shares))
    for name, share in one.shares.items():
        torch.testing.assert_close(share.shape, other.shares[name].shape, rtol=1e-9, atol=0)
        torch.testing.assert_close(share.amplitude, other.shares[name].amplitude, rtol=1e-7, atol=0)
        assert share.rms == pytest.approx(other.shares[name].rms, rel=1e-7)
    for mine, its in zip(recordings(one), recordings(other), strict=True):
        assert (mine.name, mine.program, list(mine.table), list(mine.truth)) == (its.name, its.program, list(its.table), list(its.truth))
        for part, same in ((mine.table, its.table), (mine.truth, its.truth)):
            for column, value in part.items():
                scale = float(value.abs().max())
                assert float((value - same[column]).abs().max()) <= 1e-8 * scale, column
        for column in ("time_s", "reference_dph", "supply_v", "field_ut"):
            assert torch.equal(mine.table[column], its.table[column])


@pytest.mark.parametrize("gyro", [MEDIUM, TACTICAL, NAVIGATION])
@pytest.mark.usefixtures("few_at_once")
def test_a_gyro_of_a_fleet_is_the_one_its_seed_draws_alone(gyro) -> None:
    """On both sides of the border between two batches, with effects of its own that are hidden."""
    for place, one in enumerate(fleet(gyro, PROFILE, PRESENT, SMOOTH, devices=5, **SETTINGS)):
        assert one.device.seed == 5 + place
        assert_same(one, simulate(gyro, PROFILE, PRESENT, SMOOTH, **{**SETTINGS, "seed": 5 + place}))


@pytest.mark.parametrize(
    "more",
    [
        {"heat": "radial_axial"},
        {"heat": "lumped", "cold_start": True},
        {"chamber": Chamber(120.0, overshoot=0.05, cycling_k=0.3, fan="in_motion", fan_dph=0.02), "thermometers": 5},
        {"hidden": ["aging", "hysteresis"], "amplitude": 0.05, "parameters": {"mohr": {"coefficient": 0.1}}},
        {"hidden": 0},
    ],
    ids=["turns", "cold", "chamber", "named", "nothing"],
)
@pytest.mark.usefixtures("few_at_once")
def test_whatever_else_is_asked_for(more: dict[str, Any]) -> None:
    settings = {**SETTINGS, **more}
    for place, one in enumerate(fleet(MEDIUM, PROFILE, PRESENT, SMOOTH, devices=4, **settings)):
        if place in {1, 3}:
            assert_same(one, simulate(MEDIUM, PROFILE, PRESENT, SMOOTH, **{**settings, "seed": 5 + place}))


def test_counted_angles_and_coarse_readings_are_the_same_but_for_rare_steps() -> None:
    (one, *_), alone = fleet(MEDIUM, PROFILE, PRESENT, devices=4, **SETTINGS), simulate(MEDIUM, PROFILE, PRESENT, **SETTINGS)
    for mine, its in zip(recordings(one), recordings(alone), strict=True):
        for column, value in mine.table.items():
            assert float((value != its.table[column]).double().mean()) < 0.01, column


def test_the_size_of_the_batches_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = list(fleet(MEDIUM, PROFILE, PRESENT, SMOOTH, devices=4, **SETTINGS))
    monkeypatch.setattr(module, "AT_ONCE", 1)
    for one, other in zip(whole, fleet(MEDIUM, PROFILE, PRESENT, SMOOTH, devices=4, **SETTINGS), strict=True):
        assert_same(one, other)


@pytest.mark.usefixtures("few_at_once")
def test_the_first_gyro_is_there_before_the_last_is_thought_of(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []

    def counted(gyro: Any, seed: int, thermometers: int) -> Any:
        seen.append(seed)
        return draw(gyro, seed, thermometers)

    monkeypatch.setattr(module, "draw", counted)
    many: Iterator[Simulation] = fleet(MEDIUM, PROFILE, PRESENT, devices=10**9, runs=1, sample_s=60.0)
    assert isinstance(many, Iterator)
    assert seen == []
    assert next(many).device.seed == 1
    assert seen == [1, 2, 3]
    assert [one.device.seed for one in islice(many, 2)] == [2, 3]
    assert seen == [1, 2, 3]
    assert next(many).device.seed == 4
    assert seen == [1, 2, 3, 4, 5, 6]


def test_gyros_of_a_fleet_differ() -> None:
    found = list(fleet(MEDIUM, PROFILE, PRESENT, devices=8, **{**SETTINGS, "hidden": 1}))
    assert len({one.hidden for one in found}) > 2
    for get in (lambda one: one.device["package_s"], lambda one: float(one.runs[0].noise[0]), lambda one: float(one.runs[0].table["supply_v"][9])):
        assert len({get(one) for one in found}) == 8


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_a_fleet_of_one_is_one(fidelity) -> None:
    (only,) = fleet(MEDIUM, PROFILE, PRESENT, SMOOTH, devices=1, heat=fidelity, **SETTINGS)
    alone = simulate(MEDIUM, PROFILE, PRESENT, SMOOTH, heat=fidelity, **SETTINGS)
    for mine, its in zip(recordings(only), recordings(alone), strict=True):
        assert all(torch.equal(value, its.table[column]) for column, value in mine.table.items())


@pytest.mark.parametrize("gyro", [MEDIUM, TACTICAL, NAVIGATION])
def test_any_gyro_of_any_class_runs(gyro) -> None:
    """Thirty of each: coils that fit, numbers above nothing, temperatures between those of the chamber and the electronics."""
    for one in fleet(gyro, PROFILE, PRESENT, devices=30, runs=1, sample_s=60.0):
        device = one.device
        assert float(device.coil.radii[0]) > 5e-3
        assert bool((device.winding.length > 0).all())
        assert all(0 < device[key] < math.inf for key in device.values if getattr(gyro, key).high > 0)
        assert 0.2 < device.conductivity < 0.5
        for run in recordings(one):
            assert all(bool(value.isfinite().all()) for value in (*run.table.values(), *run.truth.values()))
            coil = run.truth["temperature_coil_c"]
            assert -10 < float(coil.min()) < float(coil.max()) < 45 + device["self_heating_k"]


def test_the_verb_gives_each_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["fogzoo"])
    monkeypatch.delenv("HYDRA_FULL_ERROR", raising=False)
    common = ["profile=legs", "profile.legs=[[20,20,600],[20,40,1200]]", "runs=1", "hidden=1", "sample_s=20"]
    assert fogzoo("simulate", [*common, "devices=3", "seed=9", f"hydra.run.dir={tmp_path / 'all'}"]) == 0
    assert fogzoo("simulate", [*common, "seed=10", f"hydra.run.dir={tmp_path / 'one'}"]) == 0
    folders = sorted(path.name for path in (tmp_path / "all").iterdir() if path.is_dir() and path.name.startswith("device"))
    assert folders == ["device_09", "device_10", "device_11"]
    names_of = [{path.name for path in folder.glob("*.[cj]s*")} for folder in (tmp_path / "all" / "device_10", tmp_path / "one")]
    assert names_of[0] == names_of[1] == {"run_1.csv", "check.csv", "truth_1.csv", "truth_check.csv", "truth.json"}
    first, second = (json.loads((folder / "truth.json").read_text()) for folder in (tmp_path / "all" / "device_10", tmp_path / "one"))
    assert first["device"] == second["device"]
    assert first["hidden"] == second["hidden"]
