"""The numbers that verdicts rest on: evidence, posterior, cross-validation, the noise floor."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest
import torch
from torch import Generator

from zoo.catalog import build, names
from zoo.diagnosis.acceptance import ACCEPT
from zoo.diagnosis.alike import indistinguishable
from zoo.diagnosis.cross_validation import rms_by_run, segment_cost
from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.posterior import ANOTHER, SOMETHING, TEMPER, believed, hypotheses, posterior, too_small, unknown
from zoo.diagnosis.screening import Screened, screen
from zoo.diagnosis.search import Search, what_helps
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import examine
from zoo.diagnosis.trials import Step, Trial
from zoo.fitting.projection import project
from zoo.scoring.noise import NoiseModel

ABSORBED = {"static_bias", "shupe", "mohr", "sensor_lag", "thermal_gradient", "fixture_rotation"}
"""The base, and what it makes up for."""
OF_THEIR_OWN = [name for name in names("effects") if name not in ABSORBED and not build("effects", name).needs_varied_reference]


def trial(name: str, evidence: float) -> Trial:
    return Trial(Screened(name, torch.zeros(0), 0.0, 1), None, evidence, False)


def round_with(*trials: Trial) -> Step:
    """A round whose model does not matter."""
    return Step(cast(Solved, None), [*trials], ACCEPT)


@pytest.mark.parametrize("evidences", [(), (0.0,), (0.0, 0.0, 0.0), (500.0, 499.0), (-1e4, -2e4), (1e4, -1e4, 3.0)])
def test_a_posterior_sums_to_less_than_one(evidences) -> None:
    chances = posterior(round_with(*(trial(str(i), value) for i, value in enumerate(evidences))))
    assert sum(chances.values()) <= 1 + 1e-12
    assert all(0 <= chance <= 1 for chance in chances.values())
    excess = torch.tensor([value - ACCEPT - math.log(max(len(evidences), 1)) for value in evidences], dtype=torch.float64)
    none = 1.0 / (1.0 + float(believed(excess).exp().sum()))  # one more hypothesis, at the threshold
    assert sum(chances.values()) == pytest.approx(1 - none)


def test_equal_evidence_is_equal_probability() -> None:
    chances = posterior(round_with(trial("a", 80.0), trial("b", 80.0), trial("c", 60.0)))
    assert chances["a"] == chances["b"] == pytest.approx(0.5, rel=5e-3)
    assert chances["a"] / chances["c"] == pytest.approx(math.exp(20 * TEMPER))


def test_in_every_round_of_a_search_what_the_posterior_leaves_is_the_chance_of_none(diagnosis) -> None:
    """More than any candidate's where none was added, less than that of the one that was, and one half against one that is at the threshold."""
    first, last = diagnosis("bias_step").search.steps
    assert (first.chosen, last.chosen) == ("bias_step", None)
    for step in (first, last):
        chances = posterior(step)
        none = 1 - sum(chances.values())
        excess = torch.tensor([one.evidence - step.needed for one in step.trials], dtype=torch.float64)
        assert none == pytest.approx(1 / (1 + float(believed(excess).exp().sum())), abs=1e-12)
        assert none < chances[step.chosen] if step.chosen else none > max(chances.values())
        alone = replace(step, trials=step.trials[:1])
        level = replace(alone, trials=[replace(alone.trials[0], evidence=alone.needed)])
        assert posterior(level) == {alone.trials[0].screened.name: pytest.approx(0.5)}


@pytest.mark.parametrize("hidden", ["", "bias_step", "polarization"])
def test_hypotheses_sum_to_one_with_the_unknown_and_the_verdict_is_the_first(diagnosis, hidden) -> None:
    found = diagnosis(hidden)
    listed = hypotheses(found.search, found.structure, 0.0, found.bench.effects)
    assert sum(one.probability for one in listed) + unknown(found.structure) == pytest.approx(1)
    assert len({(one.effects, one.faint) for one in listed}) == len(listed)
    assert listed[0].effects == ((hidden,) if hidden else ())
    assert listed[0].probability > 0.8
    assert not any(one.probability for one in listed if one.faint), "what would be seen is not there"


