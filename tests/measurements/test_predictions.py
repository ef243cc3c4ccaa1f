"""Predictions made elsewhere on the blocks of the run that they are for."""

from pathlib import Path

import numpy as np
import pytest
import torch

from zoo.errors import InputError
from zoo.measurements.predictions import read_prediction
from zoo.measurements.read import read_runs
from zoo.measurements.run import Run
from zoo.measurements.write import write_measurements

STEP, COUNT = 2.0, 3000


def curve(time: np.ndarray) -> np.ndarray:
    return 0.1 * np.sin(time / 700) + 1e-5 * time


@pytest.fixture
def time() -> np.ndarray:
    clock = 17.0 + STEP * np.arange(COUNT)
    clock[1800:] += 500.0  # a gap
    return clock


@pytest.fixture
def run(tmp_path, time) -> Run:
    noise = np.random.default_rng(1).standard_normal(COUNT)
    write_measurements(tmp_path / "a.csv", {"time_s": time, "temperature_c": 20 + time / 300, "rate_dph": curve(time) + 0.01 * noise})
    return read_runs(tmp_path / "a.csv", average_s=100)[0]


def written(folder: Path, time: np.ndarray, **columns: np.ndarray) -> Path:
    return write_measurements(folder / "pred.csv", {"time_s": time, **columns})


def test_the_run_s_own_rows_are_averaged_in_its_blocks(tmp_path, run, time) -> None:
    rough = curve(time) + np.random.default_rng(2).standard_normal(COUNT)  # as a map of a noisy thermometer is
    write_measurements(tmp_path / "b.csv", {"time_s": time, "temperature_c": time, "rate_dph": rough})
    expected = read_runs(tmp_path / "b.csv", average_s=100)[0]
    found = read_prediction(written(tmp_path, time, predicted_error_dph=rough), run)
    torch.testing.assert_close(found, expected.block_mean(expected.error), rtol=0, atol=0)


def test_a_clock_called_as_in_the_runs_has_their_unit(tmp_path, run, time) -> None:
    path = write_measurements(tmp_path / "pred.csv", {"t": 1000.0 * time, "predicted_error_dph": curve(time)})
    found = read_prediction(path, run, time="t", time_unit="ms")
    torch.testing.assert_close(found, read_prediction(written(tmp_path, time, predicted_error_dph=curve(time)), run, time="t", time_unit="ms"))


def test_held_out_pieces_get_their_own_blocks(tmp_path, run, time) -> None:
    path = written(tmp_path, time, predicted_error_dph=curve(time))
    early, late = run.split(0.3)
    whole, parts = read_prediction(path, run), [read_prediction(path, part) for part in (early, late)]
    assert sum(len(part) for part in parts) == len(whole)
    torch.testing.assert_close(torch.cat(parts).sort().values, whole.sort().values, rtol=0, atol=0)


@pytest.mark.parametrize(("step", "bound"), [(0.5, 3e-5), (10.0, 3e-5), (100.0, 1e-3)])
def test_another_clock_is_interpolated(tmp_path, run, time, step: float, bound: float) -> None:
    """100 s means of sin(t/700): linear interpolation errs by at most (h/700)²/8 of its size, 0.0026 of 0.1."""
    clock = np.arange(time[0] - 30, time[-1] + step, step)
    found = read_prediction(written(tmp_path, clock, predicted_error_dph=curve(clock)), run)
    torch.testing.assert_close(found, run.block_mean(torch.from_numpy(curve(run.time.numpy()))), rtol=0, atol=bound)


def test_another_unit_is_converted(tmp_path, run, time) -> None:
    found = read_prediction(written(tmp_path, time, predicted_error_dps=curve(time) / 3600), run)
    torch.testing.assert_close(found, read_prediction(written(tmp_path, time, predicted_error_dph=curve(time)), run))


def test_the_data_s_own_name_of_the_time_is_taken(tmp_path, run, time) -> None:
    path = write_measurements(tmp_path / "pred.csv", {"t": time, "predicted_error_dph": curve(time)})
    assert read_prediction(path, run, time="t").shape == (run.blocks,)
    with pytest.raises(InputError, match="time_s"):
        read_prediction(path, run)


@pytest.mark.parametrize(
    ("part", "words"),
    [(slice(0, 1000), "reaches from 26.3 to 2006.3 s"), (slice(1000, None), "the run a"), ([*range(1000), *range(1500, 3000)], "no prediction at")],
)
def test_what_does_not_reach_over_the_run_is_refused(tmp_path, run, time, part, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_prediction(written(tmp_path, time[part] + 0.3, predicted_error_dph=curve(time[part])), run)


def test_a_file_without_a_prediction_is_refused(tmp_path, run, time) -> None:
    with pytest.raises(InputError, match="predicted_error_dph"):
        read_prediction(written(tmp_path, time, prediction=curve(time)), run)
