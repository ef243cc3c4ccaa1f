"""What a diagnosis means, and what a refinement is worth on runs that were not fitted, in words."""

from __future__ import annotations

import pytest

from zoo.report.verdict import Record, ladder, rms_after, verdict_of, worth_adding


def refined(checks: list[float | None], **more: object) -> Record:
    names = [None, "hysteresis", "polarization", "aging"][: len(checks)]
    rungs = [
        {"added": name, "effects": [], "rms": 0.1 * 0.95**i, "rms_check": check} for i, (name, check) in enumerate(zip(names, checks, strict=True))
    ]
    return {"ladder": rungs, "verdict": "unknown", "borne_out": False, **more}


def test_runs_that_do_not_go_with_the_others_come_first() -> None:
    of: Record = {"verdict": "complete", "runs": ["a", "b", "c"]}
    one, two, three = ({"run": name, "rms_from_others": 3.0, "rms_uncompensated": 1.5} for name in of["runs"])
    first = lambda strangers: verdict_of({**of, "strangers": strangers}).sentences[0]  # noqa: E731
    assert first([one]).startswith("a does not go with the other runs: it is predicted from these no better than without any model. Is it of")
    assert first([one, two]).startswith("a and b do not go with the other runs: they are predicted from these no better")
    assert first([one, two, three]).startswith("These runs do not go together")
    assert first([{**one, "run": "check"}]).startswith("check does not go with")
    assert "go" not in first([])
    assert verdict_of({}, {**refined([0.2]), "strangers": [one]}).sentences[0].startswith("a does not go with")


def test_temperatures_in_another_unit_come_before_anything_else() -> None:
    of: Record = {"verdict": "complete", "hot": {"a": 331.4}, "strangers": [{"run": "b", "rms_from_others": 3.0, "rms_uncompensated": 1.5}]}
    first, second, *_ = verdict_of(of).sentences
    assert first.startswith("a reaches 331 °C: if that is °F or K, say so first")
    assert second.startswith("b does not go with")


def test_what_is_left_of_check_runs_beyond_their_floor_is_said() -> None:
    for check, told in ((1.2, False), (1.3, True)):
        of = refined([None, check], verdict="complete", borne_out=True, noise_floor=0.1, noise_floor_check=1.0)
        assert ("it leaves 1.3× their floor, which may be noise" in " ".join(verdict_of({}, of).sentences)) is told


@pytest.mark.parametrize(
    ("checks", "kept"),
    [
        ([0.2, 0.1, 0.05], None),  # falls to the end
        ([0.2, 0.1, 0.101], None),  # a rise too small to notice
        ([0.2, 0.1, 0.12, 0.15], ["hysteresis"]),
        ([0.2, 0.1, 0.08, 0.15], ["hysteresis", "polarization"]),
        ([0.2, 0.3], []),
        ([None, None], None),  # nothing was checked
        ([0.2], None),
    ],
)
def test_the_effects_that_the_check_runs_bear_out(checks, kept) -> None:
    assert worth_adding(refined(checks)) == kept


@pytest.mark.parametrize("more", [{}, {"borne_out": True}])
def test_the_reader_is_told_where_to_stop(more) -> None:
    said = verdict_of({}, refined([0.2, 0.1, 0.12], **more))
    assert said.kind == "unknown"
    assert any("best with hysteresis alone: stop there" in sentence for sentence in said.sentences)
    assert any("do without" in sentence for sentence in verdict_of({}, refined([0.2, 0.3], **more)).sentences)
    complete = {"verdict": "complete", "borne_out": True, "noise_floor": 0.1, "noise_floor_check": 0.3}
    assert any("do without" in sentence for sentence in verdict_of({}, refined([0.2, 0.3], **complete)).sentences)
    assert not any("do without" in sentence for sentence in verdict_of({}, refined([0.3, 0.2], **complete)).sentences)
    assert not any("stop" in sentence or "without" in sentence for sentence in verdict_of({}, refined([0.2, 0.1], **more)).sentences)


def words(diagnosis: Record, refinement: Record | None = None) -> str:
    said = verdict_of(diagnosis, refinement)
    return " ".join([f"{said.headline}.", *said.sentences])


