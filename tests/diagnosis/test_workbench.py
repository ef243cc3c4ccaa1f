"""What an effect is worth: laws of the evidence, and what one costs that is not there."""

from __future__ import annotations

import math
from statistics import median

import pytest
import torch
from torch import Generator, Tensor

from zoo.effects.base import Effect, History, Parameter, spread

DRAWS = 60
LARGEST = {1: 0.455, 3: 1.597}
"""Median of the largest of as many squares of normal numbers: the quantile of χ² with one degree of freedom at 0.5^(1/count)."""


def chance(draw: int, count: int) -> Effect:
    """An effect that is white noise, the same whenever it is asked for, with as many columns."""

    class Chance(Effect):
        """Noise."""

        name = "chance"
        place = "housing"
        amplitudes = tuple(Parameter(f"a{i}", 0.0, "unit", -10.0, 10.0) for i in range(count))

        def columns(self, history: History, shape: Tensor) -> Tensor:
            """(..., T, K) normal numbers."""
            generator = Generator().manual_seed(1000 * draw + history.run)
            return spread(torch.randn(len(history.time), count, generator=generator, dtype=torch.float64), shape)

    return Chance()


@pytest.mark.parametrize(("one", "other"), [("bias_step", "warm_up"), ("bias_step", "polarization"), ("polarization", "viscoelastic")])
def test_rivals_have_over_each_other_what_they_have_over_the_base(diagnosis, one, other) -> None:
    """What only one of two models has is judged by what the runs call for of it, whichever of the two is asked about first."""
    found = diagnosis("bias_step")
    bench, base = found.bench, found.search.base
    first, second = bench.add(base, one), bench.add(base, other)
    assert bench.evidence(first, second) == -bench.evidence(second, first)
    assert bench.evidence(first, second) == pytest.approx(bench.evidence(base, second) - bench.evidence(base, first), abs=1e-9)
    assert abs(bench.evidence(first, second)) > 0.1


@pytest.mark.parametrize("count", LARGEST)
def test_an_effect_of_pure_noise_costs_what_one_amplitude_does(diagnosis, monkeypatch, count) -> None:
    """Half the logarithm of the samples, less half the χ² that its best column gains by chance, and the choice among its columns."""
    found = diagnosis("")
    bench, base = found.bench, found.search.base
    evidences = []
    for draw in range(DRAWS):
        monkeypatch.setitem(bench.effects, "chance", chance(draw, count))
        evidences.append(bench.evidence(base, bench.peek(base, "chance", torch.zeros(0, dtype=torch.float64))))
    expected = 0.5 * LARGEST[count] - 0.5 * math.log(bench.effective_samples) - math.log(count)
    assert median(evidences) == pytest.approx(expected, abs=0.4)
    assert sum(evidence > 0 for evidence in evidences) < 0.1 * DRAWS