def test_what_speaks_for_another_beside_a_simplified_form_is_tempered() -> None:
    known = [(0.5, 0.2), (0.5, 50.0), (0.0, 0.0)]
    assert too_small(known, alone=True) == pytest.approx(50.2 / 3)
    assert too_small(known, alone=False) == pytest.approx((0.2 + 0.5 * 100**TEMPER) / 3)
    assert too_small([], alone=True) == 0


@pytest.mark.parametrize(("hidden", "odds"), [("", SOMETHING), ("bias_step", ANOTHER)])
def test_what_cannot_be_seen_is_as_probable_as_its_odds_say(diagnosis, hidden, odds) -> None:
    found = diagnosis(hidden)
    effects = (hidden,) if hidden else ()
    for share in (0.3, 1.0):
        listed = {(one.effects, one.faint): one.probability for one in hypotheses(found.search, found.structure, share, found.bench.effects)}
        assert sum(listed.values()) + unknown(found.structure) == pytest.approx(1)
        beside = {named: chance for (named, faint), chance in listed.items() if faint}
        assert effects in beside
        for named, chance in beside.items():
            assert len(named) <= len(effects)
            assert chance == pytest.approx(share * odds * listed[(named, False)]), "whatever the others are"


def test_evidence_is_antisymmetric_and_none_against_itself(diagnosis) -> None:
    found = diagnosis("bias_step")
    base, final = found.search.base, found.search.final
    assert found.bench.evidence(base, base) == 0
    assert found.bench.evidence(base, final) == -found.bench.evidence(final, base)
    assert found.bench.evidence(base, final) > 50


def test_evidence_adds_along_a_path(diagnosis) -> None:
    found = diagnosis("bias_step")
    bench, base, final = found.bench, found.search.base, found.search.final
    more = bench.add(final, "warm_up")
    way = bench.evidence(base, final) + bench.evidence(final, more)
    assert bench.evidence(base, more) == pytest.approx(way, abs=0.25), "shapes together are told apart a little worse than one by one"
    assert bench.evidence(final, more) < 5, "what is not there is not supported"


def test_a_larger_model_never_fits_worse(diagnosis) -> None:
    found = diagnosis("bias_step")
    bench, base = found.bench, found.search.base
    candidates = [name for name in bench.available() if name not in base.names]
    screened = screen(bench, base, candidates)
    assert {one.name for one in screened} == set(candidates) > {"bias_step"}
    for candidate in screened:
        assert candidate.gain >= -1e-6 * base.fit.cost
        assert bench.peek(base, candidate.name, candidate.shape).fit.cost <= base.fit.cost * (1 + 1e-9)


def test_screening_finds_the_planted_one_first(diagnosis) -> None:
    found = diagnosis("bias_step")
    bench, base = found.bench, found.search.base
    assert screen(bench, base, [name for name in bench.available() if name not in base.names])[0].name == "bias_step"


def test_a_run_too_short_to_predict_another_from_is_not_asked_to(runs, catalogue, base, white) -> None:
    long, other = runs("")
    keep = (other.block < 8) & (other.block >= 0)
    short = replace(other, table=other.table[keep], error=other.error[keep], count=other.count[keep], block=other.block[keep])
    bench = open_bench([long, short], base, catalogue)
    assert rms_by_run(bench, bench.solve(tuple(base))) < 2.0 * white


@pytest.mark.parametrize("hidden", ["", "bias_step"])
def test_errors_on_segments_that_were_not_fitted_are_never_smaller(diagnosis, hidden) -> None:
    """Group leave-out residuals are (1 − H)⁻¹ times the fitted ones, and 1 − H shrinks."""
    found = diagnosis(hidden)
    for solved in (found.search.base, found.search.final):
        assert segment_cost(found.bench, solved) >= solved.fit.cost
        plain = solved.plain_columns
        least = math.sqrt(float(project(plain, solved.design.error).cost) / found.bench.blocks)
        assert rms_by_run(found.bench, solved) >= least
    for one in found.record["candidates"]:
        assert one["rms_cross_validated"] >= 0.98 * one["rms"]