@pytest.mark.parametrize(
    ("floor", "checks", "said", "unsaid"),
    [
        (0.08, [0.2, 0.3], ["Not borne out", "fitted too closely"], ["neither", "fell"]),
        (
            0.02,
            [0.2, 0.3],
            ["Not borne out", "is not noise, neither on the fitted runs nor on the runs that were not fitted"],
            ["too closely", "fell"],
        ),
        (
            0.02,
            [0.2, 0.12],
            ["Not down to the noise", "fell by 40 %, but not down to the noise: it is still 6.0× the floor there"],
            ["Not borne out"],
        ),
        (0.08, [0.2, 0.12], ["Not down to the noise", "fell by 40 %", "fitted too closely"], ["Not borne out", "neither"]),
    ],
)
def test_a_check_that_fails_says_why(floor: float, checks: list[float | None], said: list[str], unsaid: list[str]) -> None:
    text = words({}, refined(checks, noise_floor=floor, noise_floor_check=0.02))
    assert all(part in text for part in said), text
    assert not any(part in text for part in unsaid), text


def test_a_check_that_fails_beyond_what_was_fitted_says_so() -> None:
    beyond = {"temperature_c": {"fitted": [-20.0, 50.0], "reached": [25.0, 85.0], "share": 0.6}}
    text = words({}, refined([0.2, 0.3], noise_floor=0.08, noise_floor_check=0.02, beyond=beyond))
    assert "temperature_c is 25.0 … 85.0 there, −20.0 … 50.0 in the fitted runs. There it extrapolates." in text
    assert "too closely" not in text


def test_pieces_that_were_held_out_are_no_runs() -> None:
    text = words({}, refined([0.2, 0.1, 0.12], noise_floor=0.02, check_runs=["a (held out)", "b (held out)"]))
    assert "The held-out pieces are predicted best with hysteresis alone" in text
    assert "neither on what was fitted nor on the held-out pieces" in text
    assert "runs" not in text
    assert "runs that were not fitted" in words({}, refined([0.2, 0.1, 0.12], check_runs=["a (held out)", "check"]))


@pytest.mark.parametrize(("ratio", "said"), [(1.2, "is noise."), (1.5, "looks like noise, coloured more than white: RMS 1.5× the floor.")])
def test_noise_is_not_called_so_where_the_floor_says_otherwise(ratio: float, said: str) -> None:
    missing = {"verdict": "missing", "missing": ["aging"], "rms": 9.0, "rms_final": ratio, "noise_floor": 1.0}
    assert f"With it added, what the model leaves {said}" in words(missing)
    assert f"What it leaves {said}" in words({"verdict": "complete", "rms": ratio, "noise_floor": 1.0})
    rungs = [{"added": None, "effects": [], "rms": 9.0}, {"added": "aging", "effects": [], "rms": ratio}]
    assert f"What it leaves {said}" in words({}, {"verdict": "complete", "ladder": rungs, "noise_floor": 1.0})


def test_a_complete_model_says_what_could_hide() -> None:
    complete: Record = {"verdict": "complete", "rms": 1.0, "noise_floor": 2.0}
    assert "would not show" not in words(complete)
    sizes = {"a": 1.0, "b": 5.0, "c": 30.0, "d": None}
    said = words({**complete, "detection_limits": {name: {"size": size, "hidden": 0.5} for name, size in sizes.items()}})
    assert "These runs would not show b below 2.5× and c below 15.0× the noise floor, and d in any size." in said
    absorbed = words({**complete, "detection_limits": {"d": {"size": None, "hidden": 1.0}}})
    assert "These runs would not show d in any size." in absorbed


@pytest.mark.parametrize("walk", [0.5, 1.6])
def test_noise_that_walks_more_than_most_is_told(walk: float) -> None:
    """Its floor is above what is left, and something slow may be in it."""
    noise = {"noise": {"white": 2.0, "flicker": 1.0, "walk": 2.0 * walk}, "noise_floor": 1.0}
    rungs = [{"added": None, "effects": [], "rms": 9.0}, {"added": "aging", "effects": [], "rms": 1.0}]
    complete, missing = {"verdict": "complete", "rms": 1.0}, {"verdict": "missing", "missing": ["aging"], "rms": 9.0, "rms_final": 1.0}
    for said in (words(noise | complete), words(noise | missing), words({}, noise | {"verdict": "complete", "ladder": rungs})):
        assert ("a walk of 1.6 times a block's white noise per √h" in said) is (walk == 1.6)


