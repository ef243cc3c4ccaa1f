"""The proposed run as a command: the simulator takes it, and its hidden effect is the one that was fitted, whatever unit the runs are in."""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from unittest import mock

import pytest
import torch
from torch import Generator

from zoo.catalog import build, names
from zoo.cli import application
from zoo.diagnosis.experiment.family import Candidate
from zoo.diagnosis.experiment.prediction import Predicted
from zoo.diagnosis.experiment.proposal import Proposal, _short
from zoo.effects.base import Effect, History, Parameter
from zoo.measurements.run import Run
from zoo.models.trained import Trained
from zoo.scoring.noise import NoiseModel, Whitener
from zoo.simulator.laboratory.program import Program
from zoo.training.weights import reset
from zoo.units import convert, suffixes

CATALOGUE: dict[str, Effect] = {name: build("effects", name) for name in names("effects")}
RATES = suffixes("rate")
LEGS = ((20.0, 20.0, 3600.0), (20.0, 40.0, 1800.0), (40.0, 40.0, 5400.0))
TURNS_DPH = ((10.0, 5400.0), (-10.0, 5400.0))
SMALL, BEYOND = 1e-9, 1e9
WRITTEN = 1e-5
"""Relative; what six digits of each parameter leave of a value."""


def recorded(unit: str, thermometers: int = 1) -> Run:
    """A run with a rate table's turns, as a proposal predicts it."""
    time = torch.arange(360, dtype=torch.float64) * 30
    reference = torch.where(time < 5400, 10.0, -10.0).to(time)
    reference = convert(reference, "dph", unit) if unit in RATES else reference
    temperature = 20 + time / 500 + torch.sin(time / 1300)
    names_of = ("temperature_c", *(f"temperature_{place}_c" for place in range(1, thermometers)))
    columns = ("time_s", *names_of, f"reference_{unit}")
    table = torch.stack([time, *[temperature] * thermometers, reference], dim=1)
    count = torch.ones(len(time), dtype=torch.int64)
    return Run("next", unit, 150.0, columns, table, torch.sin(time / 800), count, torch.arange(len(time)) // 5)


def proposal(truth: Effect | None, fitted: dict[str, float], unit: str = "dph", model: Sequence[Effect] = (), thermometers: int = 1) -> Proposal:
    run, name = recorded(unit, thermometers), "neither" if truth is None else truth.name
    turns = tuple((convert(rate, "dph", unit) if unit in RATES else rate, seconds) for rate, seconds in TURNS_DPH)
    candidate = Candidate("a ramp", "what follows the temperature", LEGS, ((1.0, 5400.0), (-1.0, 5400.0)), "rate_table")
    new = Predicted(run, Whitener(NoiseModel(1.0, 0.0), []), Program(LEGS, turns))
    effects = {one.name: one for one in model}
    return Proposal(candidate, (name, "other"), (), 50.0, new, torch.zeros(run.blocks), (name, "other"), truth, fitted, (), effects, enough=True)


def fitted(effect: Effect, amplitude: float = SMALL) -> dict[str, float]:
    """Its default shape and amplitudes that all differ."""
    return {one.name: one.default for one in effect.shape} | {one.name: amplitude * (k + 1.0) for k, one in enumerate(effect.amplitudes)}


def words_of(one: Proposal) -> list[str]:
    command = one.command()
    assert command is not None
    words = shlex.split(command)
    assert words[:2] == ["fogzoo", "simulate"]
    return words[2:]


def settings(one: Proposal) -> dict[str, str]:
    return dict(word.split("=", 1) for word in words_of(one))


def values(one: Proposal) -> dict[str, float]:
    """The hidden effect's parameters in the command."""
    return {key.split(".")[-1]: float(value) for key, value in settings(one).items() if key.startswith(f"+parameters.{one.compared[0]}.")}


def share(effect: Effect, given: dict[str, float], unit: str) -> torch.Tensor:
    """(T,) what an effect adds to a run in which everything moves [unit]."""
    run = recorded(unit)
    swing = torch.sin(run.time / 1700)
    inputs = dict.fromkeys(effect.needs, 5.0 + swing)
    history = History(run.time, run.temperature, swing, swing.cos(), run.temperature, run.table[:, -1], inputs)
    shape, amplitude = (torch.tensor([given[one.name] for one in declared], dtype=torch.float64) for declared in (effect.shape, effect.amplitudes))
    return effect.columns(history, shape) @ amplitude


def accepted(one: Proposal, folder: Path) -> dict[str, dict[str, float]]:
    """What the simulator makes of the command: the truth's parameters by effect."""
    with mock.patch.object(sys, "argv", []), mock.patch.dict(os.environ, {"HYDRA_FULL_ERROR": "0"}):
        assert application.run("simulate", [*words_of(one), "sample_s=60", "pictures=false", f"hydra.run.dir={folder}"]) == 0
    truth = json.loads((folder / "truth.json").read_text())
    return {name: {key: entry["value"] for key, entry in entries.items()} for name, entries in truth["parameters"].items()}


@pytest.mark.parametrize("unit", RATES)
@pytest.mark.parametrize("name", CATALOGUE)
def test_the_effect_in_the_command_is_the_fitted_one(name, unit) -> None:
    """Both add the same to the error, by the effect's own columns, which know nothing of how a parameter's unit is written."""
    effect = CATALOGUE[name]
    given = fitted(effect)
    in_dph = {**given, **values(proposal(effect, given, unit))}
    assert {one.name for one in effect.amplitudes} <= set(values(proposal(effect, given, unit)))
    wanted = convert(share(effect, given, unit), unit, "dph")
    assert float(wanted.abs().max()) > 0
    torch.testing.assert_close(share(effect, in_dph, "dph"), wanted, rtol=0, atol=WRITTEN * float(wanted.abs().max()))


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_simulator_takes_the_command_and_its_values(name, tmp_path) -> None:
    effect, unit = CATALOGUE[name], "rad_per_s"
    one = proposal(effect, fitted(effect), unit, [CATALOGUE[other] for other in ("static_bias", "shupe") if other != name])
    wanted, found = values(one), accepted(one, tmp_path)[name]
    assert {key: found[key] for key in wanted} == pytest.approx(wanted)
    drawn = {other.name for other in effect.shape if other.scale == "index" or name == "shupe"}
    assert set(wanted) == {other.name for other in (*effect.shape, *effect.amplitudes)} - drawn


@pytest.mark.parametrize("name", CATALOGUE)
def test_amplitudes_of_which_one_is_out_of_bounds_are_left_to_the_simulator(name, tmp_path) -> None:
    effect = CATALOGUE[name]
    one = proposal(effect, fitted(effect) | {effect.amplitudes[-1].name: BEYOND})
    assert not set(values(one)) & {other.name for other in effect.amplitudes}
    assert {other.name for other in effect.shape if other.scale != "index"} == set(values(one)) or name == "shupe"
    accepted(one, tmp_path)


def test_a_shape_out_of_the_simulators_bounds_is_left_out() -> None:
    effect = CATALOGUE["dead_band"]
    assert set(values(proposal(effect, fitted(effect) | {"width": 100.0}, "rad_per_s"))) == {"edge", "depth"}


def test_a_network_is_no_effect_of_a_simulated_gyro(tmp_path) -> None:
    run = recorded("dph")
    model = build("model", "bp", features=["temperature", "temperature_rate"])
    reset(model, Generator().manual_seed(1))
    model.standardise(model.features(run.select(model.inputs)), run.error)
    network, mohr = Trained("bp", model, [run]), CATALOGUE["mohr"]
    assert settings(proposal(mohr, fitted(mohr), model=[network, CATALOGUE["shupe"]]))["effects"] == "[shupe]"
    alone = proposal(mohr, fitted(mohr), model=[network])
    assert settings(alone)["effects"] == "[]"
    assert set(accepted(alone, tmp_path)) == {"mohr"}


class Blown(Effect):
    """Of a column that no simulated gyro records."""

    name = "blown"
    needs = ("airflow",)
    amplitudes = (Parameter("gain", 0.0, "unit", -1.0, 1.0),)


def test_what_no_simulated_gyro_can_show_has_no_command() -> None:
    blown, mohr, scale_factor = Blown(), CATALOGUE["mohr"], CATALOGUE["scale_factor"]
    assert proposal(blown, fitted(blown)).record()["command"] is None
    assert proposal(None, {}).command() is None
    assert proposal(scale_factor, fitted(scale_factor), "ug").command() is None, "whose true input is no rate"
    assert values(proposal(mohr, fitted(mohr), "ug")) == {}
    assert settings(proposal(mohr, fitted(mohr), model=[blown]))["effects"] == "[]"


@pytest.mark.parametrize(("thermometers", "taken"), [(1, "1"), (2, "2"), (5, "5"), (6, "5"), (12, "5")])
def test_a_simulated_gyro_has_five_thermometers_at_most(thermometers, taken, tmp_path) -> None:
    mohr = CATALOGUE["mohr"]
    one = proposal(mohr, fitted(mohr), thermometers=thermometers)
    assert settings(one)["thermometers"] == taken
    accepted(replace(one, model={"static_bias": CATALOGUE["static_bias"]}), tmp_path)


def test_legs_are_as_short_as_they_can_be() -> None:
    assert _short([[-0.0, 25.0, 3600.0], [0.5, -35.0, 1 / 3]]) == "[[0,25,3600],[0.5,-35,0.333333333]]"
