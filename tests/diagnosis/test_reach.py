"""No further effects are looked for where one function of one quantity is ahead of all that they could explain."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest
import torch

from zoo.diagnosis import reach, search, settle
from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.outdone import outdone
from zoo.diagnosis.reach import out_of_reach
from zoo.diagnosis.structure import leaves_noise
from zoo.diagnosis.workbench import Workbench
from zoo.simulator.in_process import as_run


def with_square(simulation, with_error_of, size, more=lambda time: 0.0 * time):
    """Runs with the square of the coil's rate, of so large a standard deviation, and something of time beside it."""
    runs = with_error_of(simulation().runs, lambda coil, rate: rate.square(), size)
    return [replace(run, error=run.error + more(run.time)) for run in runs]


def telegraph(size):
    chance = torch.Generator().manual_seed(7)
    return lambda time: size * (1.0 - 2.0 * ((torch.rand(len(time), generator=chance, dtype=torch.float64) < 20.0 / 1500.0).cumsum(0) % 2))


@pytest.mark.parametrize("beside", [0.0, 3.0])
def test_only_where_a_form_leaves_noise(simulation, with_error_of, white, catalogue, base, beside) -> None:
    """Where it leaves more, two effects might explain both."""
    bench = open_bench(with_square(simulation, with_error_of, 4 * white, telegraph(beside * white)), base, catalogue)
    before = bench.begin(tuple(base))
    named = bench.add(before, "polarization", ("polarization",))
    assert outdone(bench, named, before) > 1.0
    assert out_of_reach(bench, named, before) is (beside == 0.0)


def test_an_effect_that_is_there_is_never_out_of_reach(simulation, catalogue, base) -> None:
    bench = open_bench([as_run(one) for one in simulation("rate_temperature_coupling").runs], base, catalogue)
    before = bench.begin(tuple(base))
    assert not out_of_reach(bench, bench.add(before, "rate_temperature_coupling", ("rate_temperature_coupling",)), before)


def test_what_goes_with_a_column_is_in_reach_of_the_effect_that_does(simulation, catalogue, base, monkeypatch) -> None:
    """No form need be looked for before that was tried."""
    bench = open_bench([as_run(one) for one in simulation("magnetic", noises=20.0).runs], base, catalogue)
    before = bench.begin(tuple(base))
    named = bench.add(before, "aging", ("aging",))
    assert outdone(bench, named, before) > 1.0
    monkeypatch.setattr(reach, "best_form", None)
    assert not out_of_reach(bench, named, before)


def test_where_all_is_out_of_reach_nothing_further_is_tried_and_a_whole_search_finds_nothing_either(
    simulation, with_error_of, white, catalogue, base, monkeypatch
) -> None:
    """Nor is any block an outlier of what was found."""
    runs, candidates = with_square(simulation, with_error_of, 4 * white), ["polarization", "rate_temperature_coupling", "hysteresis"]
    bench = open_bench(runs, base, catalogue)
    with monkeypatch.context() as patch:
        for module, way in product((search, settle), ("single", "by_evidence", "pair")):
            patch.setattr(module, way, None)
        patch.setattr(Workbench, "without_outliers", None)
        under, short = settle.settle(bench, tuple(base), candidates)
    assert [step.before.names for step in short.steps] == [tuple(base)]
    assert short.missing
    assert not leaves_noise(under, short.final, short.base)
    assert out_of_reach(under, short.final, short.base)
    for module in (search, settle):
        monkeypatch.setattr(module, "out_of_reach", lambda *_: False)
    other, whole = settle.settle(bench, tuple(base), candidates)
    assert not leaves_noise(other, whole.final, whole.base)
    assert len(short.steps) < len(whole.steps)


def test_where_nothing_was_added_no_free_function_is_looked_for(simulation, catalogue, base, monkeypatch) -> None:
    bench = open_bench([as_run(one) for one in simulation().runs], base, catalogue)
    before = bench.begin(tuple(base))
    monkeypatch.setattr(reach, "freed_of", None)
    assert not out_of_reach(bench, before, before)
