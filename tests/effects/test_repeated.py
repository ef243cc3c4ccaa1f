"""The names of what a model has several times."""

from __future__ import annotations

from zoo.catalog import build
from zoo.effects.base import Effect
from zoo.effects.repeated import MOST, by_kind, candidates_beside, kinds, with_times


def catalogue(*names: str) -> dict[str, Effect]:
    return {name: build("effects", name) for name in names}


def test_what_may_happen_again_is_offered_under_the_next_name_and_all_else_once() -> None:
    effects = with_times(catalogue("aging", "bias_step"))
    present: list[str] = []
    for expected in ("bias_step", *(f"bias_step_{time}" for time in range(2, MOST + 1))):
        assert candidates_beside(["aging", "bias_step"], present, effects) == ["aging", expected]
        assert effects[expected] is effects["bias_step"]
        present.append(expected)
    assert candidates_beside(["aging", "bias_step"], ["aging", *present], effects) == [], "that often at most"
    assert kinds(["bias_step_3", "aging", "bias_step"], effects) == ["bias_step", "aging"]
    assert by_kind(["bias_step_3", "aging", "bias_step"], effects) == {"bias_step": ["bias_step_3", "bias_step"], "aging": ["aging"]}


def test_a_name_that_was_left_is_taken_again() -> None:
    effects = with_times(catalogue("bias_step"))
    assert candidates_beside(["bias_step"], ["bias_step", "bias_step_3"], effects) == ["bias_step_2"]
    assert candidates_beside(["bias_step"], ["bias_step_2"], effects) == ["bias_step"]


def test_a_users_own_effect_of_that_name_stays_what_it_is() -> None:
    own = catalogue("aging", "bias_step")
    effects = with_times({**own, "bias_step_2": own["aging"]})
    assert candidates_beside(["bias_step"], ["bias_step"], effects) == ["bias_step_3"]
    assert effects["bias_step_2"] is own["aging"]
    assert with_times(effects) == effects
