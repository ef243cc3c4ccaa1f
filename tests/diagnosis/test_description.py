"""What is said of an effect that nothing in the catalogue is, and whether the form found makes the model complete."""

from __future__ import annotations

import json
import sys
from dataclasses import replace

import pytest
import torch
from torch import Generator

from zoo.catalog import build
from zoo.diagnosis.curve import fitted
from zoo.diagnosis.description import describe
from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.diagnosis.form_search import FormBench
from zoo.diagnosis.form_words import shape_of
from zoo.diagnosis.forms import EVEN, ODD
from zoo.diagnosis.free_functions import functions_of, weigh
from zoo.diagnosis.quantities import RATE
from zoo.diagnosis.refine import refine
from zoo.diagnosis.restless import correlation_time
from zoo.effects.bounds import to_physical
from zoo.effects.checks import check_effect
from zoo.models.graybox import GrayBox
from zoo.physics.lag import lagged
from zoo.report.unknown_stub import stub_of, write_stub
from zoo.report.verdict import verdict_of
from zoo.simulator.in_process import as_run

BASE = ("static_bias", "shupe", "mohr")
PLANTED = {
    "square": lambda time, coil, rate: rate.square(),
    "size": lambda time, coil, rate: rate.abs(),
    "root": lambda time, coil, rate: rate.abs().sqrt(),
    "cube": lambda time, coil, rate: rate**3,
    "friction": lambda time, coil, rate: torch.tanh(rate / 0.1),
    "by_temperature": lambda time, coil, rate: coil * rate.square(),
    "highest": lambda time, coil, rate: torch.cummax(coil, dim=0).values,
    "memory": lambda time, coil, rate: lagged(time, rate.abs(), torch.tensor(2400.0, dtype=torch.float64)),
    "summed": lambda time, coil, rate: (coil - 20.0).cumsum(dim=0),
    "line": lambda time, coil, rate: torch.sin(2 * torch.pi * time / 5000),
}
SAID = {
    "square": ("the size of the temperature rate", "as its square (exponent"),
    "size": ("the size of the temperature rate", "in proportion to the size of the temperature rate, the same for heating and cooling"),
    "root": ("the size of the temperature rate", "the same for heating and cooling, about as its square root"),
    "cube": ("the coil's temperature rate", "It changes sign with"),
    "friction": ("the coil's temperature rate", "and hardly grows beyond 0.1 K/min, like friction"),
    "by_temperature": ("the coil's temperature and its rate together", "through zero near"),
    "highest": ("the highest temperature so far", "in proportion to the highest temperature so far"),
    "memory": ("the size of the temperature rate of the last half hour", "with a memory of"),
    "summed": ("the temperature summed over time", "the temperature summed over time"),
    "line": ("time that recurs every", "It recurs every 5000 s"),
}


@pytest.fixture
def all_with_planted(simulation, white):
    """The fitted runs and the check run, the last, with something added that is eight times the white noise of a block."""

    def planted(key: str):
        recorded, added = [*simulation().runs, simulation().check], []
        for one in recorded:
            time, coil = one.truth["time_s"], one.truth["temperature_coil_c"]
            added.append(PLANTED[key](time - time[0], coil, torch.gradient(coil, spacing=(time / 60,))[0]))
        scale = 8 * white / torch.cat(added[:-1]).std()
        return [replace(as_run(one), error=as_run(one).error + scale * more) for one, more in zip(recorded, added, strict=True)]

    return planted


@pytest.fixture
def with_planted(all_with_planted):
    """The fitted runs of these."""
    return lambda key: all_with_planted(key)[:-1]


@pytest.fixture(scope="module")
def told():
    """What is said of a thing that was planted, each described once."""
    return {}


@pytest.fixture
def described(told, with_planted, catalogue):
    """The bench of the fitted runs, and what is said of them."""

    def of(key: str):
        if key not in told:
            bench = open_bench(with_planted(key), list(BASE), catalogue)
            told[key] = bench, describe(bench, bench.solve(BASE))
        return told[key]

    return of


@pytest.fixture
def telegraph(runs, white):
    chance, found = Generator().manual_seed(7), []
    for run in runs():
        flips = torch.rand(len(run.time), generator=chance, dtype=torch.float64) < 20.0 / 1500.0
        found.append(replace(run, error=run.error + 6 * white * (1.0 - 2.0 * (flips.cumsum(0) % 2))))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("key", PLANTED)
