"""An inertial unit on a table: attitude from three accelerometers, and what the models of one power-on leave of the next."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.simulator.accelerometer.alignment import AXES, TABLE_ARCSEC, Alignment, simulate_alignment
from zoo.simulator.accelerometer.preset import accelerometer
from zoo.simulator.accelerometer.runs import PowerOnRun

SILENT = accelerometer(random_walk=0.0, count_step=0.0, thermometer=0.0, repeatability=0.0)
Model = Callable[[PowerOnRun, PowerOnRun], Tensor]


def error(one: PowerOnRun) -> Tensor:
    return one.table["pulses"] - one.table["reference_pulses"]


def line(known: PowerOnRun, new: PowerOnRun) -> Tensor:
    """(T,) error of a new power-on by the line fitted to a known one."""
    powers = [torch.stack([torch.ones_like(one.table["time_s"]), one.table["temperature_c"] + 40], 1) for one in (known, new)]
    return powers[1] @ torch.linalg.lstsq(powers[0], error(known).unsqueeze(1), driver="gelsd").solution.squeeze(1)


def perfect(known: PowerOnRun, new: PowerOnRun) -> Tensor:
    """(T,) error of a new power-on by a model that knows every point of a known one: both have the same temperatures."""
    assert torch.allclose(known.table["temperature_c"], new.table["temperature_c"], atol=1e-4)
    return error(known)


def rotation(one: PowerOnRun) -> Tensor:
    """(T,) what the accelerometer rightly shows because the table is not where it is set to."""
    return one.truth["fixture_rotation_pulses"]


def left(done: Alignment, model: Model) -> tuple[Tensor, Tensor]:
    """What a model of run 1 leaves in the check: (3, T) of the accelerometers by themselves [pulses], (2, T) of pitch and roll [°]."""
    known, new = done.recorded("run_1"), done.recorded()
    predicted = {axis: model(known[axis], new[axis]) for axis in AXES}
    angles = torch.stack(done.attitude(predicted)) - torch.tensor([[done.pitch_deg], [done.roll_deg]])
    tables = {axis: rotation(new[axis]) - rotation(known[axis]) for axis in AXES}
    return torch.stack([error(new[axis]) - predicted[axis] - tables[axis] for axis in AXES]), angles


def rms(parts: list[Tensor]) -> float:
    return float(torch.stack(parts).square().mean().sqrt())


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (12.0, -70.0), (-80.0, 170.0)])
def test_with_the_true_error_taken_off_the_attitude_is_exact(pitch: float, roll: float) -> None:
    done = simulate_alignment(SILENT, pitch, roll)
    off = {axis: one.truth["sum_pulses"] - one.truth["fixture_rotation_pulses"] for axis, one in done.recorded().items()}
    found = done.attitude(off)
    for angle, true in zip(found, done.set_deg["check"], strict=True):
        assert torch.allclose(angle, torch.full_like(angle, true), rtol=0, atol=1e-9)


def test_the_table_is_set_anew_at_every_power_on_to_a_few_arcseconds() -> None:
    done = simulate_alignment(runs=200)
    angles = torch.tensor(list(done.set_deg.values()))
    assert torch.allclose(angles.std(0), torch.full((2,), TABLE_ARCSEC / 3600), rtol=0.15)


def test_the_check_of_the_paper() -> None:
    """A perfect model leaves about 27 % of the line's error of the accelerometers, 40 % of that of the attitude."""
    runs = [simulate_alignment(seed=seed) for seed in range(150)]
    lines, networks = ([left(done, model) for done in runs] for model in (line, perfect))
    level = [AXES.index("east"), AXES.index("north")]
    assert rms([one[0][level] for one in networks]) / rms([one[0][level] for one in lines]) == pytest.approx(0.27, abs=0.04)
    assert rms([one[1] for one in networks]) / rms([one[1] for one in lines]) == pytest.approx(0.40, abs=0.05)
    assert all(float(one[1].abs().max()) > 0.005 for one in lines)
    assert sum(float(one[1].abs().max()) > 0.005 for one in networks) <= 0.1 * len(networks)


def test_the_seed_reproduces() -> None:
    first, again, other = (simulate_alignment(seed=seed).recorded() for seed in (1, 1, 2))
    for axis in AXES:
        assert torch.equal(first[axis].table["pulses"], again[axis].table["pulses"])
        assert not torch.equal(first[axis].table["pulses"], other[axis].table["pulses"])
    assert not torch.equal(error(first["east"]), error(first["north"]))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"pitch_deg": 91.0}, "pitch_deg=91"),
        ({"roll_deg": "level"}, "roll_deg=level"),
        ({"table_arcsec": -1.0}, "table_arcsec=-1"),
        ({"force_g": 1.0}, "force_g=1.0: pitch_deg and roll_deg"),
        ({"runs": 0}, "runs=0"),
    ],
)
def test_absurd_settings_are_refused(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        simulate_alignment(**settings)
