"""Models are called by what tells them apart, and by nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from zoo.cli.saved_models import SavedModel, distinct_names, fitted_runs, load_saved, physical_values, uncompensated_rms
from zoo.errors import InputError


def model(kind: str, init: str | None = None, seed: int | None = 1, **facts: Any) -> SavedModel:
    known = {"init": init, "seed": seed, "optimizer": "adam" if init else "least_squares"}
    return SavedModel(kind, Path(), None, known | facts)  # type: ignore[arg-type]


def refined(*added: str) -> SavedModel:
    ladder = [{"added": name} for name in (None, *added)]
    return SavedModel("graybox", Path(), None, {"ladder": ladder})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("models", "names"),
    [
        ([model("polynomial"), model("bp", "pso"), model("graybox")], ["polynomial", "bp", "graybox"]),
        ([model("bp", "pso", 1), model("bp", "pso", 2)], ["bp_seed1", "bp_seed2"]),
        ([model("bp", "pso"), model("bp", "random")], ["bp_pso", "bp_random"]),
        ([model("bp", "pso", 1), model("bp", "random", 1), model("bp", "random", 2)], ["bp_pso", "bp_random_seed1", "bp_random_seed2"]),
        ([model("bp", "pso"), model("bp", "pso", optimizer="lbfgs")], ["bp_adam", "bp_lbfgs"]),
        ([model("bp", "pso"), model("bp", "random"), model("bp", "random", optimizer="lbfgs")], ["bp_pso_adam", "bp_random_adam", "bp_random_lbfgs"]),
        ([model("bp", "pso"), model("bp", optimizer="pso"), model("bp", optimizer="aco")], ["bp_pso", "bp_by_pso", "bp_by_aco"]),
        ([model("polynomial", None, 1), model("polynomial", None, 2)], ["polynomial", "polynomial_2"]),  # solved: no seed decides anything
        ([model("graybox"), refined("aging")], ["graybox", "graybox_refined"]),
        ([refined("aging")], ["graybox"]),
        ([refined("aging"), refined("aging", "mohr")], ["graybox_aging", "graybox_aging_mohr"]),
        ([model("graybox"), refined("aging"), refined("mohr")], ["graybox", "graybox_refined_aging", "graybox_refined_mohr"]),
        ([model("whole"), model("run"), model("run")], ["whole", "run_2", "run_3"]),  # a column of the table is called run
        ([model("m"), model("m_2"), model("m")], ["m", "m_2", "m_3"]),
    ],
)
def test_names(models: list[SavedModel], names: list[str]) -> None:
    assert distinct_names(models) == names


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