def test_what_was_planted_is_described_and_accounted_for(described, white, key) -> None:
    bench, found = described(key)
    assert found.best is not None
    assert found.dependences[0]["depends_on"].startswith(SAID[key][0])
    assert SAID[key][1] in found.words
    assert found.dependences[0]["explains"] > 0.9
    assert found.form["rms"] < 1.15 * white < 3 * white < bench.solve(BASE).rms
    check_effect(found.best.effect, found.best.effect.name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("error_of", "said"),
    [(lambda rate: rate**3, "about as its cube (exponent"), (lambda rate: torch.tanh(rate / 0.6), "hardly grows beyond 0.6")],
    ids=["cube", "saturated"],
)
def test_what_is_large_is_told_as_simply_as_what_is_small(simulation, with_error_of, catalogue, white, error_of, said) -> None:
    """A polynomial follows the errors of the coil's temperature as well, and is likelier for it; it says less."""
    bench = open_bench(with_error_of(simulation().runs, lambda coil, rate: error_of(rate), 30 * white), list(BASE), catalogue)
    assert said in describe(bench, bench.solve(BASE)).words


@pytest.mark.slow
@pytest.mark.parametrize(("key", "form"), [("cube", ODD), ("square", EVEN)])
def test_powers_of_the_rate_are_refitted_whatever_leads(with_planted, catalogue, white, monkeypatch, key, form) -> None:
    """At a coil that has bent to what is missing another quantity may explain more."""
    monkeypatch.setattr(FormBench, "_leading", lambda _: [])
    bench = open_bench(with_planted(key), list(BASE), catalogue)
    best = FormBench(bench, bench.solve(BASE)).best()
    assert (best.form, best.quantity) == (form, RATE)
    assert best.solved.rms < 1.15 * white


@pytest.mark.slow
@pytest.mark.parametrize("key", ["square", "by_temperature", "highest", "summed"])
def test_the_class_that_is_written_makes_the_model_complete(described, all_with_planted, catalogue, tmp_path, monkeypatch, key) -> None:
    *fitted_runs, check = all_with_planted(key)
    bench, found = described(key)
    write_stub({"unit": "dph", "rms": bench.solve(BASE).rms, **found.record()}, tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "unexplained", raising=False)
    effect = build("effects", "unexplained", [tmp_path / "conf"])
    monkeypatch.delitem(sys.modules, "unexplained", raising=False)
    check_effect(effect, "unexplained")
    record = refine(fitted_runs, [check], list(BASE), "unexplained", {**catalogue, "unexplained": effect}).record
    assert found.complete is not None
    assert bench.noise_floor(found.complete) == pytest.approx(record["noise_floor"], rel=0.05), "told before as after"
    assert record["ladder"][-1]["rms"] < 1.1 * record["noise_floor"]
    assert record["ladder"][-1]["rms_check"] < 1.1 * record["noise_floor_check"]
    assert record["ladder"][0]["rms_check"] > 3 * record["ladder"][-1]["rms_check"]
    assert record["verdict"] == "complete"


def test_what_helps_may_hide_what_nothing_explains(all_with_planted, catalogue, white, tmp_path) -> None:
    """A fringe in the temperature five times as large: beside it, what the model leaves goes with nothing; with it added, with the rate."""
    runs = [replace(run, error=run.error + 50 * white * torch.cos(2 * torch.pi * run.temperature / 17)) for run in all_with_planted("square")[:-1]]
    few = {name: catalogue[name] for name in (*BASE, "polarization", "hysteresis", "moisture")}
    found = diagnose(runs, list(BASE), few)
    record = found.record
    assert (record["verdict"], record["missing"][0]) == ("unknown", "polarization")
    assert record["unexplained_form"]["effects"] == [*BASE, "polarization"]
    complete = describe(found.bench, next(one for one in found.search.path if one.names[-1] == "polarization")).complete
    assert complete is not None
    assert record["noise_floor"] == found.bench.noise_floor(complete) != found.bench.mixtures.white, "of the model with it"
    assert "the size of the temperature rate" in record["unexplained"][0]["depends_on"]
    said = verdict_of(record)
    assert any("What the model leaves with polarization added: it " in sentence for sentence in said.sentences)
    stub = stub_of(record)
    assert stub is not None
    assert "'add=[polarization,unexplained]'" in stub.commands(tmp_path)[-1]


def test_an_exponent_is_found_with_its_error(described) -> None:
    _, found = described("square")
    exponent = found.form["parameters"]["exponent"]
    assert exponent["value"] == pytest.approx(2.0, abs=0.1)
    assert 0.0 < exponent["stderr"] < 0.1


def test_the_record_is_json(described) -> None:
    bench, found = described("by_temperature")
    again = json.loads(json.dumps(found.record(), allow_nan=False))
    assert [len(curve["x"]) for curve in again["unexplained"][0]["curves"]] == [41, 41, 41]
    assert set(again["unexplained"][0]["by_run"]) == {run.name for run in bench.runs}


def test_a_random_telegraph_is_said_to_be_nothing_smooth(telegraph, catalogue, white) -> None:
    bench = open_bench(telegraph, list(BASE), catalogue)
    found = describe(bench, bench.solve(BASE))
    assert found.best is None
    assert found.form["todo"]
    assert "No smooth function" in found.words
    apart = float(found.words.split("two levels ")[1].split()[0])
    assert apart == pytest.approx(12 * white, rel=0.25), "less what the model took over and what switches within a block"