def test_the_floor_is_a_little_below_the_noise_and_never_above_what_remains_by_much(diagnosis, white) -> None:
    for hidden in ("", "bias_step"):
        found = diagnosis(hidden)
        final = found.search.final
        assert found.bench.noise_floor(final) == pytest.approx(final.rms, rel=0.1)
        assert found.bench.noise_floor(final) < 1.15 * white
        assert found.record["noise_floor"] == found.bench.reached_floor(final) == found.bench.noise_floor(final)


@pytest.mark.parametrize("period_s", [6000.0, 9000.0])
def test_where_what_recurs_is_taken_for_a_walk_the_floor_is_what_is_left(runs, base, catalogue, white, period_s) -> None:
    """A walk that accounts for it within minutes goes on for hours, in which the model leaves less."""
    recurs = [replace(run, error=run.error + 2 * white * torch.sin(2 * torch.pi * run.time / period_s)) for run in runs()]
    bench = open_bench(recurs, base, catalogue)
    solved = bench.begin(tuple(base))
    assert bench.mixtures.much_walk(solved.likely.noise)
    assert bench.reached_floor(solved) == solved.rms < bench.noise_floor(solved)


def test_the_absolute_test_passes_noise_and_fails_a_fault(diagnosis) -> None:
    right, wrong = diagnosis(""), diagnosis("bias_step")
    assert examine(right.bench, right.search.base, right.search.base).is_noise
    structure = examine(wrong.bench, wrong.search.base, wrong.search.base)
    assert not structure.is_noise
    assert examine(wrong.bench, wrong.search.final, wrong.search.base).is_noise


def test_the_absolute_test_does_not_rest_on_the_colour_of_the_noise_alone(diagnosis, monkeypatch) -> None:
    """Level and smooth dependences fail a fault by themselves, each."""
    found = diagnosis("rate_temperature_coupling")
    bench, base, final = found.bench, found.search.base, found.search.final
    monkeypatch.setattr(type(bench.mixtures), "much_walk", lambda mixtures, noise: False)
    assert examine(bench, final, base).is_noise
    assert not examine(bench, base, base).is_noise
    monkeypatch.setattr("zoo.diagnosis.structure.free_dependences", lambda bench, final: [])
    loud = replace(base, design=copy.copy(base.design))
    loud.design.error = base.design.error + 6 * bench.mixtures.white * torch.sin(torch.arange(bench.blocks, dtype=torch.float64) * 2.0)
    structure = examine(bench, loud, loud)
    assert structure.excess > 1
    assert not structure.is_noise


def test_an_effect_is_distinguishable_from_what_looks_different(diagnosis) -> None:
    found = diagnosis("bias_step")
    bench, final = found.bench, found.search.final
    assert indistinguishable(bench, final, "bias_step", ["magnetic", "supply_voltage", "bias_step", "polarization"]) == []


@pytest.mark.parametrize("name", OF_THEIR_OWN)
def test_an_effect_is_indistinguishable_from_its_own_double(runs, base, catalogue, name) -> None:
    """Decided from the columns at hand, not from a list: another effect with the very same columns must be reported, wherever its shape lies."""
    bench = open_bench(runs(name, 1, 12.0 if name == "hysteresis" else 3.5), base, {**catalogue, "double": catalogue[name]})
    final = bench.add(bench.begin(tuple(base)), name)
    assert "double" in indistinguishable(bench, final, name, ["double"])


