"""Models are called by what tells them apart, and by nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import torch

from zoo.comparison.entrant import Entrant
from zoo.comparison.naming import distinct_names
from zoo.measurements.run import Run

STARTS = ("random", "pso", "aco")


def predict(run: Run, device: torch.device) -> torch.Tensor:
    raise NotImplementedError


def model(kind: str, init: str | None = None, seed: int | None = 1, **facts: Any) -> Entrant:
    known = {"init": init, "seed": seed, "optimizer": "adam" if init else "least_squares"}
    return Entrant(kind, kind, Path(), known | facts, {}, predict)


def refined(*added: str) -> Entrant:
    ladder = [{"added": name} for name in (None, *added)]
    return Entrant("graybox", "graybox", Path(), {"ladder": ladder}, {}, predict)


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
def test_names(models: list[Entrant], names: list[str]) -> None:
    assert distinct_names(models, STARTS) == names
