"""What runs must have before an effect is fitted to them."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from zoo.catalog import build, names
from zoo.diagnosis.preparation import check_swing
from zoo.errors import InputError

TIMELESS = {"warm_up", "aging", "bias_step", "supply_voltage", "chamber_cycling", "dead_band"}
"""Effects of time and of recorded inputs."""


def still(run):
    """The run with its thermometers held at 20 °C."""
    table = run.table.clone()
    for name in run.thermometers:
        table[:, run.columns.index(name)] = 20.0
    return replace(run, table=table)


@pytest.mark.parametrize("name", names("effects"))
def test_effects_of_temperature_need_a_swing_and_no_others_do(runs, name) -> None:
    held, effect = [still(run) for run in runs()], {name: build("effects", name)}
    if name in TIMELESS:
        check_swing(held, effect)
        return
    with pytest.raises(InputError, match=rf"constant \(20.00 to 20.00 °C\).*\({name}\)"):
        check_swing(held, effect)


def test_a_short_run_is_refused_whatever_the_effect(runs) -> None:
    run = runs()[0]
    short = replace(run, block=torch.where(run.block < 30, run.block, -1))
    with pytest.raises(InputError, match="30 block means"):
        check_swing([short], {"aging": build("effects", "aging")})
