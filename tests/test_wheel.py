"""An installed wheel works from any directory, configs and templates included."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    pytest.importorskip("hatchling", reason="the build backend is not here; make install brings it")
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-qq"]
    subprocess.run([*pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", folder, ROOT], check=True)
    (built,) = folder.glob("*.whl")
    subprocess.run([*pip, "install", "--no-deps", "--no-index", "--target", folder / "site", built], check=True)
    return built


@pytest.mark.slow
def test_the_wheel_holds_all_that_is_no_python(wheel) -> None:
    inside = set(zipfile.ZipFile(wheel).namelist())
    configs = {f"zoo/{path.relative_to(ROOT)}" for path in (ROOT / "conf").rglob("*.yaml")}
    assert configs
    assert configs <= inside
    others = {path.relative_to(ROOT).as_posix() for path in (ROOT / "zoo").rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    assert others <= inside
    assert not [name for name in inside if name.startswith(("tests/", "scripts/", "conf/"))]
    assert any(name.endswith("licenses/LICENSE") for name in inside)


@pytest.mark.slow
def test_the_installed_command_finds_its_configs_from_anywhere(wheel, tmp_path) -> None:
    site = wheel.parent / "site"
    environment = os.environ | {"PYTHONPATH": str(site), "PYTHONDONTWRITEBYTECODE": "1"}

    def printed(*command: str) -> str:
        return subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True, text=True).stdout

    assert Path(printed(sys.executable, "-c", "import zoo; print(zoo.__file__)").strip()).is_relative_to(site)
    shown = printed(sys.executable, str(site / "bin" / "fogzoo"), "simulate", "--cfg", "job")
    assert "_target_: zoo.simulator" in shown
    made = printed(sys.executable, str(site / "bin" / "fogzoo"), "simulate", "runs=1", "profile=cycle", "sample_s=60", "hydra.run.dir=out")
    assert Path(made.splitlines()[-1]) == tmp_path / "out"
    assert (tmp_path / "out" / "run_1.csv").is_file()
