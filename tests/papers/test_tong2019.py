"""Means and spreads beside the paper's, and what is claimed of them."""

from __future__ import annotations

import pytest
import torch

from zoo.measurements.run import Run
from zoo.papers import tong2019
from zoo.papers.study import Study
from zoo.scoring.comparison import UNCOMPENSATED

BLOCKS, NOISE = 360, 0.007


def ramp(name: str, seed: int) -> Run:
    """A run from −15 to 50 °C whose error is −0.07 °/h, a wave, and noise."""
    time = 100.0 * torch.arange(BLOCKS, dtype=torch.float64) + 50.0
    temperature = torch.linspace(-15, 50, BLOCKS, dtype=torch.float64)
    noise = NOISE * torch.randn(BLOCKS, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    error = -0.07 + 0.02 * torch.sin(temperature / 10) + noise
    table = torch.stack([time, temperature, torch.zeros_like(time)], 1)
    one = torch.ones(BLOCKS, dtype=torch.int64)
    return Run(name, "dph", 100.0, ("time_s", "temperature_c", "reference_dph"), table, error, one, torch.arange(BLOCKS), BLOCKS)


def study(kept: dict[str, tuple[float, float, float]]) -> Study:
    """What a method leaves: a mean [°/h], and shares of the error's own swing on the fitted and the check run."""
    runs = [ramp("run_1", 1), ramp("check", 2)]
    errors = [run.block_mean(run.error) for run in runs]
    predicted = {}
    for name, (mean, *shares) in kept.items():
        left = [mean + share * (error - error.mean()) for share, error in zip(shares, errors, strict=True)]
        predicted[name] = [(error - one).unsqueeze(0) for error, one in zip(errors, left, strict=True)]
    return Study.of(runs, 1, predicted)


AS_PRINTED = {"T alone": (1e-4, 0.5, 0.5), "PSO": (-2e-5, 0.48, 0.48), "continuous": (0.0, 0.4, 0.4)}


def holds(kept: dict[str, tuple[float, float, float]], floor: float) -> list[bool]:
    return [claim.holds for claim in tong2019.claims(study(kept), [floor, floor])]


def test_the_table_has_the_printed_values_beside_those_of_the_fitted_run_only() -> None:
    found = {(one.quantity, one.sample, one.model): one for one in tong2019.rows(study(AS_PRINTED))}
    assert len(found) == 2 * 2 * 4
    assert found["mean", "run_1", "PSO"].paper == -2.9621e-5
    assert found["mean", "run_1", "PSO"].ours == pytest.approx(-2e-5)
    assert found["standard deviation", "check", "PSO"].paper is None
    before = found["standard deviation", "run_1", UNCOMPENSATED].ours
    assert found["standard deviation", "run_1", "T alone"].ours == pytest.approx(0.5 * before)


def test_residuals_as_printed_bear_out_every_claim() -> None:
    spread = float(study(AS_PRINTED).left[UNCOMPENSATED][0].std())
    assert holds(AS_PRINTED, 0.4 * spread) == [True] * 7


def test_what_is_not_so_is_told() -> None:
    spread = float(study(AS_PRINTED).left[UNCOMPENSATED][0].std())
    exact = AS_PRINTED | {"T alone": (0.0, 0.5, 0.5)}
    assert holds(exact, 0.4 * spread) == [True, True, False, True, True, True, True]
    exploding = AS_PRINTED | {"PSO": (-2e-5, 0.48, 300.0)}
    assert holds(exploding, 0.4 * spread) == [True, True, True, True, True, False, True]
    assert "300 times" in tong2019.claims(study(exploding), [spread, spread])[5].value
    assert holds(AS_PRINTED, 0.6 * spread)[4] is False  # less than the noise is left: fitted noise
    assert holds(AS_PRINTED, 0.3 * spread)[6] is False
