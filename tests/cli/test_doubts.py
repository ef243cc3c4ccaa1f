"""What is said of a model that has just been trained."""

from __future__ import annotations

import pytest
import torch

from zoo.catalog import build
from zoo.cli.doubts import print_doubts
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid

INPUTS = ["time_s", "temperature_c", "temperature_outer_c", "reference_dph"]
METRICS = {"epochs": None, "parameters": 20, "optimizer": "alternating", "unit": "dph", "beyond": {}, "rms": 0.1, "rms_uncompensated": 1.0}
METRICS |= {"rms_check": None, "rms_check_uncompensated": None}


def recorded() -> Run:
    time = torch.arange(100, dtype=torch.float64)
    table = torch.stack([time, 20 + time, 20 + time, 9.0 + 0.01 * time], dim=-1)
    return Run("run", "dph", 1.0, tuple(INPUTS), table, 0 * time, torch.ones(100, dtype=torch.int64), torch.arange(100))


def told(model: Model, capsys: pytest.CaptureFixture[str]) -> str:
    print_doubts(model, [recorded()], METRICS)
    return " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("width", "said"), [(0.5, "hysteresis.width = 0.500 K: at the end"), (7.5, ""), (20.0, "hysteresis.width = 20.0 K: at the end")]
)
def test_an_effect_beside_a_network_that_runs_to_the_end_of_what_is_possible_is_told(width, said, capsys) -> None:
    effect = build("effects", "hysteresis")
    place = [one.name for one in effect.shape].index("width")
    assert (effect.shape[place].low, effect.shape[place].high) == (0.5, 20.0)
    hybrid = Hybrid(build("model", "polynomial"), {"hysteresis": effect}, INPUTS)
    hybrid.physics.coil_value.data[1] = 0.0  # a weight of nothing is none of the effect's
    dict(hybrid.physics.named_effects())["hysteresis"].shape_value.data[place] = width
    found = told(hybrid, capsys)
    assert found.startswith(said)
    assert bool(found) is bool(said)
    alone = GrayBox({"hysteresis": build("effects", "hysteresis")}, INPUTS)
    dict(alone.named_effects())["hysteresis"].shape_value.data[place] = width
    assert told(alone, capsys) == "", "diagnose says what the runs do not determine"
