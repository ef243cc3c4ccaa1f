"""`export` as a user types it: files, exit codes, messages."""

from __future__ import annotations

import json
import shutil
from contextlib import chdir
from pathlib import Path

import pytest
import torch

from zoo.catalog import load_model
from zoo.cli.application import run
from zoo.effects.mohr import Mohr
from zoo.effects.static_bias import StaticBias

STEP_S = 20


@pytest.fixture(scope="module")
def trained(tmp_path_factory) -> Path:
    """The output folder of a training."""
    folder = tmp_path_factory.mktemp("trained")
    time = torch.arange(STEP_S / 2, 4 * 3600, STEP_S, dtype=torch.float64)
    temperature = 20 + 30 * torch.sin(time / 3000)
    rate = torch.gradient(temperature, spacing=(time / 60,))[0]
    rows = [
        f"{t:.1f},{u:.4f},{e:.6f}" for t, u, e in zip(time.tolist(), temperature.tolist(), (0.01 * temperature - 0.1 * rate).tolist(), strict=True)
    ]
    (folder / "chamber.csv").write_text("\n".join(["time_s,temperature_c,rate_dph", *rows]) + "\n")
    settings = ["model=polynomial", f"data.files=[{folder / 'chamber.csv'}]", "data.average_s=100", f"hydra.run.dir={folder / 'out'}"]
    assert run("train", settings) == 0
    return folder / "out"


