"""`diagnose` and `refine` of a trained model, and `train model=hybrid`, as a user types them."""

import copy
import json
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
import torch
from torch import Generator, Tensor

from zoo.catalog import load_model
from zoo.cli.application import run
from zoo.cli.saved_models import folder_settings
from zoo.effects.base import History
from zoo.effects.hysteresis import Hysteresis
from zoo.fitting.noise import blocks_of, noise_of
from zoo.measurements.read import read_runs
from zoo.measurements.run import Run
from zoo.models.bp import BP
from zoo.models.hybrid import Hybrid
from zoo.report.trace import rms
from zoo.scoring.noise import Whitener
from zoo.training.alternating import Alternating

FLOOR = 1.2
"""RMS on a run that was not fitted, over its noise floor, that a complete model may have."""


def simulated(folder: Path, hidden: str, seed: int, runs: int = 2) -> Path:
    given = ["amplitude=0.12", f"runs={runs}", "sample_s=20", "thermometers=1", f"seed={seed}", "pictures=false"]
    assert run("simulate", [f"hidden={hidden}", *given, f"hydra.run.dir={folder}"]) == 0
    return folder


def loop(parameters: dict) -> float:
    """Half the height of a hysteresis loop at its middle, A·r/s [°/h]."""
    amplitude, width, spread = (parameters[name]["value"] for name in ("amplitude", "width", "spread"))
    return amplitude * width / spread


@pytest.fixture(scope="module")
def gyro(tmp_path_factory) -> Path:
    """Runs of a gyro with hysteresis, which a map of the thermometer and its rate cannot follow; three, for two leave open how a network goes on."""
    return simulated(tmp_path_factory.mktemp("gyro"), "hysteresis", 3, runs=3)


def data(folder: Path) -> list[str]:
    return [f"data.files=[{folder}/run_*.csv]", f"data.check_files=[{folder}/check.csv]"]


