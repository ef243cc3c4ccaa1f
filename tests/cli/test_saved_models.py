"""What a folder tells of the model in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from zoo.cli.saved_models import load_saved, physical_values, tops
from zoo.comparison.facts import fitted_runs, uncompensated_rms
from zoo.errors import InputError


def test_what_train_and_refine_tell_is_read_alike() -> None:
    trained = {"runs": [{"run": "run_1", "rms": 0.1}, {"run": "run_2", "rms": 0.2}], "parameters": 37}
    refined = {"runs": ["run_1", "run_2"], "parameters": {"mohr": {"coefficient": {"value": 0.1}}}}
    assert fitted_runs(trained) == fitted_runs(refined) == ["run_1", "run_2"]
    assert uncompensated_rms(trained | {"runs": [{"run": "run_1", "uncompensated": 0.2}]}) == {"run_1": 0.2}
    assert uncompensated_rms(refined | {"uncompensated_by_run": {"run_1": 0.2}}) == {"run_1": 0.2}
    assert uncompensated_rms(trained) == {}
    assert physical_values(trained) is None, "a count of weights is no value of an effect"
    assert physical_values(trained | {"physical": refined["parameters"]}) == physical_values(refined) == refined["parameters"]


def test_a_damaged_result_is_told_with_its_file(tmp_path: Path) -> None:
    (tmp_path / "metrics.json").write_text('{"seed": 1, "run', encoding="utf-8")
    with pytest.raises(InputError, match=r"metrics\.json: damaged"):
        load_saved(tmp_path)


def test_a_folder_is_the_one_of_its_name_though_that_may_be_read_as_a_pattern(tmp_path) -> None:
    for name in ("m1", "m[1]"):
        (tmp_path / name).mkdir()
    assert tops(str(tmp_path / "m[1]")) == [tmp_path / "m[1]"]
    assert tops(str(tmp_path / "m[0-9]")) == [tmp_path / "m1"]
