"""The second search, under the noise that the first one found."""

from __future__ import annotations

from dataclasses import replace

import pytest

from zoo.diagnosis import settle, trials
from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.search import Search, search
from zoo.diagnosis.settle import reweighed
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import leaves_noise
from zoo.diagnosis.workbench import Workbench
from zoo.scoring.noise import NoiseModel


@pytest.fixture(scope="module")
def first():
    """A search to its end, and the same runs with four times the flicker and a walk."""
    made = {}

    def of(runs, base, catalogue, hidden: str):
        if hidden not in made:
            few = {name: catalogue[name] for name in (*base, "hysteresis", "aging", "bias_step", "moisture")}
            bench = open_bench(runs(hidden), base, few)
            candidates = [name for name in few if name not in base]
            noise = bench.noise
            again = bench.with_noise(NoiseModel(noise.white, 4 * noise.flicker, 0.2 * noise.white))
            made[hidden] = bench, search(bench, bench.begin(tuple(base)), candidates), again, candidates
        return made[hidden]

    return of


@pytest.mark.parametrize("hidden", ["hysteresis", "bias_step", "", "hysteresis+aging"])
def test_it_ends_where_a_whole_one_ends(first, runs, base, catalogue, monkeypatch, hidden) -> None:
    bench, found, again, candidates = first(runs, base, catalogue, hidden)
    by_itself = bench.with_noise(again.noise)
    whole = search(by_itself, by_itself.begin(tuple(base)), candidates)
    monkeypatch.setattr(trials, "screen", None)
    straight = reweighed(again, found)
    assert straight is not None
    assert straight.missing == whole.missing
    assert set(straight.missing) == set(hidden.split("+") if hidden else [])
    assert straight.base.fit.total == pytest.approx(whole.base.fit.total, abs=0.5)
    assert straight.final.fit.total == pytest.approx(whole.final.fit.total, abs=0.5)
    for mine, other in zip(straight.steps, whole.steps, strict=True):
        assert mine.chosen == other.chosen
        best, its = mine.trials[0], other.trials[0]
        if mine.chosen:
            assert best.evidence == pytest.approx(its.evidence, abs=1.0)
        else:
            assert max(best.evidence, its.evidence) < mine.needed - 3.0, "noise, of which each may see another part"


def test_no_round_of_the_first_search_is_changed(first, runs, base, catalogue) -> None:
    _, found, again, _ = first(runs, base, catalogue, "hysteresis")
    before = [(step.chosen, [(trial.screened.name, trial.evidence, trial.solved) for trial in step.trials]) for step in found.steps]
    reweighed(again, found)
    assert [(step.chosen, [(trial.screened.name, trial.evidence, trial.solved) for trial in step.trials]) for step in found.steps] == before


def test_where_another_comes_first_but_all_end_alike_the_end_alone_is_asked(first, runs, base, catalogue, monkeypatch) -> None:
    _, found, again, _ = first(runs, base, catalogue, "hysteresis+aging")
    assert settle._beyond_the_end(found) == [], "straight"
    straight, beside = reweighed(again, found), set(found.base.names)
    chosen = settle.chosen_of

    def otherwise(bench, base, step):
        return step.trials[1] if set(step.before.names) == beside else chosen(bench, base, step)

    monkeypatch.setattr(trials, "screen", None)
    monkeypatch.setattr(settle, "chosen_of", otherwise)
    ended = reweighed(again, found)
    assert ended is not None
    assert ended.steps[0].chosen not in (found.steps[0].chosen, None)
    assert ended.missing == straight.missing == ["hysteresis", "aging"]
    assert ended.final.fit.total == pytest.approx(straight.final.fit.total, abs=0.5)
    assert [step.chosen for step in ended.steps[1:]] == [*ended.missing, None]


def test_where_it_would_decide_otherwise_there_is_none(first, runs, base, catalogue, monkeypatch) -> None:
    _, found, again, _ = first(runs, base, catalogue, "hysteresis")
    assert reweighed(again, replace(found, steps=found.steps[:-1])) is None, "nobody asked what else may be missing"
    with monkeypatch.context() as patched:
        patched.setattr(settle, "chosen_of", lambda _, __, step: step.trials[0])
        assert reweighed(again, found) is None, "one more would be added"
    monkeypatch.setattr(settle, "leaves_noise", lambda *_: False)
    assert reweighed(again, found) is None


