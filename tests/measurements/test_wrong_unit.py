"""An output in another unit than it is taken for is told, and nothing that is in order."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from zoo.measurements.read import read_runs
from zoo.measurements.schema import layout
from zoo.measurements.write import write_measurements
from zoo.measurements.wrong_unit import mistaken_unit
from zoo.units import convert, suffixes, symbol

RATES = suffixes("rate")
ROWS = np.arange(400.0)
TRUTHS = {"rest": np.full(400, 9.66), "table": convert(100 * np.sin(ROWS / 20), "dps", "dph"), "backwards": np.full(400, -9.66)}
"""True inputs [°/h]; that of a rate table has no mean."""


def doubts(taken: str, truth_dph: np.ndarray, output: np.ndarray, recorded: str = "dph") -> list[str]:
    """What is said of an output whose column says the unit `taken`, beside a true input whose column says `recorded`."""
    one = layout(Path("run.csv"), ("time_s", "temperature_c", f"rate_{taken}", f"reference_{recorded}"))
    truth = convert(truth_dph, recorded, taken)
    return mistaken_unit(one, truth, output - truth)


def noise(truth: np.ndarray, share: float, seed: int = 1) -> np.ndarray:
    return share * np.sqrt(np.mean(truth**2)) * np.random.default_rng(seed).normal(size=len(truth))


@pytest.mark.parametrize("program", TRUTHS)
@pytest.mark.parametrize(("taken", "true"), list(itertools.permutations(RATES, 2)))
def test_an_output_in_another_unit_is_told_and_which(program: str, taken: str, true: str) -> None:
    truth = TRUTHS[program]
    (note,) = doubts(taken, truth, convert(0.98 * truth + noise(truth, 0.1), "dph", true))
    assert f"is rate_{taken} in {symbol(true)} (a name that ends in _{true} says so)" in note
    factor = convert(1.0, taken, true)
    assert f" is about {factor:.0f} × " in note if factor > 1 else f" is about 1/{1 / factor:.0f} × " in note


@pytest.mark.parametrize(("taken", "true"), list(itertools.permutations(RATES, 2)))
def test_so_is_a_true_input_in_another_unit(taken: str, true: str) -> None:
    written = convert(TRUTHS["table"], "dph", true)
    (note,) = doubts("dph", written, TRUTHS["table"], recorded=taken)
    assert f"reference_{taken} in {symbol(true)} (a name that ends in _{true} says so)" in note


@pytest.mark.parametrize("program", TRUTHS)
@pytest.mark.parametrize("unit", RATES)
@pytest.mark.parametrize("share", [0.0, 0.1, 10.0, 3600.0])
def test_an_output_in_its_unit_is_not_told(program: str, unit: str, share: float) -> None:
    truth = TRUTHS[program]
    assert not doubts(unit, truth, convert(truth + noise(truth, share), "dph", unit)), "however noisy"
    assert not doubts(unit, truth, convert(truth * (1 + share), "dph", unit) if share != 3600.0 else convert(noise(truth, 1.0), "dph", unit))


def test_a_bias_beside_a_true_input_of_about_zero_is_none() -> None:
    for level in (0.0, 1e-5, 0.002):
        assert not doubts("dph", np.full(400, level), np.full(400, 3600 * level))
    encoder = noise(np.full(400, 1.0), 1.0)
    assert not doubts("dph", encoder, np.full(400, 3600 * encoder.mean())), "the output does not follow it"


def test_only_a_recorded_true_input_of_a_rate_tells(tmp_path: Path) -> None:
    data = {"time_s": ROWS, "temperature_c": 20 + ROWS / 100, "rate_dps": 9.6 + 0.001 * np.sin(ROWS)}
    assert not read_runs(write_measurements(tmp_path / "a.csv", data), reference=convert(9.66, "dph", "dps"))[0].notes
    note = read_runs(write_measurements(tmp_path / "b.csv", data | {"reference_dph": np.full(400, 9.66)}))[0].notes[-1]
    assert note.startswith("rate_dps is about 3600 × reference_dph: is rate_dps in °/h (")
    mapped = {"gz": data.pop("rate_dps"), "reference_dph": np.full(400, 9.66)}
    path = write_measurements(tmp_path / "c.csv", data | mapped)
    assert "is gz in °/h (data.output_unit=dph), or" in read_runs(path, {"output": "gz"}, "deg/s")[0].notes[-1]
    assert not read_runs(path, {"output": "gz"}, "dph")[0].notes, "and then it is well"
    ug = {"accel_ug": mapped["gz"] * 1e3, "reference_ug": mapped["gz"]}
    assert not read_runs(write_measurements(tmp_path / "d.csv", data | ug))[0].notes
