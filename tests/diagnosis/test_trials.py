"""Which candidates are refitted, and from where."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
import torch

from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.elsewhere import Elsewhere
from zoo.diagnosis.screening import screen
from zoo.diagnosis.trials import AT_REST, WANTED, Trial, _worth_arefit
from zoo.diagnosis.workbench import Guess


@pytest.mark.parametrize(("rms", "count"), [(0.99 * AT_REST, 1), (2.0 * AT_REST, 3)])
def test_beside_noise_only_what_a_glance_has_something_of_is_refitted(rms, count) -> None:
    bench, before, seen = SimpleNamespace(mixtures=SimpleNamespace(white=1.0)), SimpleNamespace(rms=rms), SimpleNamespace(rms=rms)
    trials = [Trial(SimpleNamespace(name=str(i)), seen, evidence, False) for i, evidence in enumerate((WANTED + 0.1, WANTED - 0.1, -9.0, -12.0))]
    assert _worth_arefit(bench, trials, before) == trials[:count]
    assert (_worth_arefit(bench, trials[1:], before) == []) is (count == 1)


def test_where_a_screening_looked_already_a_refit_does_not_look_again(runs, catalogue, base, monkeypatch) -> None:
    bench = open_bench(runs("glass_transition"), base, catalogue)
    solved = bench.begin(tuple(base))
    found = screen(bench, solved, ["hysteresis"])[0]
    assert found.looked is not None
    looked = bench.extended(solved, [Guess("hysteresis", found.shape)])[0]
    monkeypatch.setattr(Elsewhere, "look", None)
    known = bench.extended(solved, [Guess("hysteresis", found.shape, looked=found.looked)])[0]
    torch.testing.assert_close(known.theta, looked.theta)