@pytest.fixture(scope="module")
def network(gyro, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("network")
    assert run("train", ["model=bp", "epochs=1500", *data(gyro), f"hydra.run.dir={out}"]) == 0
    return out


def result(folder: Path, name: str) -> dict:
    return json.loads((folder / name).read_text())


def test_a_model_without_weights_is_refused_for_that(gyro, tmp_path, capsys) -> None:
    given = [f"data.files=[{gyro}/run_1.csv]"]
    assert run("train", ["model=ls_svm", *given, f"hydra.run.dir={tmp_path / 'net'}"]) == 0
    assert run("diagnose", [f"model={tmp_path / 'net'}", *given, f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    assert "ls_svm has no weights, by which to find what a model lacks" in capsys.readouterr().err


@pytest.mark.slow
def test_what_a_network_lacks_is_named(gyro, network, tmp_path, capsys) -> None:
    assert run("diagnose", [f"model={network}", *data(gyro), f"hydra.run.dir={tmp_path}"]) == 0
    found = result(tmp_path, "diagnosis.json")
    assert (found["verdict"], found["missing"], found["effects"]) == ("missing", ["hysteresis"], ["bp"])
    assert found["model"] == {"path": str(network), "name": "bp"}
    assert found["rms"] == pytest.approx(result(network, "metrics.json")["rms"], rel=0.02), "of the model as it was trained, spikes apart"
    assert "bp" not in found["parameters"]
    assert {"static_bias", "shupe", "mohr"} <= {one["effect"] for one in found["candidates"]}
    assert (tmp_path / "report.html").is_file()
    assert f"fogzoo refine 'add=[hysteresis]' model.folder={network}" in capsys.readouterr().out


@pytest.mark.slow
def test_a_polynomial_lacks_the_fringes(tmp_path) -> None:
    fringes, out = simulated(tmp_path / "gyro", "polarization", 1), tmp_path / "polynomial"
    assert run("train", ["model=polynomial", "model.order=4", *data(fringes), f"hydra.run.dir={out}"]) == 0
    assert run("diagnose", [f"model={out}", *data(fringes), f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    found = result(tmp_path / "out", "diagnosis.json")
    assert (found["verdict"], found["missing"]) == ("missing", ["polarization"]), "at a coil that a map of the thermometer says nothing of"
    truth, period = result(fringes, "truth.json")["parameters"]["polarization"]["period"]["value"], found["parameters"]["polarization"]["period"]
    assert abs(period["value"] - truth) < 4 * period["stderr"]
    assert next(one["probability"] for one in found["candidates"] if one["effect"] == "polarization") > 0.9


@pytest.mark.slow
def test_with_its_missing_effect_a_network_reaches_the_floor_of_a_run_it_never_saw(gyro, network, tmp_path) -> None:
    assert run("refine", [f"model={network}", "add=auto", *data(gyro), f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    found = result(tmp_path / "out", "refinement.json")
    assert [rung["added"] for rung in found["ladder"]] == [None, "hysteresis"]
    assert [rung["effects"] for rung in found["ladder"]] == [["bp"], ["bp", "hysteresis"]]
    before, after = (rung["rms_check"] for rung in found["ladder"])
    assert before == pytest.approx(result(network, "metrics.json")["rms_check"])
    assert after < FLOOR * found["noise_floor_check"] < before
    assert found["verdict"] == "complete"
    truth, amplitude = result(gyro, "truth.json")["parameters"]["hysteresis"], found["parameters"]["hysteresis"]["amplitude"]
    assert abs(amplitude["value"] - truth["amplitude"]["value"]) < 4 * amplitude["stderr"]
    assert isinstance(load_model(tmp_path / "out"), Hybrid)
    assert run("compare", [f"runs=[{network},{tmp_path / 'out'}]", f"data.files={gyro}/check.csv", f"hydra.run.dir={tmp_path / 'table'}"]) == 0
    compared = result(tmp_path / "table", "comparison.json")["rms"]
    assert compared["hybrid"] == pytest.approx(after, rel=1e-3)
    assert run("diagnose", [f"model={tmp_path / 'out'}", *data(gyro), f"hydra.run.dir={tmp_path / 'again'}"]) == 0
    again = result(tmp_path / "again", "diagnosis.json")
    assert (again["verdict"], again["missing"], again["effects"]) == ("complete", [], ["hybrid", "hysteresis"])


@pytest.mark.slow
def test_effects_beside_a_model_are_added_to_it(gyro, network, tmp_path) -> None:
    assert run("diagnose", [f"model={network}", "effects=[hysteresis]", *data(gyro), f"hydra.run.dir={tmp_path / 'one'}"]) == 0
    found = result(tmp_path / "one", "diagnosis.json")
    assert (found["verdict"], found["missing"], found["effects"]) == ("complete", [], ["bp", "hysteresis"])
    assert found["rms"] < 0.7 * result(network, "metrics.json")["rms"]


@pytest.mark.slow
def test_a_hybrid_is_trained_and_beats_its_network(gyro, network, tmp_path) -> None:
    for name, network_settings in (("hybrid", []), ("cubic", ["model@model.network=polynomial", "model.network.order=3"])):
        out = tmp_path / name
        assert run("train", ["model=hybrid", "effects=[hysteresis]", *network_settings, *data(gyro), f"hydra.run.dir={out}"]) == 0
        metrics, truth = result(out, "metrics.json"), result(gyro, "truth.json")["parameters"]["hysteresis"]
        assert (metrics["model"], metrics["optimizer"], metrics["init"]) == ("hybrid", "alternating", None)
        assert metrics["rms_check"] < 0.6 * result(network, "metrics.json")["rms_check"]
        for parameter in ("width", "amplitude"):
            found = metrics["physical"]["hysteresis"][parameter]
            assert 0 < found["stderr"] < abs(found["value"])
        assert abs(found["value"] - truth["amplitude"]["value"]) < 4 * found["stderr"]
        from_here, deepest = less_likely(out, gyro, truth, starts=4 if name == "hybrid" else 0)
        assert from_here > -0.5, "no other minimum is deeper"
        assert deepest < 4**2, "the truth is not ruled out"
        assert loop(metrics["physical"]["hysteresis"]) == pytest.approx(loop(truth), rel=0.15), "amplitude and spread make up for each other"


class KnownLoop(Hysteresis):
    """Hysteresis of one shape: only its size is free."""

    shape = ()

    def __init__(self, known: dict[str, dict]) -> None:
        super().__init__()
        self.known = [known[parameter.name]["value"] for parameter in Hysteresis.shape]

    def columns(self, history: History, shape: Tensor) -> Tensor:
        return super().columns(history, torch.tensor(self.known, dtype=torch.float64).expand(*shape.shape[:-1], -1))


def less_likely(out: Path, gyro: Path, truth: dict, starts: int) -> tuple[float, float]:
    """By how much χ² is higher with the loop's true shape than with the one found, all else trained to it: from there, and at the deepest of all.

    A network ends where it began, and processors round otherwise: from one start alone χ² of the truth is 7 to 33 higher. A polynomial is linear.

    A network linearised where it stands beside another loop would leave the true one more than the network itself does, once trained beside it.
    What stays is more than chance: the network maps the thermometer, Shupe's effect lives in the coil, and the loop makes up for some of that.
    """
    hybrid, runs = load_model(out), read_runs(str(gyro / "run_*.csv"))
    known = Hybrid(copy.deepcopy(hybrid.network), {"hysteresis": KnownLoop(truth)}, hybrid.inputs)
    with torch.no_grad():
        known.physics.coil_value.copy_(hybrid.physics.coil_value)
    others = [copy.deepcopy(known) for _ in range(starts)]
    Alternating(rounds=60, steps=300, draw=False).fit(known, runs, Generator())
    for seed, other in enumerate(others):
        Alternating(rounds=60, steps=300).fit(other, runs, Generator().manual_seed(seed))
    left = [float(Whitener(noise_of(runs), blocks_of(runs))(misfit(model, runs)).square().sum()) for model in (hybrid, known, *others)]
    return left[1] - left[0], min(left[1:]) - left[0]


def misfit(model: Hybrid, runs: list[Run]) -> Tensor:
    """(N, 1) block means of what a model leaves of the error, run after run."""
    with torch.no_grad():
        return torch.cat([run.block_mean_columns((run.error - model(run.select(model.inputs))).unsqueeze(-1)) for run in runs])


@pytest.fixture(scope="module")
def sum_of_effects(gyro, tmp_path_factory) -> Path:
    """A grey box that was fitted to one of the runs."""
    out = tmp_path_factory.mktemp("sum")
    files = [f"data.files=[{gyro}/run_1.csv]", "data.average_s=100"]
    assert run("train", ["model=graybox", "effects=[static_bias,shupe,mohr]", *files, f"hydra.run.dir={out}"]) == 0
    return out


@pytest.mark.slow
def test_a_trained_sum_of_effects_is_on_the_first_rung_as_it_was_given(gyro, sum_of_effects, tmp_path) -> None:
    asked = [f"model={sum_of_effects}", "candidates=[hysteresis]", "data.average_s=100", *data(gyro)]
    assert run("diagnose", [*asked, f"hydra.run.dir={tmp_path / 'diagnosed'}"]) == 0
    with mock.patch("zoo.report.page.write_report") as written:
        assert run("refine", [*asked, "add=hysteresis", f"hydra.run.dir={tmp_path / 'refined'}"]) == 0
    diagnosed, refined = result(tmp_path / "diagnosed", "diagnosis.json"), result(tmp_path / "refined", "refinement.json")
    first, last = refined["ladder"]
    assert first["rms"] == pytest.approx(diagnosed["rms"], rel=1e-12)
    given, check = load_model(sum_of_effects), read_runs(f"{gyro}/check.csv", average_s=100.0)
    assert first["rms_check"] == pytest.approx(float(misfit(given, check).square().mean().sqrt()), rel=1e-9)
    assert last["rms"] < first["rms"]
    drawn = [trace for trace in written.call_args.args[2] if trace.role == "fit"]
    assert rms(np.concatenate([trace.residual for trace in drawn])) == pytest.approx(first["rms"], rel=1e-9)
    assert rms(np.concatenate([trace.residual_after for trace in drawn])) == pytest.approx(last["rms"], rel=1e-6)


def test_a_trained_sum_of_effects_to_which_nothing_is_added_stays_as_it_was_given(sum_of_effects, tmp_path) -> None:
    other, out = simulated(tmp_path / "other", "0", 5), tmp_path / "out"
    asked = [f"model={sum_of_effects}", "candidates=[aging]", "data.average_s=100", *data(other)]
    assert run("refine", [*asked, "data.check_files=[]", f"hydra.run.dir={out}"]) == 0
    found, given = result(out, "refinement.json"), load_model(sum_of_effects)
    assert [rung["added"] for rung in found["ladder"]] == [None]
    assert torch.equal(load_model(out).theta(), given.theta())
    assert found["parameters"] == result(sum_of_effects, "metrics.json")["physical"]
    assert found["ladder"][0]["rms"] > 2 * found["noise_floor"]
    assert found["verdict"] == "unknown", "of another gyro: with other values, though, the same effects would leave noise"


def test_a_trained_model_that_does_not_fit_is_complete_neither_in_words_nor_in_json(gyro, tmp_path, capsys) -> None:
    """Hardly trained: with other weights it would leave the noise of these runs, and as it is it leaves many times that."""
    files = [f"data.files={gyro}/run_1.csv"]
    assert run("train", ["model=bp", "model.hidden=12", "epochs=2", *files, f"hydra.run.dir={tmp_path / 'bp'}"]) == 0
    for verb, name in (("diagnose", "diagnosis.json"), ("refine", "refinement.json")):
        capsys.readouterr()
        assert run(verb, [f"model={tmp_path / 'bp'}", "candidates=[mohr]", *files, f"hydra.run.dir={tmp_path / verb}"]) == 0
        found, said = result(tmp_path / verb, name), capsys.readouterr().out
        assert found["verdict"] == "unknown"
        assert "does not fit these runs" in said
        if verb == "diagnose":
            assert found["verdict_refitted"] == "complete"
            assert found["rms"] > 1.5 * found["noise_floor"]
            assert not list((tmp_path / verb).glob("*.py")), "there is no effect to write"


def test_a_networks_name_alone_takes_it_as_it_is(gyro, tmp_path) -> None:
    settings = ["model=hybrid", "model.network=polynomial", "effects=[magnetic]", "optimizer=alternating", "optimizer.rounds=1"]
    assert run("train", [*settings, *data(gyro), f"hydra.run.dir={tmp_path}"]) == 0
    assert type(load_model(tmp_path).network).__name__ == "Polynomial"
    assert run("train", ["model=hybrid", "model.network=polynomia", *data(gyro), f"hydra.run.dir={tmp_path / 'no'}"]) == 2


def test_a_wrong_model_is_named_in_a_line(gyro, tmp_path, capsys) -> None:
    small = ["model.hidden=2", "epochs=3"]
    for name in ("one", "two"):
        assert run("train", ["model=bp", *small, *data(gyro), f"hydra.run.dir={tmp_path / 'many' / name}"]) == 0
    assert isinstance(load_model(tmp_path / "many" / "one"), BP)
    capsys.readouterr()
    other = tmp_path / "other.csv"
    other.write_text((gyro / "run_1.csv").read_text().replace("_dph", "_rad_per_s"))
    for given, words in (
        (["model=nowhere"], ["model: nowhere: no model.yaml"]),
        ([f"model={gyro}"], ["no model.yaml", "output folder of a train"]),
        ([f"model={tmp_path / 'many'}"], ["2 models", str(tmp_path / "many" / "one")]),
        ([f"model={tmp_path / 'many' / 'one'}", "effects=[hyst]"], ["'hyst'", "did you mean hysteresis"]),
        ([f"model={tmp_path / 'many' / 'one'}", f"data.files={other}", "data.check_files=[]"], ["trained on errors in dph", "rad_per_s"]),
    ):
        for verb in ("diagnose", "refine"):
            assert run(verb, [*data(gyro), *given, f"hydra.run.dir={tmp_path / 'out'}"]) == 2
            message = capsys.readouterr().err
            assert len(message.splitlines()) <= 2
            for word in words:
                assert word in message


def test_only_a_bare_model_becomes_a_folder() -> None:
    assert folder_settings(["-m", "model=a,b", "model.folder=c", "data.files=[x]"]) == ["-m", "model.folder=a,b", "model.folder=c", "data.files=[x]"]
