"""Figures beside a paper's: medians and bands over seeds, shares of the uncompensated error."""

from __future__ import annotations

import pytest
import torch

from zoo.errors import WorkError
from zoo.measurements.run import Run
from zoo.papers import qiu2023
from zoo.papers.study import Study, in_words, removed, row, seed_by_seed, spread
from zoo.scoring.comparison import UNCOMPENSATED

HOUR, RAMP = 36, 60  # blocks of 100 s in a hold of 1 h and in a ramp of 20 K at 0.2 K/min


def staircase(name: str, seed: int) -> Run:
    """A run over the paper's program whose error has a spread of 0.01 in holds and of 0.06 in ramps [°/h]."""
    chance = torch.Generator().manual_seed(seed)
    temperature, error = [], []
    for level in range(-40, 61, 20):
        if level > -40:
            temperature.append(torch.linspace(level - 20, level, RAMP + 1, dtype=torch.float64)[1:])
            error.append(0.06 * torch.randn(RAMP, generator=chance, dtype=torch.float64))
        temperature.append(torch.full((HOUR,), float(level), dtype=torch.float64))
        error.append(0.01 * torch.randn(HOUR, generator=chance, dtype=torch.float64))
    t, e = torch.cat(temperature), torch.cat(error)
    time = 100.0 * torch.arange(len(t), dtype=torch.float64) + 50.0
    table = torch.stack([time, t, torch.zeros_like(t)], 1)
    one = torch.ones(len(t), dtype=torch.int64)
    return Run(name, "dph", 100.0, ("time_s", "temperature_c", "reference_dph"), table, e, one, torch.arange(len(t)), len(t))


@pytest.fixture
def study() -> Study:
    runs = [staircase(f"run_{k}", k) for k in (1, 2, 3)]
    errors = [run.block_mean(run.error) for run in runs]
    kept = {"polynomial": [0.5], "BP": [0.2, 0.3, 0.4], "ACO-BP": [0.1, 0.2, 0.3], "ACO-BP by LM": [0.3]}
    predicted = {name: [torch.stack([(1 - share) * error for share in shares]) for error in errors] for name, shares in kept.items()}
    return Study.of(runs, 1, predicted)


def test_a_method_that_keeps_a_share_of_the_error_removes_the_rest(study: Study) -> None:
    assert removed(study, "BP", (1, 2)).tolist() == pytest.approx([0.8, 0.7, 0.6])
    assert in_words(removed(study, "polynomial", (1, 2))) == "50.0%"


def test_the_table_has_every_stage_of_every_sample_and_method_once_beside_the_printed_value(study: Study) -> None:
    rows = qiu2023.rows(study)
    assert len(rows) == 12 * 3 * 5 == len({(one.stage, one.sample, one.model) for one in rows})
    known = {(one.stage, one.sample, one.model): one for one in rows}
    assert known["-20→0", "3", "ACO-BP"].paper == 0.0078
    assert known["whole", "2", UNCOMPENSATED].paper == 0.0559
    assert known["whole", "1", "BP"].ours == pytest.approx(0.3 * known["whole", "1", UNCOMPENSATED].ours)
    assert known["whole", "1", "BP"].low == pytest.approx(0.21 * known["whole", "1", UNCOMPENSATED].ours)


def test_stages_are_the_papers_holds_and_ramps(study: Study) -> None:
    before = {one.stage: one.ours for one in qiu2023.rows(study) if one.model == UNCOMPENSATED and one.sample == "1" and one.stage != "whole"}
    assert len(before) == 6 + 5
    for stage, value in before.items():
        assert value == pytest.approx(0.06 if "→" in stage else 0.01, rel=0.35)


def test_what_is_claimed_follows_from_the_residuals(study: Study) -> None:
    floors = [float(0.1 * spread(one).mean()) for one in study.left[UNCOMPENSATED]]
    assert [claim.holds for claim in qiu2023.claims(study, floors)] == [True, True, False, True, True, False]


def test_a_row_is_the_median_of_the_seeds_and_the_band_that_holds_nine_in_ten() -> None:
    one = row(torch.arange(101, dtype=torch.float64), "x", "1", "whole", "1", "m", None)
    assert (one.ours, one.low, one.high) == pytest.approx((50.0, 5.0, 95.0))


def test_seeds_that_one_method_lost_are_left_out_of_all() -> None:
    """Ratios of two methods are taken seed by seed; what is solved has no seeds to lose."""

    def of(seeds: list[int], level: float) -> dict[int, list[torch.Tensor]]:
        return {seed: [torch.full((4,), level + seed), torch.full((2,), -level - seed)] for seed in seeds}

    found = seed_by_seed({"BP": of([1, 2, 4], 10.0), "ACO-BP": of([1, 3, 4], 20.0), "line": of([1], 0.5)})
    assert [[part.shape for part in each] for each in found.values()] == [[(2, 4), (2, 2)], [(2, 4), (2, 2)], [(1, 4), (1, 2)]]
    assert found["BP"][0][:, 0].tolist() == [11.0, 14.0]
    assert found["ACO-BP"][1][:, 0].tolist() == [-21.0, -24.0]
    with pytest.raises(WorkError, match="no seed"):
        seed_by_seed({"BP": of([1, 2], 10.0), "ACO-BP": of([3, 4], 20.0)})
