"""What an effect is worth: laws of the evidence, and what one costs that is not there."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from statistics import median

import pytest
import torch
from torch import Generator, Tensor

from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.diagnosis.noise_likelihood import FLICKER_SHARES, WALK_SHARES
from zoo.diagnosis.occam import price_of_size
from zoo.diagnosis.shape_search import UNUSUAL, unusual
from zoo.diagnosis.workbench import Workbench, _released
from zoo.effects.base import Effect, History, Parameter, spread
from zoo.scoring.noise import NoiseModel

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
    """What a size in the noise costs, less half the χ² that its best column gains by chance, and the choice among its columns."""
    found = diagnosis("")
    bench, base = found.bench, found.search.base
    evidences = []
    for draw in range(DRAWS):
        monkeypatch.setitem(bench.effects, "chance", chance(draw, count))
        evidences.append(bench.evidence(base, bench.peek(base, "chance", torch.zeros(0, dtype=torch.float64))))
    expected = 0.5 * LARGEST[count] - float(price_of_size(1, torch.tensor(LARGEST[count]))) - math.log(count)
    assert median(evidences) == pytest.approx(expected, abs=0.4)
    assert sum(evidence > 0 for evidence in evidences) < 0.1 * DRAWS


def test_a_search_that_begins_again_does_not_lose_a_minimum_that_was_found_before(diagnosis) -> None:
    """Under another noise, however bad the start that it is given; by itself it would end far above."""
    found = diagnosis("polarization")
    bench, final = found.bench, found.search.final
    noise, far = NoiseModel(1.05 * bench.noise.white, bench.noise.flicker), torch.full_like(final.fit.theta, 0.02)
    after, alone = bench.with_noise(noise), Workbench(bench.runs, bench.effects, noise, bench.mixtures)
    again = after.fitted(final.names, [far])
    assert again.total <= float(after.design(final.names).cost(final.fit.theta.unsqueeze(0)))
    assert alone.fitted(final.names, [far]).total > again.total + 10.0
    assert after.solve(final.names).fit.total <= again.total + 1e-2, "nor where it looks for starts itself"


def test_a_parameter_costs_the_same_whatever_noise_a_search_comes_to(diagnosis) -> None:
    bench = diagnosis("").bench
    white = bench.mixtures.white
    walking = bench.with_noise(NoiseModel(white, 0.18 * white, 0.7 * white))
    assert walking.effective_samples == bench.effective_samples > 0.5 * bench.blocks


def test_where_the_coil_goes_is_charged_for(diagnosis) -> None:
    """Of models that differ in one amplitude: the likelihoods, the price of that, and what the prior says of where either has its coil."""
    found = diagnosis("")
    bench = found.bench
    less = bench.solve(("static_bias", "shupe"))
    more = bench.solve(("static_bias", "shupe", "mohr"))
    each = math.log(bench.effective_samples)
    gain = more.likely.logarithm - less.likely.logarithm - more.price({"mohr": more.places()["mohr"]}, each) + less.price({}, each)
    assert bench.evidence(less, more) == pytest.approx(gain - 0.5 * (more.fit.moved - less.fit.moved), abs=1e-9)
    theta = less.fit.theta.clone()
    theta[0] = 0.99
    far = bench.moved(less, theta)
    assert far.fit.moved > less.fit.moved + 5.0, "a lag of two hours is no coil's"


def test_a_parameter_on_which_nothing_depends_where_the_coil_is_costs_what_it_costs_elsewhere(runs, catalogue, base) -> None:
    """Once a coil is later than its lags make it, how late it is moves nothing: no model is simpler for having its coil there."""
    bench = open_bench(runs(thermometers=1), base, catalogue)
    model = bench.solve(("static_bias", "shupe"))
    theta = model.fit.theta.clone()
    lead = [one.name for _, one in model.model.parameters_of_theta()].index("lead")
    theta[lead] = 0.0
    there = bench.moved(model, theta)
    assert bool(model.fit.moves[lead].any())
    assert there.freedom == model.freedom - 1
    assert there.price({}, 3.0) == model.price({}, 3.0)
    own = {"shupe": model.places()["shupe"]}
    dear, cheap = ([one.price(own, each) for one in (there, model)] for each in (3.0, 1.0))
    assert dear[0] - cheap[0] == pytest.approx(dear[1] - cheap[1], abs=1e-9)


def test_to_know_a_quarter_of_the_shapes_before_is_worth_a_factor_of_four(diagnosis) -> None:
    """A warm-up whose time may be anywhere in a quarter of the range, along the logarithm, around what the runs tell of it."""
    found = diagnosis("warm_up")
    bench, names = found.bench, found.search.base.names
    effect = bench.effects["warm_up"]
    (fitted,) = [float(one.shape_value.detach()[0]) for name, one in found.search.final.model.named_effects() if name == "warm_up"]
    reach = (effect.shape[0].high / effect.shape[0].low) ** (1 / 8)
    known = bench.with_effects(bench.effects | {"warm_up": effect.bounded(0, fitted / reach, fitted * reach)})
    anywhere, near = (each.evidence(each.begin(names), each.add(each.begin(names), "warm_up")) for each in (bench, known))
    assert near - anywhere == pytest.approx(math.log(4.0), abs=0.2)


def test_shapes_are_told_apart_in_the_noise_that_was_found_not_in_the_one_assumed(diagnosis, monkeypatch) -> None:
    """Of a warm-up, beside noise that flickers and walks as much as any: fewer times, whatever the fit was weighted with."""
    monkeypatch.setattr("zoo.diagnosis.solved.price_of_size", lambda amplitudes, chi2: 0.0 * chi2)
    found = diagnosis("warm_up").search.final
    loud = replace(found, prices={})
    place = len(FLICKER_SHARES) - 1, len(WALK_SHARES) - 1
    loud.__dict__["likely"] = found.mixtures.at(place, found.fit.plain, found.design.error, found.fit.held)
    own = {"warm_up": found.places()["warm_up"]}
    few, many = (one.price(own, 0.0) for one in (loud, found))
    assert 0 < few < 0.8 * many


def test_a_parameter_that_rests_is_paid_for_on_both_sides(runs, catalogue, base) -> None:
    """The number of the run of a step moves nothing where it is: what is added beside the step gets no discount for it."""
    bench = open_bench(runs("bias_step"), base, catalogue)
    step = bench.add(bench.begin(tuple(base)), "bias_step")
    assert not bool(step.fit.moves.any(dim=1).all()), "the number of its run"
    more = bench.add(step, "magnetic")
    each = math.log(bench.effective_samples)
    paid = more.price({"magnetic": more.places()["magnetic"]}, each) - step.price({}, each)
    assert paid > float(price_of_size(1, torch.tensor(0.0)))


@pytest.mark.parametrize(("start_c", "counted"), [(20.0, 0), (-10.0, 1)])
def test_a_past_is_counted_only_where_runs_begin_away_from_room_temperature(runs, catalogue, base, start_c, counted) -> None:
    moved = []
    for run in runs("hysteresis"):
        by_column = torch.tensor([start_c - float(run.temperature[0]) if name in run.thermometers else 0.0 for name in run.columns])
        moved.append(replace(run, table=run.table + by_column.double()))
    bench = open_bench(moved, base, catalogue)
    solved = bench.add(bench.begin(tuple(base)), "hysteresis")
    assert solved.freedom == solved.plain_columns.shape[1] + solved.fit.theta.numel() - 1 + counted
    assert bench.add(bench.begin(tuple(base)), "bias_step").whole == [("bias_step", "run")], "the number of a run is always"


@pytest.mark.parametrize("hidden", ["", "rate_temperature_coupling", "polarization", "viscoelastic"])
def test_evidence_knows_no_more_of_the_coil_than_its_prior_allows(diagnosis, hidden) -> None:
    """A model's likelihood lies between that of its parameters as they are and that of tangents without any bounds, which is higher."""
    solved = diagnosis(hidden).search.base
    plain, error = solved.fit.plain, solved.design.error
    still, free = (solved.mixtures.most_likely(columns, error, solved.near).logarithm for columns in (solved.plain_columns, plain))
    known = solved.likely.logarithm - 0.5 * solved.fit.moved
    assert still - 0.5 * solved.fit.moved - 1e-6 <= known < free - 0.1


