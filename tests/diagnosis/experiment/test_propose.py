"""The proposal: the right kind of run, ready for JSON and for the simulator, and what it says when there is nothing to propose."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace

import pytest
import torch

from zoo.diagnosis.alike import MODEL_ERROR
from zoo.diagnosis.diagnose import diagnose
from zoo.diagnosis.experiment.evidence import Told
from zoo.diagnosis.experiment.family import Candidate
from zoo.diagnosis.experiment.prediction import Predicted
from zoo.diagnosis.experiment.proposal import _not_told
from zoo.diagnosis.experiment.propose import ALIKE, DISTINCT, ENOUGH, Weighed, _useful, _worth, choose, propose
from zoo.diagnosis.experiment.rivals import rivals_of
from zoo.diagnosis.parameters import fitted_parameters
from zoo.diagnosis.search import Search, search
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.measurements.run import Run
from zoo.scoring.noise import NoiseModel, Whitener
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import legs
from zoo.simulator.laboratory.program import Program
from zoo.simulator.simulate import Simulation, simulate

EMPTY = Run("", "dph", 1.0, ("time_s",), torch.zeros(0, 1), torch.zeros(0), torch.zeros(0), torch.zeros(0, dtype=torch.int64))


def weighed(name: str, hours: float, **worth: float) -> Weighed:
    program = ((20.0, 20.0, 3600.0 * hours),)
    nothing = Predicted(EMPTY, Whitener(NoiseModel(1.0, 0.0), []), Program(program))
    return Weighed(Candidate(name, "", program), nothing, [], {(int(key[1]), int(key[2])): value for key, value in worth.items()})


def test_nothing_is_promised_where_a_diagnosis_may_call_both_alike_afterwards() -> None:
    """Whatever the evidence: a formula is not exact enough for so small a share of a signal."""
    assert MODEL_ERROR < ALIKE < DISTINCT
    assert _worth(Told(1e6, ALIKE)) == 0.0
    assert _worth(Told(40.0, DISTINCT)) == _worth(Told(40.0, 0.9)) == 40.0
    worth = [_worth(Told(40.0, share)) for share in torch.linspace(0.0, 0.05, 51).tolist()]
    assert worth == sorted(worth)


def test_the_turned_axis_is_proposed_where_the_fixture_may_turn(bench: Workbench, rivals: list[Solved]) -> None:
    found = propose(bench, rivals)
    assert found is not None
    assert found.candidate.extra in {"axis_flip", "rate_table"}
    assert found.separates == ("fixture_rotation", "mohr")
    assert found.enough
    assert found.evidence >= ENOUGH
    assert found.remaining == ()


def test_it_is_ready_for_json_and_for_the_simulator(bench: Workbench, rivals: list[Solved]) -> None:
    found = propose(bench, rivals)
    assert found is not None
    record = json.loads(json.dumps(found.record(), allow_nan=False))
    assert {"separates", "why", "profile"} <= set(record)
    program = legs(**record["profile"]).of(1)
    assert program.seconds == pytest.approx(record["duration_s"])
    time = found.predicted.run.time.contiguous()
    assert 10.0 + program.rate(time) == pytest.approx(found.predicted.run.table[:, -1], abs=1e-6)
    assert all(len(curve) == len(record["prediction"]["time_s"]) for name, curve in record["prediction"].items() if name != "compared")
    words = shlex.split(record["command"])
    assert words[:2] == ["fogzoo", "simulate"]
    told = dict(word.split("=", 1) for word in words[2:])
    assert json.loads(told["profile.legs"]) == record["profile"]["legs"]
    assert [sum(piece) for piece in json.loads(told["profile.rates"])] == pytest.approx([sum(piece) for piece in record["profile"]["rates"]])
    assert told["thermometers"] == "2"
    assert told["effects"] == "[static_bias,shupe]"
    assert told["hidden"] == "fixture_rotation"
    fitted = fitted_parameters(next(one for one in rivals if "fixture_rotation" in one.names), "dph")["fixture_rotation"]
    values = {f"+parameters.fixture_rotation.{name}": entry["value"] for name, entry in fitted.items()}
    assert {key: float(value) for key, value in told.items() if key.startswith("+")} == pytest.approx(values, rel=1e-5)


def test_nothing_is_proposed_for_one_explanation_or_for_two_that_are_the_same(bench: Workbench, rivals: list[Solved]) -> None:
    assert propose(bench, rivals[:1]) is None
    assert propose(bench, [rivals[0], replace(rivals[0])]) is None


def test_no_chamber_is_asked_for_kelvins_called_degrees(bench: Workbench, rivals: list[Solved], monkeypatch) -> None:
    hot = [replace(run, table=run.table + torch.tensor([0.0, 273.15, *[0.0] * (len(run.columns) - 2)])) for run in bench.runs]
    monkeypatch.setattr(bench, "runs", hot)
    assert propose(bench, rivals) is None


def test_the_cheapest_of_the_runs_that_are_enough() -> None:
    slow, quick, weak = weighed("slow", 20.0, p01=4000.0), weighed("quick", 5.0, p01=60.0), weighed("weak", 1.0, p01=9.0)
    assert choose([slow, quick, weak], 2) is quick


def test_the_one_that_tells_most_where_none_is_enough_and_pairs_that_no_run_tells_do_not_count() -> None:
    first, second = weighed("first", 1.0, p01=9.0, p02=0.1, p12=9.0), weighed("second", 1.0, p01=9.5, p02=0.3, p12=3.0)
    assert choose([first, second], 3) is first
    assert choose([weighed("neither", 1.0, p01=0.5)], 2) is None
    assert choose([], 2) is None


def test_a_pair_that_is_told_for_certain_comes_before_more_that_are_not() -> None:
    one, many = weighed("one", 1.0, p01=400.0, p02=0.3, p12=0.4), weighed("many", 1.0, p01=9.0, p02=9.0, p12=9.0)
    assert choose([one, many], 3) is one


def test_a_turned_axis_that_tells_nothing_more_is_not_considered() -> None:
    plain = weighed("plain", 5.0, p01=60.0, p02=1.0, p12=1.0)
    turned = replace(plain, candidate=replace(plain.candidate, name="turned", extra="axis_flip"))
    assert _useful([turned, plain]) == [plain]
    better = replace(turned, worth={**turned.worth, (0, 2): 8.0})
    assert _useful([better, plain]) == [better, plain]


def test_what_stays_together_is_said_in_few_words() -> None:
    assert list(_not_told([("a", "b")])) == ["a from b"]
    assert list(_not_told([("a", "c"), ("b", "c"), ("c", "d")])) == ["c from a, b or d"]
    assert list(_not_told([("a", "b"), ("a", "c"), ("b", "c")])) == ["a from b or c", "b from c"]


def test_rivals_are_the_twins_in_the_place_of_what_was_found(bench: Workbench, rivals: list[Solved]) -> None:
    found = search(bench, bench.solve(("static_bias", "shupe")), ["fixture_rotation", "warm_up"])
    assert found.missing == ["fixture_rotation"]
    open_to = rivals_of(bench, found, {"fixture_rotation": ["mohr"]})
    assert open_to[0] is found.final
    assert ("static_bias", "shupe", "mohr") in [one.names for one in open_to]
    assert rivals_of(bench, Search(found.base, found.base), {}) == []


@pytest.mark.slow
def test_the_proposed_run_taken_tells_them_apart(bench: Workbench, rivals: list[Solved], simulation: Simulation) -> None:
    proposal = propose(bench, rivals)
    assert proposal is not None
    known = {name: {one: value for one, (value, _) in share.parameters().items()} for name, share in simulation.shares.items()}
    effects, settings = {name: share.effect for name, share in simulation.shares.items()}, simulation.settings
    more = {"runs": 1, "seed": simulation.seed, "reference_dph": settings.reference_dph, "sample_s": settings.sample_s, "thermometers": 2}
    taken = simulate(simulation.device.gyro, legs(**proposal.record()["profile"]), effects, parameters=known, **more)
    runs = [*(as_run(run) for run in simulation.runs), as_run(taken.runs[0])]
    after = diagnose(runs, ["static_bias", "shupe"], dict(bench.effects)).record
    assert after["missing"] == ["fixture_rotation"]
    assert "mohr" not in next(entry for entry in after["candidates"] if entry["effect"] == "fixture_rotation")["indistinguishable_from"]
