"""How large an effect must be to be seen: laws of the limit, and whether effects of that size are found."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from statistics import median

import pytest
import torch
from torch import Generator, Tensor

from zoo.diagnosis.acceptance import FIRST
from zoo.diagnosis.detection_limits import _odds, detection_limits
from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.occam import price_of_size

DRAWS = 2000
PLANTED = "supply_voltage"


@pytest.fixture(scope="module")
def limits():
    """Limits beside the base of a diagnosis, by name."""

    def found(bench, base):
        return detection_limits(bench, base, [name for name in bench.available() if name not in base.names], FIRST)

    return found


def test_what_is_a_multiple_of_the_base_hides_in_any_size(diagnosis, catalogue, monkeypatch) -> None:
    found = diagnosis("")
    monkeypatch.setitem(found.bench.effects, "again", catalogue["mohr"])
    limit = detection_limits(found.bench, found.search.base, ["again"], FIRST)["again"]
    assert limit.size > 1e4 * found.bench.mixtures.white
    assert limit.hidden == 1.0
    assert limit.odds == pytest.approx(1.0, abs=0.01), "nothing is learnt of it"


def test_limits_go_with_the_unit(runs, catalogue, base, limits) -> None:
    given = runs("")
    bench, larger = (open_bench([replace(run, error=factor * run.error) for run in given], base, catalogue) for factor in (1.0, 50.0))
    small, large = (limits(each, each.solve(tuple(base))) for each in (bench, larger))
    shown = {name: limit for name, limit in small.items() if math.isfinite(limit.size) and limit.hidden < 0.9}
    assert len(shown) > 10
    for name, limit in shown.items():
        assert large[name].size == pytest.approx(50 * limit.size, rel=0.02), name
        assert large[name].hidden == pytest.approx(limit.hidden, abs=0.01), name


@pytest.mark.parametrize("factor", [0.93, 1.07])
def test_limits_are_of_the_noise_that_is_there_not_of_the_one_assumed(runs, catalogue, base, limits, factor) -> None:
    bench = open_bench(runs(""), base, catalogue)
    other = bench.with_white(factor * bench.mixtures.white)
    right, wrong = (limits(each, each.solve(tuple(base))) for each in (bench, other))
    ratios = [wrong[name].size / right[name].size for name in right if right[name].hidden < 0.5]
    assert len(ratios) > 5
    assert median(ratios) == pytest.approx(1.0, abs=0.035), "as the level assumed, or its square, if they were not"


def test_twice_the_runs_show_what_is_smaller_by_up_to_the_root_of_two(runs, catalogue, base, limits) -> None:
    few, many = (open_bench(runs("", runs=count), base, catalogue) for count in (2, 4))
    fewer, more = (limits(each, each.solve(tuple(base))) for each in (few, many))
    ratios = [fewer[name].size / more[name].size for name in fewer if fewer[name].hidden < 0.5]
    assert len(ratios) > 5
    assert 1.1 < median(ratios) < 1.05 * math.sqrt(2), "a little less, as more samples ask for more evidence"


def test_an_effect_of_its_limit_is_found_nine_times_in_ten_and_one_of_half_of_it_seldom(diagnosis, monkeypatch) -> None:
    """At the base's coil, beside white noise of the fitted level: what chance does to the evidence of one column."""
    found = diagnosis("")
    bench, base = found.bench, found.search.base
    shape = bench.shapes(PLANTED)[:1]
    monkeypatch.setattr(bench, "shapes", lambda name: shape)
    one = bench.peek(base, PLANTED, shape[0])
    column = one.plain_columns[:, one.places()[PLANTED][0]]
    size = detection_limits(bench, base, [PLANTED], FIRST)[PLANTED].size
    likely, whiten = base.likely.noise, base.mixtures.whitener(base.likely.place)[1]
    signal = whiten(column.unsqueeze(1)) / (0.5 * (column.max() - column.min()))
    rest = whiten(base.fit.plain)
    level = likely.white / base.mixtures.white  # of what is white after whitening
    noise = level * torch.randn(len(signal), DRAWS, generator=Generator().manual_seed(4), dtype=torch.float64)
    for share, least, most in ((1.0, 0.75, 1.0), (0.5, 0.0, 0.25)):  # a limit of 4.2 standard deviations, beyond a threshold of 3: 90 %, 20 %
        gain = _cost(rest, share * size * signal + noise) - _cost(torch.cat([rest, signal], dim=1), share * size * signal + noise)
        chi2 = gain / level**2
        hits = (0.5 * chi2 > FIRST + math.log(len(one.places()[PLANTED])) + price_of_size(1, chi2)).double().mean()
        assert least <= hits <= most