def test_the_end_of_a_search_that_took_something_back_is_asked_alone(runs, base, catalogue, monkeypatch) -> None:
    """What viscoelastic stress stood for is known in the end; its rounds need not be asked again."""
    few = {name: catalogue[name] for name in (*base, "rate_temperature_coupling", "moisture", "glass_transition", "viscoelastic", "aging")}
    candidates = [name for name in few if name not in base]
    bench = open_bench(runs("rate_temperature_coupling+moisture", 2), base, few)
    louder = NoiseModel(bench.noise.white, 4 * bench.noise.flicker, 0.2 * bench.noise.white)
    by_itself, again = bench.with_noise(louder), bench.with_noise(louder)
    found = search(bench, bench.begin(tuple(base)), candidates)
    assert found.steps[0].chosen == "viscoelastic"
    whole = search(by_itself, by_itself.begin(tuple(base)), candidates)
    monkeypatch.setattr(trials, "screen", None)
    ended = reweighed(again, found)
    assert ended is not None
    assert set(ended.missing) == set(whole.missing) == {"rate_temperature_coupling", "moisture"}
    assert ended.final.fit.total == pytest.approx(whole.final.fit.total, abs=0.5)
    assert [step.chosen for step in ended.steps[1:]] == [*ended.missing, None]
    for name in ended.missing:
        mine, its = (next(step for step in one.steps[::-1] if set(step.before.names) == {*whole.final.names} - {name}) for one in (ended, whole))
        assert mine.trials[0].screened.name == its.trials[0].screened.name == name
        assert mine.trials[0].evidence == pytest.approx(its.trials[0].evidence, abs=1.0)
        assert mine.before.fit.total < its.before.fit.total + 1.0, "fitted as far"
    with monkeypatch.context() as patched:
        patched.setattr(settle, "replacement", lambda _, __, step, own: next(trial for trial in step.trials if trial is not own))
        assert reweighed(again, found) is None, "another takes the place of one"
    monkeypatch.setattr(settle, "_less", lambda bench, _, before: bench.solve(before.names[::-1], [before.fit.theta]))
    assert reweighed(again, found) is None, "what was tried beside it has its parameters in another order"


@pytest.mark.parametrize(("name", "place"), [("polarization", 0), ("warm_up", 1)])
def test_what_lacks_an_effect_is_fitted_as_far_as_what_has_it(runs, base, catalogue, name, place) -> None:
    """From a shape in another valley, of a warm-up in the first run: fitted on from there alone, it would make the effect that it lacks a hundred
    times likelier, and more."""
    few = {one: catalogue[one] for one in (*base, name)}
    bench, afresh = (open_bench(runs(name), base, few) for _ in range(2))
    start = bench.begin(tuple(base))
    there = bench.add(start, name)
    astray = bench.peek(start, name, bench.shapes(name)[place])
    assert afresh.fitted(astray.names, [astray.fit.theta]).total > there.fit.total + 100.0
    assert settle._less(afresh, Search(start, there), astray).fit.total < there.fit.total + 1.0


def test_what_led_nowhere_is_not_tried_again_under_other_weights(first, runs, base, catalogue, monkeypatch) -> None:
    """A line in temperature, which nothing in this small catalogue has: a whole search ends at the same as well."""
    bench, found, again, candidates = first(runs, base, catalogue, "polarization")
    assert settle._beyond_the_end(found)
    by_itself = bench.with_noise(again.noise)
    whole = search(by_itself, by_itself.begin(tuple(base)), candidates)
    with monkeypatch.context() as patched:
        for way in ("single", "by_evidence", "pair"):
            patched.setattr(settle, way, None)
        straight = reweighed(again, found)
    assert straight is not None
    assert straight.missing == whole.missing
    assert not leaves_noise(again, straight.final, straight.base)
    assert not leaves_noise(by_itself, whole.final, whole.base)
    monkeypatch.setattr(settle, "leaves_noise", lambda *_: True)
    assert reweighed(again, found) is None, "it leads somewhere now"


