"""Stages: every block once, and cut where the chamber changed."""

import itertools

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from zoo.scoring import stages
from zoo.scoring.stages import KINDS, bias_stability, label_stages, local_rate, stage_mask, stage_names

RESOLUTION = 0.0625


def program(legs: list[tuple[float, float, float]], block_s: float) -> tuple[torch.Tensor, torch.Tensor]:
    """Chamber program [(from °C, to °C, seconds)] sampled at the blocks' centres."""
    ends = torch.tensor([0.0, *[seconds for _, _, seconds in legs]], dtype=torch.float64).cumsum(0)
    time = torch.arange(block_s / 2, float(ends[-1]), block_s, dtype=torch.float64)
    leg = (torch.searchsorted(ends, time, right=True) - 1).clamp(max=len(legs) - 1)
    share = (time - ends[leg]) / (ends[leg + 1] - ends[leg])
    table = torch.tensor(legs, dtype=torch.float64)
    return time, table[leg, 0] + share * (table[leg, 1] - table[leg, 0])


def without_edges(time: torch.Tensor, temperature: torch.Tensor) -> list[str]:
    return [stage.kind for stage in label_stages(time, temperature) if stage.kind != "edge"]


HOLD_RAMP_HOLD = [(20.0, 20.0, 3600.0), (20.0, 60.0, 4800.0), (60.0, 60.0, 3600.0)]


@pytest.mark.parametrize("block_s", [10.0, 100.0])
@pytest.mark.parametrize("disturbance", ["none", "resolution", "noise"])
def test_hold_ramp_hold_is_cut_where_it_changes(block_s: float, disturbance: str) -> None:
    time, temperature = program(HOLD_RAMP_HOLD, block_s)
    if disturbance == "resolution":
        temperature = (temperature / RESOLUTION).round() * RESOLUTION
    if disturbance == "noise":
        temperature = temperature + 0.02 * torch.randn(len(time), generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    stages = label_stages(time, temperature)
    assert [stage.kind for stage in stages] == ["hold", "edge", "heating", "edge", "hold"]
    for edge, change in zip(stages[1::2], (3600.0, 8400.0), strict=True):
        assert edge.from_s - block_s <= change <= edge.to_s + block_s
        assert abs((edge.from_s + edge.to_s) / 2 - change) <= max(block_s, 60)
        assert edge.to_s - edge.from_s <= 600


def test_a_drifting_quantised_hold_is_one_hold() -> None:
    time = torch.arange(5.0, 7200.0, 10.0, dtype=torch.float64)
    temperature = ((25.0 + 0.01 * time / 600) / RESOLUTION).round() * RESOLUTION
    assert [stage.kind for stage in label_stages(time, temperature)] == ["hold"]


def test_the_papers_program_has_its_eleven_stages() -> None:
    legs = [(-40.0, -40.0, 3600.0)]
    for level in (-40.0, -20.0, 0.0, 20.0, 40.0):
        legs += [(level, level + 20, 6000.0), (level + 20, level + 20, 3600.0)]
    assert without_edges(*program(legs, 100.0)) == ["hold"] + ["heating", "hold"] * 5


def test_cooling_into_heating_without_a_rest_has_an_edge_between_them() -> None:
    time, temperature = program([(50.0, -20.0, 1800.0), (-20.0, 70.0, 1800.0)], 10.0)
    assert [stage.kind for stage in label_stages(time, temperature)] == ["cooling", "edge", "heating"]


def test_a_lagging_thermometer_leaves_a_longer_edge_after_a_ramp() -> None:
    time, temperature = program(HOLD_RAMP_HOLD, 10.0)
    lagged = temperature.clone()
    for i in range(1, len(time)):
        lagged[i] = lagged[i - 1] + (temperature[i] - lagged[i - 1]) * 10 / 900
    stages = label_stages(time, lagged)
    assert [stage.kind for stage in stages] == ["hold", "edge", "heating", "edge", "hold"]
    sharp = label_stages(time, temperature)
    assert stages[3].to_s - stages[3].from_s > 2 * (sharp[3].to_s - sharp[3].from_s)
    assert stages[3].to_s - 8400 > 900  # where the rate has fallen to a quarter: 1.4 time constants after the ramp


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 300), st.sampled_from([1.0, 10.0, 100.0]), st.integers(0, 10**6), st.floats(0, 5))
def test_every_block_is_covered_once_whatever_the_run(total: int, block_s: float, seed: int, roughness: float) -> None:
    chance = torch.Generator().manual_seed(seed)
    time = block_s * (torch.arange(total, dtype=torch.float64) + torch.rand(total, generator=chance, dtype=torch.float64) * 0.5)
    temperature = roughness * torch.randn(total, generator=chance, dtype=torch.float64).cumsum(0)
    stages = label_stages(time, temperature)
    assert [index for stage in stages for index in range(stage.from_index, stage.to_index)] == list(range(total))
    assert all(stage.kind in KINDS for stage in stages)
    assert all(one.kind != two.kind for one, two in itertools.pairwise(stages))
    assert sum(int(stage_mask(stages, kind).sum()) for kind in KINDS) == total == len(stage_names(stages))


def test_the_local_rate_of_a_ramp_is_its_slope_also_over_a_gap() -> None:
    time = torch.cat([torch.arange(0.0, 1000.0, 10.0), torch.arange(5000.0, 6000.0, 10.0)]).double()
    torch.testing.assert_close(local_rate(time, 0.5 * time / 60, 120.0), torch.full_like(time, 0.5))
    assert float(local_rate(torch.tensor([0.0, 1e6]).double(), torch.tensor([0.0, 9.0]).double(), 60.0).abs().max()) == 0


def test_bias_stability_is_the_sample_standard_deviation() -> None:
    assert bias_stability(torch.tensor([1.0, 2.0, 3.0, 4.0])) == pytest.approx((5 / 3) ** 0.5)
    assert bias_stability(torch.tensor([1.0])) == 0


def test_what_moves_below_the_floor_is_held_however_far_it_gets() -> None:
    time = torch.arange(50.0, 7200.0, 100.0, dtype=torch.float64)
    assert [stage.kind for stage in label_stages(time, 20 + 0.04 * time / 60)] == ["hold"]
    assert [stage.kind for stage in label_stages(time, 20 + 0.07 * time / 60)] == ["heating"]


def test_the_usual_rate_of_more_values_than_torchs_quantile_takes() -> None:
    assert stages._fast(torch.arange(2**24 + 1, dtype=torch.float32) - 2**23) == pytest.approx(0.75 * 2**23, rel=1e-6)