def test_an_option_counts_and_costs_where_it_is_another_than_usual_and_is_never_let_go_to_the_middle(runs, catalogue, base) -> None:
    bench = open_bench(runs(), base, catalogue)
    start, aging = bench.begin(tuple(base)), bench.effects["aging"]
    for goes_on in (0.0, 1.0):
        shape = torch.tensor([0.2, goes_on], dtype=torch.float64)
        solved = bench.peek(start, "aging", shape)
        assert solved.whole == [("aging", "goes_on")] * int(goes_on)
        assert unusual(aging, shape.unsqueeze(0)).tolist() == [UNUSUAL * goes_on]
        assert float(_released(solved, ())[-1]) == goes_on
    assert unusual(bench.effects["bias_step"], torch.tensor([[2.0, 1.0]])).tolist() == [0.0], "any run is as likely as another"


@torch.inference_mode(False)
def test_what_was_found_can_be_trained_on(runs, catalogue, base) -> None:
    """And its runs can be trained with: whatever a diagnosis has left in them is an ordinary tensor, where inference mode is not asked for."""
    found = diagnose(runs("bias_step"), base, catalogue)
    model, (run, *_) = copy.deepcopy(found.search.final.model), found.bench.runs
    optimizer = torch.optim.SGD(model.parameters(), lr=1e-6)
    before, loss = model.coil_value.clone(), (run.block_mean(model(run.table)) - run.block_mean(run.error)).square().mean()
    loss.backward()
    optimizer.step()
    assert not torch.equal(before, model.coil_value)
