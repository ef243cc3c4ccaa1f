"""`torch_device=cuda` gives what the CPU gives, wherever torch computes; these need a GPU."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import torch

from zoo.cli.application import run

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device here")

DEVICES = ("cpu", "cuda")
HIDDEN = ["hidden=hysteresis", "runs=2", "sample_s=10", "amplitude=0.12", "thermometers=1", "seed=3", "pictures=false"]
OTHER_BITS = 1e-6
"""Of a fit that a device changes in its last bits only."""
OTHER_WAYS = 0.1
"""Of a descent or a swarm, whose way the last bits change."""


@pytest.fixture(scope="module")
def gyro(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("gyro")
    assert run("simulate", [*HIDDEN, f"hydra.run.dir={folder}"]) == 0
    return folder


def data(folder: Path) -> list[str]:
    return [f"data.files=[{folder}/run_*.csv]", f"data.check_files=[{folder}/check.csv]"]


def both(gyro: Path, tmp_path: Path, *settings: str) -> list[dict[str, Any]]:
    """Metrics of one training on each device."""
    for device in DEVICES:
        assert run("train", [*settings, *data(gyro), f"torch_device={device}", f"hydra.run.dir={tmp_path / device}"]) == 0
    return [json.loads((tmp_path / device / "metrics.json").read_text()) for device in DEVICES]


def test_a_gyro_is_simulated_alike(tmp_path) -> None:
    for device in DEVICES:
        assert run("simulate", [*HIDDEN, f"torch_device={device}", f"hydra.run.dir={tmp_path / device}"]) == 0
    one, other = (pd.read_csv(tmp_path / device / "run_1.csv") for device in DEVICES)
    pd.testing.assert_frame_equal(one, other, rtol=0.0, atol=2e-5)


@pytest.mark.parametrize(
    "settings",
    [
        ["model=polynomial"],
        ["model=piecewise_polynomial"],
        ["model=ls_svm"],
        ["model=takagi_sugeno", "optimizer=gustafson_kessel"],
        ["model=graybox", "effects=[static_bias,shupe,mohr,hysteresis]"],
        ["model=bp", "optimizer=sgd", "epochs=20"],
        ["model=bp", "optimizer=adam", "epochs=20"],
        ["model=bp", "optimizer=adam", "epochs=20", "batch_size=64"],
        ["model=bp", "optimizer=adam", "epochs=20", "seeds=3"],
        ["model=wavelet", "optimizer=adam", "epochs=20"],
        ["model=takagi_sugeno", "optimizer=adam", "epochs=20"],
    ],
    ids=" ".join,
)
def test_a_fit_ends_alike(gyro, tmp_path, settings) -> None:
    one, other = both(gyro, tmp_path, *settings)
    assert other["device"] == "cuda"
    assert other["rms"] == pytest.approx(one["rms"], rel=OTHER_BITS)
    assert other["rms_check"] == pytest.approx(one["rms_check"], rel=1e3 * OTHER_BITS)


@pytest.mark.parametrize(
    "settings",
    [
        ["model=bp", "optimizer=lbfgs", "epochs=50"],
        ["model=bp", "optimizer=levenberg_marquardt", "epochs=50"],
        ["model=bp", "optimizer=levenberg_marquardt", "epochs=20", "seeds=3"],
        ["model=wavelet", "optimizer=levenberg_marquardt", "epochs=20"],
        ["model=takagi_sugeno", "optimizer=levenberg_marquardt", "epochs=20"],
        ["model=bp", "init=aco", "epochs=20"],
        ["model=bp", "init=pso", "epochs=20"],
        ["model=bp", "init=pso", "epochs=20", "seeds=3"],
        ["model=bp", "init=aco_pheromone", "epochs=20"],
        ["model=takagi_sugeno", "init=gustafson_kessel", "optimizer=adam", "epochs=20"],
        ["model=bp", "optimizer=pso"],
        ["model=piecewise_polynomial", "optimizer=pso"],
        ["model=hybrid", "effects=[hysteresis]"],
    ],
    ids=" ".join,
)
def test_a_search_ends_about_as_well(gyro, tmp_path, settings) -> None:
    one, other = both(gyro, tmp_path, *settings)
    assert other["device"] == "cuda"
    assert other["rms"] == pytest.approx(one["rms"], rel=OTHER_WAYS)


def test_a_training_on_the_gpu_goes_on_on_the_cpu(gyro, tmp_path) -> None:
    settings = ["model=bp", "optimizer=adam", *data(gyro)]
    assert run("train", [*settings, "epochs=20", f"hydra.run.dir={tmp_path / 'whole'}"]) == 0
    assert run("train", [*settings, "epochs=10", "torch_device=cuda", f"hydra.run.dir={tmp_path / 'half'}"]) == 0
    assert run("train", [*settings, "epochs=20", f"resume={tmp_path / 'half'}", f"hydra.run.dir={tmp_path / 'rest'}"]) == 0
    whole, rest = (json.loads((tmp_path / name / "metrics.json").read_text())["rms"] for name in ("whole", "rest"))
    assert rest == pytest.approx(whole, rel=OTHER_BITS)


def test_a_diagnosis_comes_out_alike(gyro, tmp_path) -> None:
    for device in DEVICES:
        assert run("diagnose", [*data(gyro), f"torch_device={device}", f"hydra.run.dir={tmp_path / device}"]) == 0
    one, other = (json.loads((tmp_path / device / "diagnosis.json").read_text()) for device in DEVICES)
    assert one["verdict"] == other["verdict"]
    assert one["missing"] == other["missing"] == ["hysteresis"]


def test_what_is_refined_and_trained_there_diagnoses_compensates_and_exports(gyro, tmp_path) -> None:
    cuda, model = "torch_device=cuda", tmp_path / "refined"
    assert run("refine", ["add=auto", *data(gyro), cuda, f"hydra.run.dir={model}"]) == 0
    assert run("diagnose", [f"model.folder={model}", *data(gyro), cuda, f"hydra.run.dir={tmp_path / 'again'}"]) == 0
    assert json.loads((tmp_path / "again" / "diagnosis.json").read_text())["missing"] == []
    for device in DEVICES:
        place = f"hydra.run.dir={tmp_path / device}"
        assert run("compensate", [f"run={model}", f"data.files=[{gyro}/check.csv]", f"torch_device={device}", place]) == 0
        assert run("compare", [f"runs=[{model}]", f"data.files=[{gyro}/check.csv]", f"torch_device={device}", place]) == 0
    one, other = (pd.read_csv(next((tmp_path / device).glob("*check*.csv"))) for device in DEVICES)
    pd.testing.assert_frame_equal(one, other, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("settings", [["model=bp", "epochs=20"], ["model=graybox", "effects=[static_bias,mohr,hysteresis]"]], ids=" ".join)
def test_an_exported_file_says_on_the_gpu_what_it_says_on_the_cpu(gyro, tmp_path, settings) -> None:
    assert run("train", [*settings, *data(gyro), "torch_device=cuda", f"hydra.run.dir={tmp_path / 'trained'}"]) == 0
    assert run("export", [f"run={tmp_path / 'trained'}", f"hydra.run.dir={tmp_path / 'exported'}"]) == 0
    program = torch.jit.load(tmp_path / "exported" / "model.ts")
    x = torch.tensor(pd.read_csv(gyro / "check.csv")[list(program.inputs)].to_numpy())
    here = program(x)
    torch.testing.assert_close(program.cuda()(x.cuda()).cpu(), here, rtol=0.0, atol=1e-9)
    assert (
        run(
            "compare",
            [
                f"runs=[{tmp_path / 'trained'},{tmp_path / 'exported'}]",
                f"data.files=[{gyro}/check.csv]",
                "torch_device=cuda",
                f"hydra.run.dir={tmp_path / 'compared'}",
            ],
        )
        == 0
    )
    *_, one, other = json.loads((tmp_path / "compared" / "comparison.json").read_text())["rms"].values()
    assert one == pytest.approx(other, rel=OTHER_BITS)
