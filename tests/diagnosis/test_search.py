"""Two hidden effects where adding one at a time does not lead to both."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import pytest
import torch
from torch import Generator

from zoo.diagnosis import acceptance, search
from zoo.diagnosis.acceptance import ACCEPT, FIRST, accepted, convinces
from zoo.diagnosis.diagnose import Diagnosis, diagnose, open_bench
from zoo.diagnosis.posterior import hypotheses
from zoo.diagnosis.screening import Screened, screen
from zoo.diagnosis.search import PAIRED, Search, _drop, _looked_at, _remember, _singles, in_reach, single
from zoo.diagnosis.settle import _white
from zoo.diagnosis.trials import Step, Trial, glances, refit
from zoo.diagnosis.workbench import Workbench
from zoo.effects.earlier import before_each
from zoo.effects.hysteresis import play
from zoo.models.graybox import GrayBox
from zoo.simulator.in_process import as_run


def believed(bench, base, trial: Trial, *evidences: float) -> list[bool]:
    """Whether an addition to the base convinces by so much evidence, among twenty candidates and where 150 : 1 is asked."""
    step = Step(base, [trial] * 20, ACCEPT)
    return [convinces(bench, base, step, replace(trial, evidence=evidence)) for evidence in evidences]


@pytest.fixture
def both(simulation, catalogue, base) -> Callable[..., Diagnosis]:
    """What is said of a gyro with two hidden effects, each of so many times the white noise of a block."""

    def of(first: str, noises: float, second: str, more: float, seed: int, runs: int = 2) -> Diagnosis:
        one, other = simulation(first, seed, noises, runs), simulation(second, seed, more, runs)
        given = []
        for recorded, added in zip(one.runs, other.runs, strict=True):
            run = as_run(recorded)
            given.append(replace(run, error=run.error + added.truth[f"{second}_dph"]))
        return diagnose(given, base, catalogue)

    return of


@pytest.mark.parametrize(("noises", "seed", "alone"), [((1.0, 2.0), 4, "aging"), ((1.1, 1.9), 4, None), ((1.0, 1.8), 4, None)])
def test_two_effects_that_help_only_together_are_both_named(both, noises, seed, alone) -> None:
    """Either alone leaves more than noise and predicts pieces of the runs that were not fitted no better; or one just convinces by itself."""
    found = both("warm_up", noises[0], "aging", noises[1], seed)
    assert found.verdict == "missing"
    assert set(found.search.missing) == {"warm_up", "aging"}
    assert found.search.steps[0].chosen == alone, "no single effect convinced"
    assert len(found.search.path) == (2 if alone else 1), "both in one step"


@pytest.mark.slow
@pytest.mark.parametrize(("noises", "second", "seed"), [(20.0, "moisture", 1), (20.0, "moisture", 2), (12.0, "aging", 5)])
def test_two_large_effects_are_both_named_although_what_follows_their_sum_predicts_best_on_the_way(both, noises, second, seed) -> None:
    """One run, in which a step happens once: lines or loops follow the sum of it and a drift better than either; no single effect leaves noise."""
    found = both("bias_step", noises, second, 20.0, seed, runs=1)
    assert found.verdict == "missing"
    assert set(found.search.missing) == {"bias_step", second}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "seed"),
    [("bias_step+moisture", 3003), ("viscoelastic+moisture", 3008), ("aging+rate_temperature_coupling", 3018), ("warm_up+aging", 3019)],
)
def test_two_effects_of_forty_times_the_noise_are_found_where_they_are(runs, catalogue, base, hidden, seed) -> None:
    """Not where each alone goes to follow the other as well: far off, at a bound, held in place by a third that corrects both."""
    found = diagnose(runs(hidden, seed, 40.0, runs=1), base, catalogue)
    assert found.verdict == "missing"
    assert "+".join(sorted(found.search.missing)) == "+".join(sorted(hidden.split("+")))
    assert found.search.final.rms < 1.3 * found.bench.mixtures.white < found.search.base.rms / 20
    assert found.record["posterior"][0]["effects"] == sorted(found.search.missing), "what was tried beside a worse fit of the two does not count"
    for one in found.record["candidates"]:
        assert set(one["beside"]) <= set(found.search.final.names)


def test_what_leaves_least_is_tried_with_a_second_effect_although_it_is_unlikely_alone(diagnosis) -> None:
    """A walk makes noise of two effects as well as of what one of them leaves, so that alone neither is called for."""
    found = diagnosis("bias_step")
    bench, base, first = found.bench, found.search.base, found.search.steps[0]
    own = replace(next(trial for trial in first.trials if trial.screened.name == "bias_step"), evidence=-ACCEPT - 1.0)
    louder = Trial(own.screened, bench.add(base, "supply_voltage"), -ACCEPT - 0.5, True)
    assert _singles(Search(base, base, [replace(first, trials=[louder, own])])) == [own]
    assert _singles(Search(base, base, [replace(first, trials=[louder, own]), Step(own.solved, [], ACCEPT)])) == [], "not twice"
    better = [replace(louder, evidence=3.0 - i, solved=replace(louder.solved)) for i in range(PAIRED)]
    glance = replace(louder, evidence=9.0, refitted=False)
    assert _singles(Search(base, base, [replace(first, trials=[*better, own, glance])])) == [*better[:-1], own], "among however many"
    assert _singles(Search(base, base, [replace(first, trials=[own, glance])])) == [own, glance], "one that was only looked at where there is room"
    assert _singles(Search(base, base, [replace(first, trials=[replace(glance, evidence=-7.0)])])) == []


def test_what_was_asked_beside_the_very_same_model_is_not_asked_again(diagnosis, monkeypatch) -> None:
    found = diagnosis("bias_step")
    first = found.search.steps[0]
    names = [trial.screened.name for trial in first.trials if trial.screened.name != "aging"]
    monkeypatch.setattr(search, "screen", None)
    again = _looked_at(found.bench, found.search, first.before, names)
    assert [one.screened.name for one in again] == sorted(names, key=[trial.screened.name for trial in first.trials].index)
    assert again[0] is not first.trials[0], "a round stays as it was"
    assert again[0].solved is first.trials[0].solved
    with pytest.raises(TypeError, match="not callable"):
        _looked_at(found.bench, found.search, replace(first.before), names)


@pytest.mark.slow
@pytest.mark.parametrize(("second", "seed"), [("moisture", 2), ("moisture", 3), ("aging", 4)])
def test_an_effect_that_was_bent_to_make_up_for_the_second_is_replaced_when_that_is_found(both, second, seed) -> None:
    """A glass transition or a relaxation, free in shape, stands for a coefficient that grows with temperature and some of a slow drift."""
    found = both("rate_temperature_coupling", 3.5, second, 3.5, seed)
    assert found.search.steps[0].chosen in ("glass_transition", "viscoelastic")
    assert found.verdict == "missing"
    assert set(found.search.missing) == {"rate_temperature_coupling", second}


@pytest.mark.parametrize(("name", "seed", "least"), [("glass_transition", 15, 12.0), ("rate_temperature_coupling", 7, 6.5)])
def test_a_small_effect_is_seen_at_a_glance_although_the_coil_has_bent_to_it(runs, catalogue, base, name, seed, least) -> None:
    """Of half the white noise of a block, nearly all that a refit finds: at the coil of a model without it, it explains nothing."""
    bench = open_bench(runs(name, seed, 0.5), base, catalogue)
    bent = bench.begin(tuple(base))
    assert bent.rms < 1.2 * bench.mixtures.white
    (trial,) = glances(bench, bent, screen(bench, bent, [name]))
    glance = trial.evidence
    refit(bench, bent, [trial], lambda _: None)
    assert glance > max(least, 0.9 * trial.evidence)


def test_what_is_not_called_for_beside_the_others_is_dropped(diagnosis) -> None:
    found = diagnosis("bias_step")
    bench, base = found.bench, found.search.base
    for more in ("supply_voltage", "magnetic"):
        search = Search(base, bench.add(bench.add(base, more), "bias_step"))
        _drop(bench, search)
        assert search.missing == ["bias_step"]


def test_what_is_left_alone_when_another_is_dropped_is_not_asked_again(diagnosis, monkeypatch) -> None:
    """Of one alone the first round has said whether it is called for, by less evidence."""
    found = diagnosis("bias_step")
    bench, base = found.bench, found.search.base
    both = Search(base, bench.add(bench.add(base, "supply_voltage"), "magnetic"))
    monkeypatch.setattr(type(bench), "evidence", lambda *_: 0.0)
    _drop(bench, both)
    assert both.missing == ["magnetic"]


def test_the_likeliest_are_refitted_in_the_place_of_one_however_they_come() -> None:
    """Rounds have them in the order of what they gain by projection, or of what they were worth under another noise."""
    trials = [Trial(SimpleNamespace(name=str(worth)), None, worth, False) for worth in (1.0, 30.0, 25.0, 3.0, 40.0, 20.0)]
    assert [trial.evidence for trial in in_reach(trials, 30.0)] == [40.0, 30.0, 25.0]
    assert [trial.evidence for trial in in_reach(trials, 54.0)] == [40.0]


@pytest.mark.parametrize(("own", "found"), [(39.0, [40.0, 30.0, 25.0]), (45.0, [40.0, 25.0]), (51.0, [40.0]), (15.0, [40.0, 30.0, 25.0])])
def test_what_looks_alike_is_refitted_from_half_the_evidence(own, found) -> None:
    """It explains little at a coil which the one in its place has bent."""
    trials = [Trial(SimpleNamespace(name=str(worth)), None, worth, False) for worth in (1.0, 30.0, 25.0, 3.0, 40.0)]
    assert [trial.evidence for trial in in_reach(trials, own, {"25.0", "3.0"})] == found


def test_each_that_was_added_is_held_against_what_looks_like_it(diagnosis, monkeypatch) -> None:
    found = diagnosis("bias_step")
    bench, base, asked = found.bench, found.search.base, []
    pair = Search(base, bench.add(bench.add(base, "bias_step"), "viscoelastic"))
    monkeypatch.setattr(search, "in_reach", lambda trials, own, alike=(): asked.append(set(alike)) or [])
    search._exchange(bench, pair, [], lambda _: None)
    assert asked == [{"aging"}, {"hysteresis", "moisture", "aging", "sensor_lag", "glass_transition"}]


def test_effects_look_alike_where_one_of_them_says_so(catalogue) -> None:
    bench = SimpleNamespace(effects=catalogue)
    assert "thermal_gradient" in Workbench.look_alikes(bench, "sensor_lag")
    assert "hysteresis" in Workbench.look_alikes(bench, "viscoelastic")
    assert "viscoelastic" in Workbench.look_alikes(bench, "hysteresis")
    assert not Workbench.look_alikes(bench, "polarization")


def test_a_walk_that_comes_back_to_where_it_was_ends(monkeypatch) -> None:
    """Of two that are nearly alike each may take the place of the other."""
    base, one, other = (SimpleNamespace(names=names) for names in (("s",), ("s", "a"), ("s", "b")))
    asked = []

    def beside(_, now, *__):
        asked.append(now.names)
        assert len(asked) < 5, "it goes round"
        return SimpleNamespace(before=now, chosen=None)

    def chosen(_, __, step):
        taken = other if step.before is one else one
        return SimpleNamespace(solved=taken, screened=SimpleNamespace(name=taken.names[-1]))

    monkeypatch.setattr(search, "_round_beside", beside)
    monkeypatch.setattr(search, "chosen_of", chosen)
    monkeypatch.setattr(search, "finished", lambda _, __, solved: solved)
    monkeypatch.setattr(search, "pruned", lambda _, full, __: full)
    monkeypatch.setattr(search, "out_of_reach", lambda *_: False)
    found = Search(base, base)
    search._forward(None, found, [], print)
    assert asked == [("s",), ("s", "a"), ("s", "b")]
    assert found.missing == ["a"]


def test_what_was_fitted_further_in_an_earlier_round_is_remembered(diagnosis) -> None:
    found = diagnosis("bias_step")
    bench, base, first = found.bench, found.search.base, found.search.steps[0]
    old = next(trial for trial in first.trials if trial.refitted)
    glance, better = Trial(old.screened, None, old.evidence - 3.0, False), Trial(old.screened, None, old.evidence + 3.0, False)
    _remember(bench, Search(base, base, [first]), base, [glance, better])
    assert (glance.solved, glance.refitted) == (old.solved, True)
    assert glance.evidence == pytest.approx(old.evidence, abs=1e-6)
    assert (better.solved, better.refitted) == (None, False)
    mixed, other = bench.with_noise(bench.noise).solve(base.names[::-1]), Trial(old.screened, None, old.evidence - 3.0, False)
    _remember(bench, Search(base, base, [first]), mixed, [other])
    assert not other.refitted, "its parameters are in another order"
    elsewhere = Trial(old.screened, None, old.evidence - 3.0, False)
    _remember(bench, Search(base, base, [first]), bench.add(base, "warm_up"), [elsewhere])
    assert not elsewhere.refitted, "beside other effects it is another question"


def test_a_single_effect_that_leaves_noise_is_taken_before_any_two(diagnosis) -> None:
    found = diagnosis("bias_step")
    bench, base, first = found.bench, found.search.base, found.search.steps[0]
    wrong = bench.add(base, "supply_voltage")
    search = Search(base, wrong, [replace(first, chosen="supply_voltage")])
    assert single(bench, search)
    assert (search.missing, search.steps[0].chosen) == (["bias_step"], "bias_step")
    quiet = diagnosis("")
    assert not single(quiet.bench, Search(quiet.search.base, quiet.search.base, [quiet.search.steps[0]])), "the base is noise, but nothing is evident"


def test_what_lowers_no_rms_must_predict_pieces_better_or_be_overwhelming(diagnosis) -> None:
    """As beside slow noise: what is fast goes, and the residual, which mostly wanders, becomes no smaller."""

    def convincing(hidden: str, name: str) -> list[bool]:
        found = diagnosis(hidden)
        bench, base = found.bench, found.search.base
        louder = replace(bench.add(base, name))
        louder.__dict__["residual"] = louder.residual * 1.01 * base.rms / louder.rms
        assert louder.rms > base.rms
        trial = replace(found.search.steps[0].trials[0], solved=louder, refitted=True)
        return believed(bench, base, trial, 30.0, 60.0)

    assert convincing("bias_step", "bias_step") == [True, True]
    assert convincing("", "magnetic") == [False, True]


@pytest.mark.parametrize(("rms", "noise", "chosen"), [(1.4, False, 0), (1.6, True, 0), (1.6, False, 1)])
def test_the_likeliest_is_taken_unless_it_leaves_more_than_noise(monkeypatch, rms, noise, chosen) -> None:
    """Beside much flicker noise what is left is far above the white noise, and still nothing else is missing."""
    bench = SimpleNamespace(mixtures=SimpleNamespace(white=1.0))
    trials = [
        Trial(SimpleNamespace(name=name), SimpleNamespace(rms=rms, cost=cost), evidence, True)
        for name, evidence, cost in (("a", 30.0, 2.0), ("b", 20.0, 1.0))
    ]
    monkeypatch.setattr(acceptance, "segment_cost", lambda _, solved: solved.cost)
    monkeypatch.setattr(acceptance, "leaves_noise", lambda *_: noise)
    assert acceptance.best_of(bench, SimpleNamespace(), trials) is trials[chosen]
    assert acceptance.best_of(bench, SimpleNamespace(), trials[1:]) is trials[1]
    assert acceptance.best_of(bench, SimpleNamespace(), []) is None
    trials[0].solved.cost = 0.5
    monkeypatch.setattr(acceptance, "leaves_noise", None)
    assert acceptance.best_of(bench, SimpleNamespace(), trials) is trials[0], "no need to know where it predicts best as well"


def test_the_first_addition_needs_less_evidence_than_one_that_might_correct_it(diagnosis) -> None:
    """Beside nothing there is no simplified form to make up for; the share asked for is the same for all candidates of a round."""
    found = diagnosis("bias_step").search
    first, last = found.steps[0], found.steps[-1]
    assert (first.accept, last.accept) == (accepted(found.base, found.base), accepted(found.base, found.final)) == (FIRST, ACCEPT)
    assert first.needed == pytest.approx(FIRST + math.log(len(first.trials)))
    bench, own = diagnosis("bias_step").bench, replace(first.trials[0], solved=found.final, refitted=True)
    few = [replace(own, evidence=evidence) for evidence in (first.needed - 0.1, first.needed + 0.1)]
    quiet = replace(found.base)
    quiet.__dict__["residual"] = found.base.residual * bench.mixtures.white / found.base.rms  # so that it might be noise, which less would do for
    assert [convinces(bench, quiet, replace(first, before=quiet), one) for one in few] == [False, True]
    assert not convinces(bench, quiet, replace(first, before=quiet, accept=ACCEPT), few[1])


def test_no_set_with_more_in_it_is_likelier_than_what_was_named(diagnosis) -> None:
    """Not even where the evidence is for more, but the search took that for a correction of what was there."""
    found = diagnosis("bias_step")
    *others, last = found.search.steps
    assert set(last.before.names) == set(found.search.final.names)
    further = next(trial for trial in last.trials if trial.screened.name != "bias_step_2")
    refused = Step(last.before, [replace(further, evidence=60.0, refitted=True), *(one for one in last.trials if one is not further)], last.accept)
    listed = hypotheses(replace(found.search, steps=[*others, refused]), found.structure, 0.0, found.bench.effects)
    chances = {one.effects: one.probability for one in listed if not one.faint}
    more = tuple(sorted(["bias_step", further.screened.name]))
    assert chances[("bias_step",)] >= chances[more] > 0.4, "half believed"
    assert listed[0].effects == ("bias_step",)


def test_what_makes_noise_of_the_rest_needs_less_evidence_than_what_noise_would_do_without(diagnosis) -> None:
    found = diagnosis("bias_step")
    bench, base, final = found.bench, found.search.base, found.search.final
    trial = replace(found.search.steps[0].trials[0], solved=final, refitted=True)
    assert believed(bench, base, trial, -1.0, 1.0) == [False, True], "the base alone is no noise"
    quiet = diagnosis("")
    more = quiet.bench.add(quiet.search.base, "bias_step")
    assert believed(quiet.bench, quiet.search.base, replace(trial, solved=more), 1.0) == [False], "there it is"


def test_where_a_walk_would_do_what_takes_most_away_needs_strong_evidence_but_not_for_every_candidate(diagnosis) -> None:
    """Of noise that walks a slow effect leaves little, as chance would have it; 1100 : 1 is enough then, however many effects were tried."""
    quiet = diagnosis("")
    bench, base = quiet.bench, quiet.search.base
    more = bench.add(base, "bias_step")
    for share, expected in ((0.6, [False, True, True]), (0.9, [False, False, True])):
        less = replace(more)
        less.__dict__["residual"] = more.residual * share * base.rms / more.rms
        trial = replace(quiet.search.steps[0].trials[0], solved=less, refitted=True)
        assert believed(bench, base, trial, ACCEPT - 1.0, ACCEPT + 1.0, ACCEPT + 4.0) == expected


def test_an_addition_on_little_evidence_that_noise_was_no_alternative_to_is_believed(diagnosis) -> None:
    found = diagnosis("bias_step")
    first, *others = found.search.steps
    own = next(trial for trial in first.trials if trial.screened.name == "bias_step")
    rest = [replace(trial, evidence=-5.0) for trial in first.trials if trial is not own]
    little = Step(first.before, [replace(own, evidence=2.0), *rest], first.accept, first.chosen)
    listed = hypotheses(replace(found.search, steps=[little, *others]), found.structure, 0.0, found.bench.effects)
    assert listed[0].effects == ("bias_step",)
    assert listed[0].probability > 0.8


@pytest.mark.parametrize("name", ["polarization", "hysteresis"])
def test_an_effect_that_is_in_the_model_from_the_start_is_fitted_as_well_as_one_that_is_added(simulation, catalogue, base, name) -> None:
    """Fringes of another period than the declared one are found by a search, not by steps from there."""
    runs = [as_run(recorded) for recorded in simulation(name, 1, 6.0).runs]
    bench = open_bench(runs, [*base, name], catalogue)
    begun = bench.begin((base[0], name, *base[1:]))
    added = open_bench(runs, [*base, name], catalogue)
    assert begun.fit.total <= added.add(added.solve(tuple(base)), name).fit.total + 1.0
    assert begun.rms < 1.1 * bench.mixtures.white


@pytest.mark.parametrize(("per_rate", "slope"), [(0.012, 1e-4), (0.02, 2e-4)])
def test_beside_a_base_that_leaves_the_coil_unknown_an_effect_is_seen(runs, catalogue, per_rate, slope) -> None:
    """A gyro that was compensated: its coil's lag moves so small a slope by less than the noise, and must not stand for one of five times that."""
    chance, planted = Generator().manual_seed(1), []
    for run in runs(""):
        coil = GrayBox({"mohr": catalogue["mohr"]}, list(run.columns))
        history = coil.histories(run.select(coil.inputs), coil.coil_value.detach(), 1)["coil"]
        noise = torch.randn(len(run.error), generator=chance, dtype=torch.float64) * 0.018 * (int((run.block >= 0).sum()) / run.blocks) ** 0.5
        planted.append(replace(run, error=0.01 + slope * (history.temperature - 20) + per_rate * history.rate + noise))
    found = diagnose(planted, ["static_bias"], catalogue)
    assert found.verdict == "missing"
    (named,) = found.search.missing
    twins = {one["effect"]: one["indistinguishable_from"] for one in found.record["candidates"]}
    assert "mohr" in {named, *twins[named]}
    assert twins[named], "else there is nothing to tell apart"
    assert all(twins[other] == [named] for other in twins[named]), "neither from the other"


