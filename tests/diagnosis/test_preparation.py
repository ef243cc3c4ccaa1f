"""What runs must have before an effect is fitted to them."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from zoo.catalog import build, names
from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.diagnosis.preparation import FAR_FROM_MODEL, FEW_OUTLIERS, check_swing, without_outliers, without_spikes
from zoo.errors import InputError
from zoo.fitting.noise import noise_of
from zoo.scoring.spikes import scatter, spikes

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


def far_off(run, blocks, by):
    """The run with some of its blocks off by so much."""
    hit = torch.isin(run.block, torch.tensor(blocks))
    return replace(run, error=run.error + torch.where(hit, by, 0.0))


def test_the_few_isolated_blocks_that_a_model_leaves_far_off_go_and_more_of_them_stay(runs, white) -> None:
    given = runs()
    for count, left in ((0, 0), (1, 1), (FEW_OUTLIERS, FEW_OUTLIERS), (FEW_OUTLIERS + 1, 0)):
        residuals = [torch.zeros(run.blocks, dtype=torch.float64) for run in given]
        residuals[0][20 * torch.arange(1, count + 1)] = 30 * white
        clean = without_outliers(given, residuals, white)
        assert [run.blocks for run in clean] == [given[0].blocks - left, given[1].blocks]
        assert (clean is given) == (left == 0)
        assert len(clean[0].notes) == len(given[0].notes) + (left > 0)


def test_a_piece_of_a_block_may_be_farther_off_than_a_whole_one(runs, white) -> None:
    """The last of a run, of a fifth of the samples."""
    given = runs()
    place = (given[0].block == given[0].blocks - 1).nonzero().flatten()
    block = given[0].block.clone()
    block[place[max(len(place) // 5, 1) :]] = -1
    residuals = [torch.zeros(run.blocks, dtype=torch.float64) for run in given]
    residuals[0][-1] = 5 * white
    assert len(without_outliers(given, residuals, white)[0].notes) == len(given[0].notes) + 1
    short = [replace(given[0], block=block), *given[1:]]
    assert without_outliers(short, residuals, white) is short


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_lost_samples_go_without_the_rest_of_their_blocks(runs, catalogue, base, sign) -> None:
    """More of them than spoiled blocks may be; the model as it stands explains what is left."""
    given = runs()
    first, error = given[0], given[0].error.clone()
    lost = torch.arange(20, len(error), len(error) // 40)
    error[lost] += sign * 60 * scatter(error)
    clean, _ = without_spikes([replace(first, error=error), given[1]])
    assert (clean.block < 0).nonzero().flatten().tolist() == sorted({*lost.tolist(), *(first.block < 0).nonzero().flatten().tolist()})
    assert clean.blocks == first.blocks
    assert f"{len(lost)} sample(s) far off their neighbours left out, at t = {float(first.time[lost[0]]):g}, " in clean.notes[-1]
    torch.testing.assert_close(clean.block_mean(clean.time), first.block_mean(first.time), rtol=0, atol=0.5 * first.average_s)
    assert diagnose([replace(first, error=error), given[1]], base, catalogue).verdict == "complete"


def test_a_block_of_lost_samples_only_is_gone(runs) -> None:
    first = runs()[0]
    alone = replace(first, block=torch.arange(len(first.error)), average_s=20.0)
    error = first.error.clone()
    error[[100, 200]] += 60 * scatter(error)
    (clean,) = without_spikes([replace(alone, error=error)])
    assert clean.blocks == alone.blocks - 2
    assert clean.block[[99, 100, 101, 200, 201]].tolist() == [99, -1, 100, -1, 199]


def test_what_is_far_off_everywhere_is_no_lost_sample(runs) -> None:
    first = runs()[0]
    error = first.error.clone()
    error[::11] += 60 * scatter(error)
    (clean,) = without_spikes([replace(first, error=error)])
    assert not any("sample(s)" in note for note in clean.notes)


def test_noise_is_seldom_far_off_a_model_and_what_no_noise_is_mostly() -> None:
    noise = torch.randn(300_000, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    assert float(spikes(noise, 1.0, FAR_FROM_MODEL).double().mean()) < 1e-4
    for sigmas, share in ((8.0, 0.5), (12.0, 0.9)):
        knocked = noise.clone()
        knocked[10::30] = sigmas
        assert float(spikes(knocked, 1.0, FAR_FROM_MODEL)[10::30].double().mean()) > share


@pytest.mark.parametrize("lasts", [2, 3, 5])
def test_what_lasts_is_no_outlier(runs, white, lasts) -> None:
    given = runs()
    residuals = [torch.zeros(run.blocks, dtype=torch.float64) for run in given]
    residuals[0][40 : 40 + lasts] = 30 * white
    assert without_outliers(given, residuals, white) is given


def test_a_knock_goes_and_a_burst_that_dies_away_stays(runs, white) -> None:
    given, chance = runs(), torch.Generator().manual_seed(1)
    noise = [white * torch.randn(run.blocks, generator=chance, dtype=torch.float64) for run in given]
    assert without_outliers(given, noise, white) is given
    for dies, left in ((0.0, 1), (0.5, 0), (0.85, 0)):
        residual = noise[0].clone()
        residual[50:60] += 15 * white * torch.tensor([1.0, *(dies**k for k in range(1, 10))], dtype=torch.float64)
        assert without_outliers(given, [residual, noise[1]], white)[0].blocks == given[0].blocks - left


def test_outliers_that_fast_fringes_hide_are_found_behind_them(runs, catalogue, base, white) -> None:
    """In the error itself they are no farther off than the fringes move from block to block."""
    first, second = runs("polarization", noises=40.0)
    steps = first.block_mean(first.error).diff().abs()
    fast = [int(place) + 1 for place in steps.topk(40).indices[::13]]
    spoiled = [far_off(first, fast, 25 * white), second]
    few = {name: catalogue[name] for name in (*base, "polarization", "hysteresis", "rate_temperature_coupling", "aging")}
    at_first = open_bench(spoiled, base, few).runs[0].blocks
    assert at_first > first.blocks - len(fast), "not seen at first"
    found = diagnose(spoiled, base, few)
    assert (found.verdict, found.search.missing) == ("missing", ["polarization"])
    assert found.bench.runs[0].blocks == at_first - len(fast)
    assert any(f"{len(fast)} block(s) far off" in note for note in found.record["notes"])


@pytest.mark.parametrize("step", [0.5, 10.0])
def test_an_output_in_coarse_steps_has_a_noise(runs, step) -> None:
    """Half of its differences are exactly nothing, then."""
    coarse = [replace(run, error=(run.error / step).round() * step + 0.01) for run in runs("")]
    noise = noise_of(coarse)
    assert 0 < noise.white < step


def test_times_of_a_recorder_that_counts_from_an_epoch_are_told_from_the_runs_start(runs, catalogue, base, white) -> None:
    first, second = runs("")
    spoiled = far_off(first, [40], 25 * white)
    later = replace(spoiled, table=torch.cat([spoiled.table[:, :1] + 1.7e9, spoiled.table[:, 1:]], dim=1))
    notes = [open_bench([one, second], base, catalogue).runs[0].notes for one in (spoiled, later)]
    assert "at t = " in notes[0][-1]
    assert abs(float(notes[0][-1].split()[-2]) - float(notes[1][-1].split()[-2])) <= first.average_s
