"""The folder that `export` leaves: whole, in agreement with the model, and without a word about this machine."""

from __future__ import annotations

import hashlib
import io
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
import torch

import zoo
from zoo.errors import WorkError
from zoo.export.program import SCANS
from zoo.export.write import input_unit, write_export
from zoo.models.bp import BP

RANGES = {"temperature_c": (-30.0, 55.0), "temperature_outer_c": (-35.0, 60.0), "supply_v": (4.9, 5.1), "reference_dph": (0.0, 0.0)}
ALONE = """
import sys
sys.modules["zoo"] = None  # whatever is installed: every import of it fails
import torch
try:
    import zoo.models
except ModuleNotFoundError:
    pass
else:
    sys.exit("zoo is here")
x = torch.load("x.pt")
model, program = torch.jit.load("model.ts"), torch.export.load("model.pt2").module()
found = {"forward": model(x), "step": torch.stack([model.step(row) for row in x]), "program": program(x), "inputs": list(model.inputs)}
torch.save(found, "found.pt")
"""


def write(model, out: Path, ranges=RANGES, **more):
    return write_export(model, "dph", ranges, {}, out, about={"schema_version": 1, "model": "one"}, **more)


@pytest.fixture(scope="module")
def folders(tmp_path_factory, network, graybox):
    """A network and a grey box, exported, with the models."""
    if not SCANS:
        pytest.skip("this torch writes no loops down")
    models = {"network": network("bp"), "grey box": graybox(["static_bias", "hysteresis", "mohr"], more=("supply_v",))}
    found = {name: (model, tmp_path_factory.mktemp("export")) for name, model in models.items()}
    for model, out in found.values():
        write(model, out)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", ["network", "grey box"])
def test_a_python_with_torch_alone_runs_it(folders, record, name) -> None:
    model, out = folders[name]
    full = record(model.inputs, 400)
    x = full[:, [model.inputs.index(one) for one in json.loads((out / "metadata.json").read_text())["inputs"]]]
    torch.save(x, out / "x.pt")
    subprocess.run([sys.executable, "-I", "-c", ALONE], cwd=out, check=True)
    found = torch.load(out / "found.pt")
    with torch.no_grad():
        wanted = model(full)
    for way in ("forward", "step", "program"):
        torch.testing.assert_close(found[way], wanted, rtol=0, atol=1e-11 * float(wanted.abs().max()))
    assert found["inputs"][0] == "time_s"


@pytest.mark.slow
def test_the_metadata_say_what_the_files_are(folders) -> None:
    _, out = folders["grey box"]
    metadata = json.loads((out / "metadata.json").read_text())
    assert metadata["inputs"] == ["time_s", "temperature_c"]
    assert metadata["input_units"] == {"time_s": "s", "temperature_c": "°C"}
    assert metadata["trained_range"] == {"time_s": None, "temperature_c": [-30, 55], "temperature_rate": None}
    assert metadata["inputs_without_influence"] == ["supply_v", "reference_dph"]
    assert (metadata["unit"], metadata["unit_symbol"], metadata["refuse_outside"]) == ("dph", "°/h", False)
    assert all(0 <= apart < 1e-9 for apart in metadata["parity"]["largest_difference"].values())
    assert set(metadata["files"]) == {"model.ts", "model.pt2", "step.pt2"}
    for name, file in metadata["files"].items():
        assert hashlib.sha256((out / name).read_bytes()).hexdigest() == file["sha256"]


@pytest.mark.slow
def test_no_folder_of_this_machine_is_in_the_files(folders) -> None:
    here = [str(Path(zoo.__file__).parent.parent).encode(), str(Path(torch.__file__).parent).encode(), str(Path.home()).encode() + b"/"]
    for _, out in folders.values():
        for name in ("model.ts", "model.pt2", "step.pt2"):
            with zipfile.ZipFile(io.BytesIO((out / name).read_bytes())) as archive:
                for record in archive.namelist():
                    assert not any(place in archive.read(record) for place in here), f"{name}: {record}"


class Tampered(BP):
    """Makes more of its features than their names say, so that what is exported is another model."""

    def features(self, x: torch.Tensor) -> torch.Tensor:
        features: torch.Tensor = self.extract(x)
        return features + 1e-6 * torch.arange(x.shape[0]).unsqueeze(-1)


class Wide(BP):
    """One number a row of many, and a list of one of a row alone."""

    def head(self, features: torch.Tensor) -> torch.Tensor:
        return self.scaler.restore(self.output.bias * self.scaler(features)[..., 0])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "words"), [(Tampered, r"differ by .* nothing was written"), (Wide, r"one row of features \(F,\) must give one number")]
)
def test_files_that_say_something_else_are_not_written(network, tmp_path, kind, words) -> None:
    model = kind(["temperature", "temperature_rate"])
    model.load_state_dict(network("bp").state_dict())
    with pytest.raises(WorkError, match=rf"model\.ts step and forward.*{words}"):
        write(model, tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("column", "unit"),
    [("time_s", "s"), ("temperature_outer_c", "°C"), ("reference_rad_per_s", "rad/s"), ("field_ut", "µT"), ("humidity_pct", "%"), ("airflow", None)],
)
def test_units_of_columns(column, unit) -> None:
    assert input_unit(column) == unit