@pytest.mark.parametrize(("evidence", "counts"), [(50.0, True), (30.0, False)])
def test_white_noise_is_what_an_overwhelming_addition_leaves_although_it_was_refused(simulation, catalogue, base, evidence, counts) -> None:
    """A fast line enlarges the differences that white noise is read off."""
    bench = open_bench([as_run(one) for one in simulation("chamber_cycling", 1, 20.0).runs], base, catalogue)
    start = bench.begin(tuple(base))
    added = bench.add(start, "chamber_cycling")
    trial = Trial(Screened("chamber_cycling", torch.zeros(1), 0.0, 0), added, evidence, True)
    found = Search(start, start, [Step(start, [trial], 5.0)])
    alone, beside = (_white(bench, Search(one, one)) for one in (start, added))
    assert beside < 0.5 * alone
    assert _white(bench, found) == (beside if counts else alone)


@pytest.mark.parametrize("exponent", [0.4, 0.6, 0.8])
def test_a_drift_by_a_power_of_time_is_ageing_and_nothing_else(simulation, catalogue, base, white, exponent) -> None:
    """A logarithm misses it by 1 to 2 %, of forty times the noise as much as a warm-up of half the noise."""
    runs = [as_run(one) for one in simulation("", 1).runs]
    drifts = [((run.time - run.time[0]) / 36000.0) ** exponent for run in runs]
    runs = [replace(run, error=run.error + 80.0 * white * drift) for run, drift in zip(runs, drifts, strict=True)]
    found = diagnose(runs, base, catalogue)
    assert (found.verdict, found.search.missing) == ("missing", ["aging"])
    bend = found.record["parameters"]["aging"]["bend"]["value"]
    assert 1.0 - 0.7 * bend == pytest.approx(exponent, abs=0.05)


