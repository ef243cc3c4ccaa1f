"""Which candidates are refitted, and from where."""

from __future__ import annotations

import copy
from types import SimpleNamespace

import pytest
import torch

from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.elsewhere import Elsewhere
from zoo.diagnosis.screening import screen
from zoo.diagnosis.trials import AT_REST, WANTED, Trial, glances, refit, worth_a_refit
from zoo.diagnosis.workbench import Guess
from zoo.effects.bounds import to_unit
from zoo.fitting.design import coarse_starts
from zoo.simulator.in_process import as_run


@pytest.mark.parametrize(("rms", "count"), [(0.99 * AT_REST, 1), (2.0 * AT_REST, 3)])
def test_beside_noise_only_what_a_glance_has_something_of_is_refitted(rms, count) -> None:
    bench, before, seen = SimpleNamespace(mixtures=SimpleNamespace(white=1.0)), SimpleNamespace(rms=rms), SimpleNamespace(rms=rms)
    trials = [Trial(SimpleNamespace(name=str(i)), seen, evidence, False) for i, evidence in enumerate((WANTED + 0.1, WANTED - 0.1, -9.0, -12.0))]
    assert worth_a_refit(bench, trials, before) == trials[:count]
    assert (worth_a_refit(bench, trials[1:], before) == []) is (count == 1)


@pytest.mark.parametrize(("hidden", "all_of_them"), [("aging", True), ("warm_up", False)])
def test_beside_a_walk_all_are_looked_at_unless_one_is_overwhelming(runs, catalogue, base, hidden, all_of_them) -> None:
    """A walk makes little of what is slow: what explains a little under it may be all that it stands for."""
    bench = open_bench(runs(hidden), base, catalogue)
    before = bench.begin(tuple(base))
    assert bench.mixtures.much_walk(before.likely.noise)
    trials = glances(bench, before, screen(bench, before, [name for name in bench.available() if name not in base]))
    assert all(trial.solved is not None for trial in trials) is all_of_them


def test_where_a_screening_looked_already_a_refit_does_not_look_again(runs, catalogue, base, monkeypatch) -> None:
    bench = open_bench(runs("glass_transition"), base, catalogue)
    solved = bench.begin(tuple(base))
    found = screen(bench, solved, ["hysteresis"])[0]
    assert found.looked is not None
    looked = bench.extended(solved, [Guess("hysteresis", found.shape)])[0]
    monkeypatch.setattr(Elsewhere, "look", None)
    known = bench.extended(solved, [Guess("hysteresis", found.shape, looked=found.looked)])[0]
    torch.testing.assert_close(known.theta, looked.theta)


def test_coils_elsewhere_rest_on_nothing_that_one_process_remembers_and_another_does_not(runs, catalogue, base) -> None:
    """Whichever asks first, of what is computed of many at once the last digits depend on what is left to be computed."""
    bench = open_bench(runs("glass_transition"), base, catalogue)
    solved = bench.begin(tuple(base))
    without = copy.copy(solved.design)
    without._remembered = None
    for one, other in zip(Elsewhere(without, solved.fit.theta)._all, Elsewhere(solved.design, solved.fit.theta)._all, strict=True):
        assert torch.equal(one.basis, other.basis)
        assert torch.equal(one.residual, other.residual)


@pytest.mark.parametrize(("name", "seed", "noises"), [("hysteresis", 1, 3.5), ("glass_transition", 3, 12.0), ("moisture", 2, 3.5)])
def test_a_refit_ends_as_low_as_from_the_truth(simulation, catalogue, base, name, seed, noises) -> None:
    """Whatever the grid of shapes meets first: what explains most on it may lie in another valley."""
    made = simulation(name, seed, noises)
    bench = open_bench([as_run(one) for one in made.runs], base, catalogue)
    before = bench.begin(tuple(base))
    trials = glances(bench, before, screen(bench, before, [name]))
    refit(bench, before, trials, lambda _: None)
    effect, true = bench.effects[name], made.shares[name].parameters()
    shape = to_unit(torch.tensor([[true[one.name][0] for one in effect.shape]], dtype=torch.float64), effect.shape).clamp(0.0, 1.0)
    coils = torch.cat([before.fit.theta.unsqueeze(0), coarse_starts(before.design, before.fit.theta)])
    starts = torch.cat([coils, shape.expand(len(coils), -1)], dim=1)
    least = min(bench.fitted((*base, name), [one]).total for one in starts[bench.design((*base, name)).cost(starts).argsort()[:3]])
    assert trials[0].solved.fit.total < least + 3.0
