"""What sizes and shapes cost, against the integrals that the formulas stand for."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.occam import BEYOND, FAINTEST, LARGEST, SMALLEST, of_moments, price_of_excess, price_of_shape, price_of_size
from zoo.effects.bias_step import BiasStep

DRAWS = 50_000
NONE = torch.zeros(1, dtype=torch.float64)
"""What is no moment."""


@pytest.mark.parametrize("amplitudes", [1, 2, 3])
@pytest.mark.parametrize("z", [5.0, 12.0])
def test_a_size_costs_what_integration_over_sizes_and_mixtures_says(amplitudes, z) -> None:
    """Sizes from z/10 to 10 z, every factor as likely, and every mixture: the mean likelihood over the largest."""
    chance = torch.Generator().manual_seed(amplitudes)
    mixture = torch.randn(DRAWS, amplitudes, generator=chance, dtype=torch.float64)
    mixture = mixture / mixture.norm(dim=1, keepdim=True)
    sizes = torch.logspace(-1, 1, 401, dtype=torch.float64) * z
    along = z * mixture[:, 0]
    likelihood = torch.stack([(size * along - 0.5 * (size**2 + z**2)).exp().mean() for size in sizes]).mean()
    assert math.log(LARGEST / SMALLEST) == pytest.approx(math.log(float(sizes[-1] / sizes[0])))
    assert float(price_of_size(amplitudes, torch.tensor(z**2))) == pytest.approx(-math.log(float(likelihood)), abs=0.15)


def test_what_is_in_the_noise_has_no_size_to_be_told() -> None:
    least = price_of_size(2, torch.tensor([0.0, FAINTEST**2, 4.0], dtype=torch.float64))
    assert float(least[0]) == float(least[1]) > 0
    assert float(least[2] - least[1]) == pytest.approx(math.log(4.0))


def test_an_amplitude_costs_more_only_far_beyond_its_bounds() -> None:
    largest = torch.tensor([2.0, 2.0, torch.inf], dtype=torch.float64)
    assert float(price_of_excess(torch.tensor([2.0 * BEYOND, -0.1, 1e30], dtype=torch.float64), largest)) == 0.0
    assert float(price_of_excess(torch.tensor([-2e3 * BEYOND, 2e1 * BEYOND, 0.0], dtype=torch.float64), largest)) == pytest.approx(math.log(1e4))


@pytest.mark.parametrize(
    ("unit", "declared", "scale"), [("dph", "unit", 1.0), ("dps", "unit", 3600.0), ("pulses", "unit", math.inf), ("dps", "unit^p", math.inf)]
)
def test_bounds_are_those_of_a_rate(diagnosis, monkeypatch, unit, declared, scale) -> None:
    """An amplitude in bounds of 1e-9 °/h, if the output is in °/h; of what is no rate they say nothing."""
    final = diagnosis("bias_step").search.final
    effects, (step,) = {"bias_step": final.places()["bias_step"]}, BiasStep.amplitudes
    size = abs(float(final.fit.amplitudes[effects["bias_step"][0]])) * scale
    before = final.price(effects, 6.0)
    monkeypatch.setattr(BiasStep, "amplitudes", (replace(step, unit=declared, low=-1e-9, high=1e-9),))
    design = copy.copy(final.design)
    design.runs = [replace(run, unit=unit) for run in design.runs]
    given = replace(final, design=design)
    more = given.price(effects, 6.0) - before
    assert bool(given._largest[effects["bias_step"]].isinf()) is (scale == math.inf)
    assert more == pytest.approx(math.log(size / (1e-9 * BEYOND)) if scale < math.inf else 0.0, abs=0.05)


def test_a_dead_band_that_no_gyro_has_does_not_beat_a_scale_factor(runs, base, catalogue) -> None:
    """At a rate of one size, both ways, each of its widths is the same column times something; only its amplitude tells which is meant."""
    turned = []
    for run in runs():
        table = run.table.clone()
        table[:, -1] = torch.where((run.time / 3600).long() % 2 == 0, 10.0, -10.0)
        turned.append(replace(run, table=table, error=run.error + 5e-3 * table[:, -1]))
    bench = open_bench(turned, base, catalogue)
    before = bench.solve(tuple(base))
    scale_factor = bench.peek(before, "scale_factor", torch.zeros(0, dtype=torch.float64))
    shapes = {width: torch.tensor([width, 500.0], dtype=torch.float64) for width in (1e-6, 10.0)}
    absurd, plausible = (bench.peek(before, "dead_band", shape) for shape in shapes.values())
    assert absurd.rms == pytest.approx(scale_factor.rms, rel=0.01)
    assert abs(float(absurd.fit.amplitudes[-1])) > 1e6
    assert bench.evidence(absurd, scale_factor) > 7.0
    assert abs(bench.evidence(plausible, scale_factor)) < 7.0


@pytest.mark.parametrize("size", [0.0, 0.5, 3.0, 30.0])
def test_a_shape_costs_what_integration_over_its_range_says(size) -> None:
    """A signal that goes with a parameter: the mean likelihood over its range, over that of the middle."""
    tangent = torch.randn(200, 1, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    tangent = size * tangent / tangent.norm()
    away = torch.linspace(-0.5, 0.5, 20001, dtype=torch.float64)
    mean = (-0.5 * (size * away).square()).exp().mean()
    assert price_of_shape(tangent, tangent.new_zeros(200, 0), NONE) == pytest.approx(-math.log(float(mean)), abs=0.15)


def test_a_shape_costs_only_what_nothing_else_can_do() -> None:
    chance = torch.Generator().manual_seed(2)
    others = torch.randn(300, 3, generator=chance, dtype=torch.float64)
    alone = 5.0 * torch.randn(300, 1, generator=chance, dtype=torch.float64)
    assert price_of_shape(others @ torch.ones(3, 1, dtype=torch.float64), others, NONE) == pytest.approx(0.0, abs=1e-6)
    mixed = price_of_shape(alone + 100.0 * others[:, :1], others, NONE)
    assert mixed == pytest.approx(price_of_shape(alone - others @ torch.linalg.lstsq(others, alone).solution, others, NONE), rel=1e-6)


def test_two_shapes_that_do_not_meddle_cost_their_sum() -> None:
    tangents = torch.zeros(10, 2, dtype=torch.float64)
    tangents[0, 0], tangents[1, 1] = 20.0, 4.0
    nothing = tangents.new_zeros(10, 0)
    each = [price_of_shape(tangents[:, i : i + 1], nothing, NONE) for i in range(2)]
    assert price_of_shape(tangents, nothing, torch.zeros(2, dtype=torch.float64)) == pytest.approx(sum(each))
    assert each[0] > each[1] > 0
    assert price_of_shape(tangents[:, :0], nothing, NONE[:0]) == 0.0


@pytest.mark.parametrize("height", [0.2, 0.5, 1.0, 5.0])
def test_a_moment_costs_what_integration_over_a_run_says(height) -> None:
    """A step in white noise, so many standard deviations of a block high: the mean likelihood over its moments, over that of the middle."""
    blocks = 400
    edges = torch.arange(blocks + 1, dtype=torch.float64)

    def step(moment: Tensor) -> Tensor:
        return height * (edges[1:] - moment.unsqueeze(-1)).clamp(0.0, 1.0)

    middle = torch.tensor([0.5 * blocks], dtype=torch.float64)
    moments = torch.linspace(0, blocks, 40 * blocks + 1, dtype=torch.float64)
    mean = (-0.5 * (step(moments) - step(middle)).square().sum(-1)).exp().mean()
    tangent = blocks * (step(middle + 1e-3) - step(middle)).mT / 1e-3
    price = price_of_shape(tangent, tangent.new_zeros(blocks, 0), torch.tensor([float(blocks)], dtype=torch.float64))
    assert price == pytest.approx(-math.log(float(mean)), abs=0.4)


def test_only_what_is_a_moment_is_told_apart_along_a_line() -> None:
    gram = torch.tensor([[400.0, 30.0], [30.0, 9.0]], dtype=torch.float64)
    assert torch.equal(of_moments(gram, torch.zeros(2, dtype=torch.float64)), gram)
    less = of_moments(gram, torch.tensor([100.0, 0.0], dtype=torch.float64))
    assert float(less[1, 1]) == 9.0
    assert float(less[0, 0]) < 400.0
    assert float(less[0, 1] ** 2 / less[0, 0]) == pytest.approx(30.0**2 / 400.0), "what they have in common stays in proportion"


def test_a_whole_number_has_as_many_choices_as_are_looked_at() -> None:
    step = build("effects", "bias_step")
    assert [step.choices(1, runs) for runs in (1, 2, 3)] == [1, 4, 6], "in all, in each, and for good in each but the last"


def test_a_whole_number_costs_the_logarithm_of_its_choices(diagnosis, monkeypatch) -> None:
    final = diagnosis("bias_step").search.final
    effects = {"bias_step": final.places()["bias_step"]}
    price, choices = final.price(effects, 6.0), BiasStep.choices
    monkeypatch.setattr(BiasStep, "choices", lambda *given: 3 * choices(*given))
    assert final.price(effects, 6.0) - price == pytest.approx(math.log(3.0))