def test_a_loop_that_goes_on_from_run_to_run_is_known_by_it(simulation, catalogue, base, white) -> None:
    """The second run begins where the coil's way through the first has left it, not as from room temperature."""
    recorded = simulation("").runs
    coils = [one.truth["temperature_coil_c"] for one in recorded]
    turns = before_each([(one.truth["time_s"], coil) for one, coil in zip(recorded, coils, strict=True)]).turns
    width, past = torch.tensor([[8.0], [-1.0]], dtype=torch.float64)
    loops = [torch.tanh((play(coil, width, past, before) - 20.0) / 30.0) for coil, before in zip(coils, turns[:-1], strict=True)]
    runs = [as_run(one) for one in recorded]
    record = diagnose([replace(run, error=run.error + 30 * white * loop) for run, loop in zip(runs, loops, strict=True)], base, catalogue).record
    assert record["missing"] == ["hysteresis"]
    assert record["parameters"]["hysteresis"]["past"]["value"] < -0.5
    assert record["rms_final"] < 1.1 * record["noise_floor"]


def test_what_was_found_while_another_was_missing_is_looked_for_anew(runs, base, catalogue) -> None:
    """A warm-up that stands for a step as well is five times too slow; no other time of its grid leads lower than where the search ends."""
    few = {name: catalogue[name] for name in (*base, "warm_up", "bias_step", "aging", "moisture")}
    bench = open_bench(runs("warm_up+bias_step"), base, few)
    found = search.search(bench, bench.begin(tuple(base)), [name for name in few if name not in base])
    assert set(found.missing) == {"warm_up", "bias_step"}
    owners = [(owner, one.name) for owner, one in found.final.model.parameters_of_theta()]
    place = owners.index(("warm_up", "time"))
    for time in torch.linspace(0.2, 0.9, 6).tolist():
        start = found.final.fit.theta.clone()
        start[place] = time
        assert bench.fitted(found.final.names, [start]).total > found.final.fit.total - 1.0