@pytest.mark.parametrize("onset_h", [1.9031, 3.3337])
def test_the_onset_of_a_step_is_screened_to_a_sample(diagnosis, onset_h) -> None:
    """Between two onsets of the grid, which are five minutes and more apart: a fit would not find its way from either."""
    found = diagnosis("")
    base, bench = found.search.base, found.bench
    step = torch.cat([run.block_mean((run.time - run.time[0] > onset_h * 3600).double()) for run in bench.runs]).unsqueeze(1)
    planted = replace(base, design=copy.copy(base.design))
    planted.design.error = base.design.error + 30 * bench.mixtures.white * step.squeeze(1)
    assert float(screen(bench, planted, ["bias_step"])[0].shape[0]) == pytest.approx(onset_h, abs=20 / 3600)


@pytest.mark.parametrize("hidden", ["bias_step", "polarization"])
def test_all_that_is_said_of_a_candidate_is_from_one_round(diagnosis, hidden) -> None:
    """Its numbers; the parameters of an effect that is added are those of the model that has it. Its probability is that of all sets that have it."""
    found = diagnosis(hidden)
    limits = [(limit["hidden"], limit["odds"]) for limit in found.record["detection_limits"].values()]
    weighed = hypotheses(found.search, found.structure, too_small(limits, alone=False), found.bench.effects)
    said = {one["effect"]: one for one in found.record["candidates"]}
    first = found.search.steps[0]
    assert first.chosen == hidden
    for trial in first.trials:
        one = said[trial.screened.name]
        assert one["beside"] == list(found.search.base.names)
        assert one["probability"] == pytest.approx(sum(each.probability for each in weighed if trial.screened.name in each.effects))
        if trial.solved is not None:
            assert (one["rms"], one["delta_bic"]) == (trial.solved.rms, pytest.approx(-2 * trial.evidence))
    assert said[hidden]["parameters"] == found.record["parameters"][hidden]
    assert found.record["rms_final"] < 1.002 * said[hidden]["rms"], "the final model is fitted on"
    if hidden == "bias_step":
        assert found.record["rms_final"] > 0.998 * said[hidden]["rms"], "in the same shape: it has no lines to look for"


def test_where_nothing_suffices_only_large_steps_are_named(diagnosis) -> None:
    """Steps that take away 50 %, then 20 %, then 60 % of the variance: the first alone helps."""
    real = diagnosis("bias_step").search.base

    def left(rms: float, *names: str) -> Any:
        return SimpleNamespace(rms=rms, names=(*real.names, *names))

    models = [left(1.0), left(0.5**0.5, "a"), left(0.4**0.5, "a", "b"), left(0.16**0.5, "a", "b", "c")]
    assert what_helps(Search(models[0], models[-1], path=models[1:])).missing == ["a"]
    assert what_helps(Search(models[0], models[2], path=models[1:3])).missing == ["a"]
    assert what_helps(Search(models[0], models[0])).missing == []


@pytest.mark.parametrize("mixture", [(1.0, 0.05, 0.0), (1.0, 0.6, 0.0), (1.0, 0.25, 0.3), (1.1, 1.2, 0.1)])
def test_the_likeliest_mixture_resembles_the_noise_that_was_drawn(diagnosis, mixture) -> None:
    found = diagnosis("")
    mixtures, columns = found.bench.mixtures, found.search.base.fit.plain
    chance, share = Generator().manual_seed(1), tuple(one * mixtures.white for one in mixture)
    noise = NoiseModel(*share)
    results = []
    for _ in range(4):
        roots = [torch.linalg.cholesky(noise.covariance(blocks)) for blocks in mixtures.runs]
        target = torch.cat([root @ torch.randn(len(root), generator=chance, dtype=torch.float64) for root in roots])
        results.append(mixtures.most_likely(columns, target))
    dof = found.bench.blocks - columns.shape[1]
    assert sum(one.cost for one in results) / 4 / dof == pytest.approx(1, abs=0.08)
    assert sum(one.noise.white for one in results) / 4 == pytest.approx(share[0], rel=0.12)
    assert not any(mixtures.much_walk(one.noise) for one in results)