def test_a_curve_is_what_was_planted_up_to_what_the_model_has(described) -> None:
    """A square: even, zero at zero, four times as high at twice the rate; within its band."""
    _, found = described("square")
    curve = found.dependences[0]["curves"][0]
    x, y = torch.tensor(curve["x"]), torch.tensor(curve["y"])
    amplitude = found.form["parameters"]["coefficient"]["value"]
    square = amplitude * x.square()
    assert torch.allclose(y - y.mean(), square - square.mean(), atol=0.08 * float(square.max()))
    assert all(low <= high for low, high in zip(curve["low"], curve["high"], strict=True))


def test_free_functions_are_means_of_functions(runs, catalogue) -> None:
    """The square of a mean is not the mean of a square: their difference goes with the square of the rate, which no function of temperature is."""
    bench = open_bench(runs(), list(BASE), catalogue)
    free = next(one for one in functions_of(bench, bench.solve(BASE)) if one.words == "the coil's temperature")
    theta = [place["coil"].temperature for place in bench.solve(BASE).design.histories(bench.solve(BASE).fit.theta)]
    place = [2 * (one - free.axis.low) / (free.axis.high - free.axis.low) - 1 for one in theta]
    second = torch.cat([run.block_mean(2 * one.square() - 1) for run, one in zip(bench.runs, place, strict=True)])
    assert torch.allclose(free.columns[:, 1], second, atol=1e-9)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noise_goes_with_nothing(diagnosis, seed) -> None:
    found = diagnosis("", seed)
    final = found.search.final
    functions = functions_of(found.bench, final)
    assert len(functions) > 10
    for free in functions:
        share, evidence = weigh(found.bench, final, free.columns)
        assert evidence < 0.0, free.words
        assert share < 0.08, free.words


def test_what_is_there_already_explains_nothing_more(with_planted, catalogue) -> None:
    bench = open_bench(with_planted("highest"), list(BASE), catalogue)
    base = bench.solve(BASE)
    free = next(one for one in functions_of(bench, base) if one.words == "the highest temperature so far")
    assert weigh(bench, base, free.columns)[1] > 50
    share, evidence = weigh(bench, base, free.columns, beside=free.columns)
    assert share == pytest.approx(0.0, abs=1e-6)
    assert evidence < 0.0
    assert fitted(bench, base, free).left.std() < 0.3 * base.residual.std()


def test_a_correlation_time_is_that_of_the_process() -> None:
    """A first-order process of ten samples: its correlation is exp(−lag/10)."""
    chance, values = torch.randn(200_000, generator=Generator().manual_seed(2), dtype=torch.float64), []
    decay, level = float(torch.exp(torch.tensor(-0.1))), 0.0
    for one in chance.tolist():
        level = decay * level + one
        values.append(level)
    assert correlation_time([torch.tensor(values, dtype=torch.float64)]) == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize(("size", "middle"), [(torch.abs, 0.7), (torch.clone, 0.6)])
def test_the_form_that_is_chosen_is_the_one_that_was_fitted(runs, catalogue, base, size, middle) -> None:
    """Every look at the runs gives a form the range that its quantity has at the coil of the moment."""
    bumped = []
    for run in runs("", 5):
        box = GrayBox({"mohr": catalogue["mohr"]}, list(run.columns))
        history = box.histories(run.select(box.inputs), torch.tensor([200.0, 0.3, 0.0], dtype=torch.float64), 1)["coil"]
        bumped.append(replace(run, error=run.error + 0.15 * torch.exp(-(((size(history.rate) - middle) / 0.25) ** 2))))
    bench = open_bench(bumped, base, catalogue)
    best = FormBench(bench, bench.solve(tuple(base))).best()
    solved, name = best.solved, best.effect.name
    shape = to_physical(solved.fit.theta[-len(best.effect.shape) or len(solved.fit.theta) :], list(best.effect.shape)).unsqueeze(0)
    own = solved.design.effect_columns(best.effect, solved.design.places(solved.fit.theta), shape, lambda columns: columns)[0]
    assert torch.allclose(own, solved.plain_columns[:, solved.places()[name]], rtol=0, atol=1e-9)


def test_places_on_an_axis_keep_the_digits_that_tell_them_apart() -> None:
    """A supply that moves by millivolts would else go "between 5 and 5 V"."""
    curve = {"x": [4.9951, 4.998, 5.0, 5.0049], "y": [0.0, 1.0, -1.0, 0.0]}
    said = shape_of("the column supply_v", "V", curve)
    assert said == "It goes up and down with the column supply_v between 4.9951 and 5.0049 V: highest at 4.998 V and lowest at 5 V."