def test_where_nothing_leads_to_noise_every_way_is_tried_again_on_other_runs(first, runs, base, catalogue, monkeypatch) -> None:
    """What two effects at once come to is fitted on as well."""
    bench, found, _, candidates = first(runs, base, catalogue, "polarization")
    assert not leaves_noise(bench, found.final, found.base)
    again, by_itself = (bench.with_runs(list(bench.runs), 1.05 * bench.mixtures.white, 0.0) for _ in range(2))
    whole = search(by_itself, by_itself.begin(tuple(base)), candidates)
    pairs = settle._beyond_the_end(found)
    assert pairs
    with monkeypatch.context() as patched:
        patched.setattr(trials, "screen", None)
        straight = reweighed(again, found)
    assert straight is not None
    assert not leaves_noise(again, straight.final, straight.base)
    assert straight.missing == whole.missing
    assert {step.before.names for step in straight.steps} == {step.before.names for step in whole.steps}
    assert straight.final.rms == pytest.approx(whole.final.rms, rel=0.02)
    monkeypatch.setattr(settle, "pair", lambda _, search, *__: search.keep(pairs[0].before))
    assert reweighed(again, found) is None, "two at once lead to noise now"


def test_a_search_in_too_much_noise_is_given_up_as_soon_as_it_is_seen(runs, base, catalogue) -> None:
    """What a compressor drives is fast, and differences of the error are mostly that; once it is in the model, the rest tells the noise."""
    few = {name: catalogue[name] for name in (*base, "chamber_cycling", "aging", "hysteresis")}
    bench = open_bench(runs("chamber_cycling", noises=20.0), base, few)
    candidates = [name for name in few if name not in base]
    whole = search(bench, bench.begin(tuple(base)), candidates)
    assert settle._white(bench, whole) < settle.QUIETER * bench.mixtures.white
    given_up = search(bench, bench.begin(tuple(base)), candidates, in_vain=lambda found: bool(found.path))
    assert [step.chosen for step in given_up.steps] == ["chamber_cycling"]
    assert len(whole.steps) > 1
    quiet, found = settle.settle(bench, tuple(base), candidates)
    assert found.missing == ["chamber_cycling"]
    assert quiet.mixtures.white == pytest.approx(settle._white(quiet, found), rel=0.1)


def test_two_that_only_a_walk_lets_be_told_apart_are_found(runs, base, catalogue, monkeypatch) -> None:
    few = {name: catalogue[name] for name in (*base, "bias_step", "moisture", "aging", "warm_up")}
    candidates = [name for name in few if name not in base]
    bench = open_bench(runs("aging+bias_step", seed=2, noises=15), base, few)
    as_if_white = search(bench, bench.begin(tuple(base)), candidates)
    assert bench.mixtures.much_walk(as_if_white.final.likely.noise)
    assert not leaves_noise(bench, as_if_white.final, as_if_white.base)
    settled, found = settle.settle(bench, tuple(base), candidates)
    assert set(found.missing) == {"aging", "bias_step"}
    assert leaves_noise(settled, found.final, found.base)
    assert settled.noise.walk < 0.2 * settled.noise.white, "weighed by what is left, not by the walk that helped to find it"
    monkeypatch.setattr(settle, "_again", lambda again, other, *_: Search(other.base, other.base))
    walking, found = settle._beside_a_walk(bench, as_if_white, candidates, lambda _: None)
    assert set(found.missing) == {"aging", "bias_step"}, "what no longer leaves noise is not taken"
    assert bench.mixtures.much_walk(walking.noise)

    def nowhere(_: Workbench, start: Solved, *__: object, pairs: bool = True) -> Search:
        assert not pairs, "two at once were tried before"
        return Search(start, start)

    monkeypatch.setattr(settle, "search", nowhere)
    assert settle._beside_a_walk(bench, as_if_white, candidates, lambda _: None)[1] is as_if_white
