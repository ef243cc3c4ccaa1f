"""The exported file in a program without Python: thirty lines of C++ against the wheel's own LibTorch."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
import torch
from torch.utils import cpp_extension

from zoo.export.torchscript import to_torchscript
from zoo.models.example import example

COMPILER = shutil.which("g++")
HEADERS, LIBRARIES = cpp_extension.include_paths(), cpp_extension.library_paths()
HERE = all((Path(HEADERS[0]) / name).is_file() for name in ("torch/script.h", "ATen/ATen.h"))


@pytest.fixture(scope="module")
def program(tmp_path_factory) -> Path:
    if not COMPILER or not HERE:
        pytest.skip("g++ is missing" if not COMPILER else "this torch comes without the headers of LibTorch")
    out = tmp_path_factory.mktemp("cpp") / "step"
    abi = f"-D_GLIBCXX_USE_CXX11_ABI={int(torch._C._GLIBCXX_USE_CXX11_ABI)}"
    where = [*(f"-I{path}" for path in HEADERS), *(f"-L{path}" for path in LIBRARIES), *(f"-Wl,-rpath,{path}" for path in LIBRARIES)]
    source = Path(__file__).with_name("step.cpp")
    command = [COMPILER, "-std=c++20", "-O0", abi, *where, str(source), "-o", str(out), "-Wl,--no-as-needed", "-ltorch", "-ltorch_cpu", "-lc10"]
    subprocess.run(command, check=True)
    return out


@pytest.mark.slow
@torch.no_grad()
def test_it_says_the_same(program, network, graybox, record, tmp_path) -> None:
    for model in (network("bp"), graybox(["static_bias", "hysteresis"])):
        made_up, x = example(model.inputs, {}), record(model.inputs, 300)
        (tmp_path / "model.ts").write_bytes(to_torchscript(model, "dph", made_up, {}))
        rows = [",".join(f"{value!r}" for value in row) for row in x.tolist()]
        (tmp_path / "samples.csv").write_text("\n".join([",".join(model.inputs), *rows]) + "\n")
        said = subprocess.run([program, tmp_path / "model.ts", tmp_path / "samples.csv"], check=True, capture_output=True, text=True).stdout
        found = torch.tensor([float(line) for line in said.splitlines()], dtype=torch.float64)
        torch.testing.assert_close(found, model(x), rtol=0, atol=1e-11 * float(model(x).abs().max()))