@pytest.mark.slow
def test_a_training_becomes_files_that_say_where_they_come_from(trained, tmp_path, capsys) -> None:
    assert run("export", [f"run={trained}", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[-1] == str(tmp_path / "out" / "model.ts")
    assert {"model.ts", "model.pt2", "step.pt2", "metadata.json"} <= {path.name for path in (tmp_path / "out").iterdir()}
    text = (tmp_path / "out" / "metadata.json").read_text()
    metadata = json.loads(text)
    assert str(trained.parent) not in text, "nothing of this machine"
    assert (metadata["model"], metadata["unit"], metadata["inputs"]) == ("polynomial", "dph", ["time_s", "temperature_c"])
    assert metadata["settings"]["_target_"] == "zoo.models.polynomial.Polynomial"
    assert metadata["trained_on"]["runs"] == ["chamber"]
    assert metadata["physical"] is None
    assert metadata["trained_on"]["sample_interval_s"] == pytest.approx([STEP_S, STEP_S])
    low, high = metadata["trained_range"]["temperature_c"]
    assert (-11 < low < -9, 49 < high < 51) == (True, True)
    assert set(metadata["parity"]["runs"]) == {"chamber", "a made-up run"}
    x = torch.tensor([[0.0, 20.0], [7.0, 21.0], [9.0, 30.0]], dtype=torch.float64)
    with torch.no_grad():
        predicted = load_model(trained)(x)
        torch.testing.assert_close(torch.jit.load(tmp_path / "out" / "model.ts")(x), predicted, rtol=1e-12, atol=1e-12)
    formula = metadata["formula"]["coefficients"]
    assert formula["1"] + 20.0 * formula["temperature"] == pytest.approx(float(predicted[0]), rel=1e-9), "nothing has moved yet"
    assert formula == json.loads((trained / "metrics.json").read_text())["formula"]["coefficients"]


@pytest.mark.slow
def test_the_files_own_names_and_units_travel_with_the_file(trained, tmp_path, capsys) -> None:
    """The exported model takes seconds and °C, whatever the recorder wrote: how its columns become these must be found beside it."""
    header, *rows = (trained.parent / "chamber.csv").read_text().splitlines()
    assert header == "time_s,temperature_c,rate_dph"
    cells = [row.split(",") for row in rows]
    foreign = [f"{float(t) * 1e3:.0f},{float(u) + 273.15:.4f},{rate}" for t, u, rate in cells]
    (tmp_path / "foreign.csv").write_text("\n".join(["t,imu [/K]_k,gz", *foreign]) + "\n")
    names = ["data.columns.time=t", "data.time_unit=ms", "data.columns.temperature='imu [/K]_k'", "data.columns.output=gz", "data.output_unit=deg/h"]
    settings = ["model=polynomial", f"data.files=[{tmp_path / 'foreign.csv'}]", "data.average_s=100", *names]
    assert run("train", [*settings, f"hydra.run.dir={tmp_path / 'line'}"]) == 0
    capsys.readouterr()
    assert run("export", [f"run={tmp_path / 'line'}", "program=false", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    assert "in the recordings imu [/K]_k, in K" in capsys.readouterr().out
    metadata = json.loads((tmp_path / "out" / "metadata.json").read_text())
    assert metadata["inputs"] == ["time_s", "temperature_c"]
    wanted = {"time_s": ("t", "ms"), "temperature_c": ("imu [/K]_k", "K"), "output": ("gz", "°/h")}
    assert metadata["trained_on"]["recorded_as"] == {name: {"column": column, "unit": unit} for name, (column, unit) in wanted.items()}


@pytest.mark.slow
def test_the_parameters_of_effects_travel_with_the_file(trained, tmp_path) -> None:
    settings = ["model=graybox", "effects=[static_bias,mohr]", f"data.files=[{trained.parent / 'chamber.csv'}]", "data.average_s=100"]
    assert run("train", [*settings, f"hydra.run.dir={tmp_path / 'grey'}"]) == 0
    assert run("export", [f"run={tmp_path / 'grey'}", "program=false", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    metadata, metrics = (json.loads((tmp_path / name).read_text()) for name in ("out/metadata.json", "grey/metrics.json"))
    assert metadata["physical"] == metrics["physical"]
    assert {"static_bias", "mohr"} <= set(metadata["physical"])
    assert {name: one["formula"] for name, one in metadata["formula"]["effects"].items()} == {"static_bias": StaticBias.formula, "mohr": Mohr.formula}
    assert {one["place"] for one in metadata["formula"]["effects"].values()} == metadata["formula"]["places"].keys() - {"housing"}
    assert metadata["meaning"].keys() <= {*metadata, *metadata["trained_on"]}


@pytest.mark.slow
def test_recordings_that_are_gone_are_done_without(trained, tmp_path) -> None:
    for name in ("model.yaml", "weights.pt", "ranges.json", "metrics.json"):
        (tmp_path / name).write_bytes((trained / name).read_bytes())
    assert run("export", [f"run={tmp_path}", "refuse_outside=true", "program=false", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    metadata = json.loads((tmp_path / "out" / "metadata.json").read_text())
    assert list(metadata["parity"]["runs"]) == ["a made-up run"]
    assert list(metadata["files"]) == ["model.ts"]
    assert not (tmp_path / "out" / "model.pt2").exists()
    assert metadata["trained_on"]["sample_interval_s"] is metadata["trained_on"]["recorded_as"] is None
    script = torch.jit.load(tmp_path / "out" / "model.ts")
    assert script(torch.tensor([[0.0, 20.0], [1.0, 80.0]], dtype=torch.float64)).isnan().tolist() == [False, True]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "run is not set"),
        (["run=nowhere"], "no model.yaml in or below it"),
        (["run={trained}", "refuse_outside=maybe"], "refuse_outside=maybe: true or false is possible"),
        (["run={trained}", "torch_device=tpu"], "possible: cpu, cuda"),
    ],
)
def test_wrong_settings_are_told_and_leave_nothing(trained, tmp_path, arguments, told, capsys) -> None:
    filled = [one.format(trained=trained) for one in arguments]
    assert run("export", [*filled, f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_what_is_exported_already_is_no_model_to_export(tmp_path, capsys) -> None:
    (tmp_path / "model.ts").touch()
    for verb, more in (("export", []), ("compensate", ["data.files=[a.csv]"])):
        assert run(verb, [f"run={tmp_path}", *more, f"hydra.run.dir={tmp_path / 'out'}"]) == 2
        assert "is exported already; give the output folder of the train or refine command" in capsys.readouterr().err


def test_a_model_without_its_results_has_no_unit(trained, tmp_path, capsys) -> None:
    for name in ("model.yaml", "weights.pt"):
        (tmp_path / name).write_bytes((trained / name).read_bytes())
    assert run("export", [f"run={tmp_path}", f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    assert "which says the unit" in capsys.readouterr().err


@pytest.mark.slow
def test_recordings_are_sought_from_where_the_training_was_given(trained, tmp_path, monkeypatch) -> None:
    """Files of the same names in the folder of the export are others'."""
    monkeypatch.chdir(trained.parent)
    line = ["model=polynomial", "model.features=[temperature,output]", "data.files=[chamber.csv]", "data.average_s=100"]
    assert run("train", [*line, f"hydra.run.dir={tmp_path / 'line'}"]) == 0
    monkeypatch.chdir(tmp_path)
    header, *rows = (trained.parent / "chamber.csv").read_text().splitlines()
    (tmp_path / "chamber.csv").write_text("\n".join([header, *rows[::2]]) + "\n")
    assert run("export", [f"run={tmp_path / 'line'}", "program=false", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    trained_on = json.loads((tmp_path / "out" / "metadata.json").read_text())["trained_on"]
    assert trained_on["sample_interval_s"] == pytest.approx([STEP_S, STEP_S])
    assert trained_on["recorded_as"]["output"] == {"column": "rate_dph", "unit": "°/h"}


def test_nothing_can_be_refused_where_no_ranges_are_known(trained, tmp_path, capsys) -> None:
    for name in ("model.yaml", "weights.pt", "metrics.json"):
        (tmp_path / name).write_bytes((trained / name).read_bytes())
    assert run("export", [f"run={tmp_path}", "refuse_outside=true", "program=false", f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    assert "no ranges.json there" in capsys.readouterr().err


def test_nothing_can_be_refused_by_a_rate_whose_range_an_older_training_did_not_keep(trained, tmp_path, capsys) -> None:
    for name in ("model.yaml", "weights.pt", "metrics.json"):
        (tmp_path / name).write_bytes((trained / name).read_bytes())
    ranges = json.loads((trained / "ranges.json").read_text())
    (tmp_path / "ranges.json").write_text(json.dumps({"temperature_c": ranges["temperature_c"]}))
    settings = [f"run={tmp_path}", "program=false", f"hydra.run.dir={tmp_path / 'out'}"]
    assert run("export", [*settings, "refuse_outside=true"]) == 2
    assert "ranges.json there has no range of temperature_rate" in capsys.readouterr().err
    assert run("export", settings) == 0
    assert json.loads((tmp_path / "out" / "metadata.json").read_text())["trained_range"]["temperature_rate"] is None


@pytest.mark.slow
def test_what_a_hybrids_network_is_made_of_is_told_and_refused(trained, tmp_path) -> None:
    """The recordings are gone: the made-up run that the files are tried on lies within the trained rates, most of it."""
    settings = ["model=hybrid", "model.network=bp", "effects=[hysteresis]", "epochs=5", "data.files=[gone.csv]", "data.average_s=100"]
    with chdir(tmp_path):
        shutil.copy(trained.parent / "chamber.csv", "gone.csv")
        assert run("train", [*settings, "hydra.run.dir=hybrid"]) == 0
        Path("gone.csv").unlink()
        assert run("export", ["run=hybrid", "refuse_outside=true", "program=false", "hydra.run.dir=out"]) == 0
    metadata = json.loads((tmp_path / "out" / "metadata.json").read_text())
    assert metadata["features"]["temperature_rate"]["tau_s"] > 0
    low, high = metadata["trained_range"]["temperature_rate"]
    assert -0.61 < low < -0.5 < 0.5 < high < 0.61  # 30 K over 3000 s
    assert list(metadata["parity"]["runs"]) == ["a made-up run"]
    assert set(metadata["parity"]["largest_difference"]) == {"model.ts forward and the model", "model.ts step and forward"}
    script = torch.jit.load(tmp_path / "out" / "model.ts")
    time = torch.arange(0, 1000, 10.0, dtype=torch.float64)
    steep = torch.stack([time, 20 + (time - 500).clamp(0) / 30], dim=1)  # 2 K/min
    silent = script(steep).isnan()
    assert not silent[:51].any()
    assert silent[70:].all()


@pytest.mark.slow
def test_a_time_that_is_a_feature_has_a_range(trained, tmp_path) -> None:
    files = [f"data.files=[{trained.parent / 'chamber.csv'}]", "data.average_s=100"]
    assert run("train", ["model=polynomial", "model.features=[temperature,time_s]", *files, f"hydra.run.dir={tmp_path / 'timed'}"]) == 0
    assert run("export", [f"run={tmp_path / 'timed'}", "program=false", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    low, high = json.loads((tmp_path / "out" / "metadata.json").read_text())["trained_range"]["time_s"]
    assert 0 <= low < 200 < 4 * 3600 - 200 < high <= 4 * 3600
    script = torch.jit.load(tmp_path / "out" / "model.ts")
    inside = [script.step_checked(torch.tensor([time, 20.0], dtype=torch.float64))[1].tolist() for time in (1000.0, 1.7e9)]
    assert inside == [[True, True], [False, True]]


@pytest.mark.slow
def test_recordings_are_found_for_a_run_named_from_elsewhere(trained, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(trained.parent.parent)
    asked = [f"run={trained.parent.name}/out", "program=false", f"hydra.run.dir={tmp_path / 'out'}"]
    assert run("export", asked) == 0
    assert list(json.loads((tmp_path / "out" / "metadata.json").read_text())["trained_on"]["recorded_as"]) == ["time_s", "temperature_c", "output"]