def _cost(columns, targets) -> Tensor:
    """Least squares left of each target (N, D) -> (D,); by gelsd, since the default reads what lies in memory (pytorch #187411)."""
    return (targets - columns @ torch.linalg.lstsq(columns, targets, driver="gelsd").solution).square().sum(dim=0)


def test_runs_that_are_not_there_hide_nothing(limits, runs, catalogue, base) -> None:
    """A line in one run has columns of its own for three more, in which nothing can be seen because there is nothing."""
    bench = open_bench(runs("", runs=1), base, catalogue)
    found = limits(bench, bench.solve(tuple(base)))["chamber_cycling"]
    assert math.isfinite(found.size)
    assert found.hidden < 0.5


def test_what_a_constant_column_would_do_is_absorbed(limits, runs, catalogue, base) -> None:
    """In a field that never changes, its sensitivity is the bias and its drift with temperature."""
    still = []
    for run in runs(""):
        table = run.table.clone()
        table[:, run.columns.index("field_ut")] = 48.3
        still.append(replace(run, table=table))
    bench = open_bench(still, base, catalogue)
    assert limits(bench, bench.solve(tuple(base)))["magnetic"].size == math.inf


def test_likelihood_ratios_of_what_is_too_small_are_one_in_the_mean_over_noise() -> None:
    """So that looking at noise changes no odds in the mean; where there is nothing of an effect they fall, where there is much they rise."""
    sizes, seen = torch.logspace(-1, 1, 33, dtype=torch.float64), torch.tensor(4.5, dtype=torch.float64)
    scores = torch.randn(400_000, generator=Generator().manual_seed(3), dtype=torch.float64)
    few = sizes < 2.5  # beyond it a handful of draws carries the mean
    assert float(_odds(sizes[few], scores, seen).mean()) == pytest.approx(1.0, abs=0.02)
    unseen = float((sizes < seen).double().mean())
    none, much = _odds(sizes, torch.tensor([0.0, -4.0], dtype=torch.float64), seen)
    assert float(none) < 0.75 * unseen
    assert float(much) > 10 * unseen
    assert torch.equal(_odds(0.0 * sizes, scores[:3], seen), torch.ones(3, dtype=torch.float64)), "what runs cannot show, looking does not change"


def test_looking_changes_odds_by_what_the_residual_has_of_an_effect(diagnosis) -> None:
    """A signal that is there speaks for itself, though too small to be named."""
    found = diagnosis("")
    bench, base = found.bench, found.search.base
    before = detection_limits(bench, base, [PLANTED], FIRST)
    one = bench.peek(base, PLANTED, bench.shapes(PLANTED)[0])
    column = one.plain_columns[:, one.places()[PLANTED][0]]
    planted = replace(base, design=copy.copy(base.design))
    planted.__dict__["likely"] = base.likely  # in the same noise
    planted.design.error = base.design.error + 0.8 * before[PLANTED].size * column / (0.5 * (column.max() - column.min()))
    after = detection_limits(bench, planted, [PLANTED], FIRST)[PLANTED]
    assert after.odds > 2 * before[PLANTED].odds
    assert after.hidden == pytest.approx(before[PLANTED].hidden, abs=1e-6), "limits are of the columns and the noise alone"


def test_a_score_beyond_any_threshold_is_a_finite_odds() -> None:
    """Of something that no effect explains, all may have much, and none was named."""
    sizes = torch.logspace(-1, 3, 33, dtype=torch.float64)
    odds = _odds(sizes, torch.tensor([4.5, 1e3, 1e6], dtype=torch.float64), torch.tensor(4.5, dtype=torch.float64))
    assert bool(odds.isfinite().all())
    assert torch.equal(odds[0].expand(3), odds)