def test_a_complete_model_in_doubt_says_of_what() -> None:
    def said(nothing: float, missing: float, unknown: float) -> str:
        listed = [("complete", [], nothing), ("missing", ["aging"], missing), ("unknown", [], unknown)]
        posterior = [{"hypothesis": kind, "effects": effects, "probability": chance} for kind, effects, chance in listed]
        return words({"verdict": "complete", "posterior": posterior, "candidates": [{"effect": "aging", "probability": missing}]})

    assert "The model is complete." in said(0.6, 0.3, 0.1)
    assert "No effect has to be added." in said(0.4, 0.3, 0.3), "nothing is as likely as anything"
    assert "The model may be complete." in said(0.2, 0.46, 0.1)
    assert "aging may be missing (46 %), on too little evidence" in said(0.2, 0.46, 0.1)
    assert "something unknown may be missing (45 %)" in said(0.3, 0.25, 0.45)


def test_a_trained_model_that_does_not_fit_is_not_called_complete() -> None:
    """With other weights it would: nothing physical is missing, and yet nobody would fly it."""
    bad: Record = {"verdict": "unknown", "verdict_refitted": "complete", "rms": 1.2, "noise_floor": 0.06, "rms_uncompensated": 0.12}
    assert "The model is complete" not in words(bad)
    assert "It leaves 20.0× the noise floor" in words(bad)
    assert "10.0× the error without any model." in words(bad)
    assert "without any model" not in words({**bad, "rms_uncompensated": 2.0})
    assert "The model is complete." in words({**bad, "verdict": "complete", "rms": 0.06})
    assert "Unknown: nothing in the catalogue" in words({**bad, "verdict_refitted": "unknown"})


def test_where_effects_were_left_out_the_catalogue_is_not_said_to_explain_nothing() -> None:
    told = words({"verdict": "unknown", "left_out": ["aging", "moisture"]})
    assert "Unknown: none of the candidates explains this" in told
    assert "no candidate makes it so; candidates leaves out 2 of the catalogue's effects" in told
    assert "nothing in the catalogue" not in told
    assert "no known effect" not in told


def test_the_last_rms_is_of_the_last_fit() -> None:
    first = {"effect": "aging", "rms": 0.5}
    one: Record = {"effects": ["mohr"], "missing": ["aging"], "rms": 0.9, "rms_final": 0.3, "candidates": [first]}
    assert rms_after(one, []) == 0.3
    assert [rung.rms for rung in ladder(one)] == [0.9, 0.3]
    assert rms_after({**one, "rms_final": None}, []) == 0.5
    two = {**one, "missing": ["aging", "hysteresis"]}
    assert [rung.rms for rung in ladder(two)] == [0.9, 0.5, 0.3]


def test_what_is_needed_beside_another_is_no_twin_of_it() -> None:
    twins = {"effect": "hysteresis", "probability": 0.77, "indistinguishable_from": ["aging", "polarization"]}
    found: Record = {"verdict": "missing", "missing": ["hysteresis", "polarization"], "candidates": [twins]}
    text = words(found)
    assert "Missing: hysteresis or aging (77 %) and polarization." in text
    assert "cannot tell hysteresis from aging: compare both" in text
    assert words({**found, "missing": ["hysteresis", "aging", "polarization"]}).count("cannot tell") == 0
    both = {**found, "missing": ["hysteresis"], "candidates": [twins, {"effect": "aging", "probability": 0.2}]}
    assert "Missing: hysteresis, aging or polarization (97 %)." in words(both)
    one = {**twins, "indistinguishable_from": ["aging"]}
    assert "Missing: hysteresis or aging (97 %)." in words({**both, "candidates": [one, both["candidates"][1]]}), "either of them"


def test_many_twins_are_counted_above_and_named_below() -> None:
    twins = {"effect": "hysteresis", "indistinguishable_from": ["a", "b", "c"]}
    text = words({"verdict": "missing", "missing": ["hysteresis"], "candidates": [twins]})
    assert "Missing: hysteresis or one of 3 like it." in text
    assert "cannot tell hysteresis from a, b or c" in text


def test_an_apposition_is_closed() -> None:
    facts = [{"depends_on": "the size of the rate, not its sign", "explains": 0.94}, {"depends_on": "time", "explains": 0.5}]
    text = words({"verdict": "unknown", "unexplained": facts})
    assert "function of the size of the rate, not its sign, would explain 94 % of the residual." in text
    assert "function of time would explain 50 % of the residual." in text


def test_what_was_never_added_cannot_fail_to_be_borne_out() -> None:
    assert words({}, refined([0.2], noise_floor=0.02)) == "Incomplete. What is left is not noise."
    assert "nothing in the catalogue" in words({"verdict": "unknown"}, refined([0.2], noise_floor=0.02))
    assert "Not borne out as it stands" in words({}, refined([0.2], noise_floor=0.09))


WORDS = "It grows with the size of the rate (exponent 2.0 ± 0.1)."


def test_what_nothing_explains_is_said_in_the_diagnosis_own_words() -> None:
    found: Record = {"verdict": "unknown", "unexplained_words": WORDS, "unexplained": [{"depends_on": "time", "explains": 0.5}]}
    text = words(found)
    assert text.endswith("no known effect makes it so. It grows with the size of the rate (exponent 2.0\u00a0±\u00a00.1).")
    assert "free smooth function" not in text


ADDED = " Once that is added, 2.0× the noise floor is left."


@pytest.mark.parametrize(("form", "said"), [({"rms": 0.02}, ADDED), ({"rms": 0.02, "todo": True}, ""), (None, "")])
def test_what_the_form_would_leave_is_said(form: Record | None, said: str) -> None:
    found: Record = {"verdict": "unknown", "unexplained_words": "It grows.", "unexplained_form": form, "noise_floor": 0.01}
    assert words(found).endswith(f" It grows.{said}")
    assert words(found | {"missing": ["aging"]}).endswith(f": it grows.{said}")


def test_of_which_residual_it_is_said() -> None:
    found: Record = {"verdict": "unknown", "unexplained_words": WORDS, "missing": ["aging"]}
    assert "not noise. What the model leaves as it stands: it grows with" in words(found)
    rungs = [{"added": None, "effects": [], "rms": 9.0}, {"added": "aging", "effects": [], "rms": 5.0}]
    assert "What was unexplained before: it grows with" in words(found, {"verdict": "unknown", "ladder": rungs})


def proposed(twins: list[str], separates: list[str], **more: object) -> str:
    entry = {"effect": "aging", "indistinguishable_from": twins}
    experiment = {"separates": separates, **more}
    return words({"verdict": "missing", "missing": ["aging"], "candidates": [entry], "next_experiment": experiment})


def test_what_to_do_where_a_class_is_open() -> None:
    assert "cannot tell aging from warm_up: the next experiment below would." in proposed(["warm_up"], ["aging", "warm_up"])
    assert "the next experiment below would help." in proposed(["warm_up"], ["aging", "warm_up"], enough=False)
    some = proposed(["warm_up", "moisture"], ["aging", "warm_up", "moisture"], not_separated=[["moisture", "aging"]])
    assert "from warm_up or moisture: the next experiment below would tell it from warm_up; else compare each on a check run." in some
    assert "cannot tell aging from warm_up: compare both on a check run." in proposed(["warm_up"], ["mohr", "shupe"])


def test_what_the_next_experiment_is_for_where_no_twin_was_named() -> None:
    assert "It might yet be warm_up in the place of aging: see the next experiment below." in proposed([], ["aging", "warm_up"])
    assert "might" not in proposed([], ["mohr", "shupe"])
    assert "might" not in proposed(["warm_up"], ["aging", "warm_up"])


def test_a_likelier_set_with_one_more_in_it_is_named() -> None:
    """Than the one that is named, with what is too faint to be named beside it."""

    def told(*sets: tuple[float, list[str]], faint: float = 0.0) -> str:
        posterior = [{"hypothesis": "missing", "effects": effects, "probability": chance} for chance, effects in sets]
        posterior.append({"hypothesis": "faint", "effects": ["aging"], "probability": faint})
        return words({"verdict": "missing", "missing": ["aging"], "posterior": posterior})

    assert "warm_up may be missing as well (41 % against 38 %), on little evidence" in told((0.41, ["aging", "warm_up"]), (0.38, ["aging"]))
    assert "as well" not in told((0.41, ["aging", "warm_up"]), (0.33, ["aging"]), faint=0.2)
    assert "as well" not in told((0.38, ["aging", "warm_up"]), (0.41, ["aging"]))
    assert "as well" not in told((0.41, ["warm_up"]), (0.38, ["aging"]))
    assert "as well" not in words({"verdict": "missing", "missing": ["aging"]})


def test_a_rung_of_the_first_effect_alone_is_shown_only_where_it_was_fitted_alone() -> None:
    """Where it was put in its place again beside the second, its RMS is that of both."""
    record = {"effects": ["base"], "rms": 3.0, "rms_final": 1.0, "missing": ["one", "other"], "verdict": "missing"}
    for beside, added in ((["base"], [None, "one", "other"]), (["base", "other"], [None, "one and other"])):
        first = {"effect": "one", "rms": 2.0 if beside == ["base"] else 1.0, "beside": beside}
        rungs = ladder(record | {"candidates": [first]})
        assert [rung.added for rung in rungs] == added
        assert [rung.rms for rung in rungs] == ([3.0, 2.0, 1.0] if len(added) == 3 else [3.0, 1.0])
        assert rungs[-1].effects == ["base", "one", "other"]


@pytest.mark.parametrize(
    ("found", "what"),
    [
        ({"verdict": "unknown", "missing": []}, "this may be heat from elsewhere"),
        ({"verdict": "unknown", "missing": ["mohr"], "unexplained_words": "It grows."}, "this may be heat from elsewhere"),
        ({"verdict": "missing", "missing": ["hysteresis", "sensor_lag"]}, "sensor_lag may be heat from elsewhere"),
        ({"verdict": "missing", "missing": ["hysteresis"]}, ""),
        ({"verdict": "complete", "missing": []}, ""),
    ],
)
def test_with_one_thermometer_what_looks_like_a_misplaced_coil_is_told_to_be_perhaps_no_effect(found, what) -> None:
    told = words({**found, "thermometers": ["temperature_c"]})
    assert what in told
    assert ("one thermometer" in told) is bool(what)
    assert "one thermometer" not in words({**found, "thermometers": ["temperature_c", "temperature_outer_c"]})
    assert "one thermometer" not in words(found), "a record of an older diagnosis does not say how many"


def test_an_effect_that_cannot_be_told_from_a_misplaced_coil_counts_as_one() -> None:
    diagnosis = {"verdict": "missing", "missing": ["aging"], "thermometers": ["temperature_c"]}
    twins = [{"effect": "aging", "indistinguishable_from": ["thermal_gradient"]}]
    assert "aging may be heat from elsewhere" in words({**diagnosis, "candidates": twins})
    assert "elsewhere" not in words(diagnosis)


def test_what_happened_in_fitted_runs_alone_is_not_to_be_borne_out_by_others() -> None:
    step = {"onset": {"value": 2.0}, "step": {"value": 0.1}}
    for run, told in ((2.0, True), (0.0, False), (-2.0, False)):
        of = refined([1.0, 1.1], borne_out=False, parameters={"hysteresis": step, "hysteresis_2": {**step, "run": {"value": run}}})
        of["times"] = {"hysteresis": ["hysteresis", "hysteresis_2"]}
        sentences = verdict_of({}, of).sentences
        assert ("hysteresis happened in fitted runs alone" in " ".join(sentences)) is told


def test_of_what_is_missing_several_times_the_headline_says_how_often_and_not_of_what_was_there() -> None:
    of: Record = {"verdict": "missing", "missing": ["bias_step"], "effects": ["shupe"], "times": {"bias_step": ["bias_step_2", "bias_step"]}}
    assert verdict_of(of).headline == "Missing: bias_step, 2 times"
    assert verdict_of({**of, "effects": ["shupe", "bias_step"]}).headline == "Missing: bias_step"


def test_a_model_that_jumped_in_runs_of_its_own_is_not_told_to_train_longer() -> None:
    of: Record = {"verdict": "unknown", "verdict_refitted": "complete", "rms": 0.4, "noise_floor": 0.1, "effects": ["shupe", "bias_step_2"]}
    told = " ".join(verdict_of(of).sentences)
    assert "Train it" in told
    jumped = {**of, "times": {"bias_step": ["bias_step_2"]}, "parameters": {"bias_step_2": {"run": {"value": 3.0}}}}
    told = " ".join(verdict_of(jumped).sentences)
    assert "Train it" not in told
    assert "bias_step happened in fitted runs alone" in told
