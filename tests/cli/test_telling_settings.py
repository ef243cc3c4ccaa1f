"""Names of methods: as few settings as tell them apart, in short words that say nothing of where anything lies."""

from __future__ import annotations

import random

import pytest

from zoo.cli.telling_settings import telling_words

BP = {"model.network._target_": "zoo.models.bp.BP", "model.network.hidden": "9", "model.network.features": "['temperature', 'temperature_rate']"}
LINE = {"model.network._target_": "zoo.models.polynomial.Polynomial", "model.network.order": "3"}


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ([{"model.hidden": "2"}], [""]),
        ([{"model.hidden": "2", "epochs": "9"}, {"model.hidden": "5", "epochs": "99"}], ["hidden2", "hidden5"]),
        ([{"model.hidden": "2", "optimizer.lr": "None"}, {"model.hidden": "2", "optimizer.lr": "0.1"}], ["", "lr0.1"]),
        ([BP, LINE], ["bp", "polynomial"]),
        ([BP, BP | {"model.network.hidden": "5"}, LINE], ["bp_hidden9", "bp_hidden5", "polynomial"]),
        ([{"effects.mohr._target_": "zoo.effects.mohr.Mohr"}, {}], ["mohr", ""]),
        ([{"model._target_": "mine.TakagiSugeno"}, {"model._target_": "mine.RBFNet"}], ["takagi_sugeno", "rbfnet"]),
        ([{"model.features": "['temperature']"}, {"model.features": "['temperature', 'output']"}], ["", "output"]),
        ([{"model.edges": "[0, 15]"}, {"model.edges": "[-5, 15]"}], ["edges0,15", "edges=-5,15"]),
        (
            [{"data.folder": "outputs/data", "data.files": "['run_1.csv']", "data.average_s": "100"}, {"data.average_s": "50"}],
            ["average_s100", "average_s50"],
        ),
        ([{"data.folder": "here", "data.columns.time": "t", "model.start": "a/b"}, {"data.folder": "there", "model.start": "c/d"}], ["", ""]),
        ([{"model.inputs": "['time_s']", "add": "auto", "model.effects": "${effects}"}, {"add": "mohr", "model.effects": "{}"}], ["", ""]),
    ],
)
def test_what_methods_are_called(settings: list[dict[str, str]], words: list[str]) -> None:
    assert telling_words(settings) == words


@pytest.mark.parametrize("missing", [0.0, 0.2])
@pytest.mark.parametrize("seed", range(20))
def test_no_two_methods_have_one_name_and_no_word_is_in_vain(seed: int, missing: float) -> None:
    chance = random.Random(seed)
    keys = [f"k{letter}" for letter in "abcdef"]
    settings = [{key: str(chance.randrange(3)) for key in keys if chance.random() >= missing} for _ in range(12)]
    distinct = {tuple(one.items()) for one in settings}
    words = telling_words(settings)
    assert len(set(words)) == len(distinct)
    if missing == 0:
        for said in {word[:2] for word in words[0].split("_")}:
            less = {"_".join(word for word in name.split("_") if word[:2] != said) for name in words}
            assert len(less) < len(distinct), f"without {said}"


def test_the_order_of_the_methods_changes_no_name() -> None:
    settings = [BP, LINE, BP | {"model.network.hidden": "5"}, LINE | {"model.network.order": "2"}]
    names = {tuple(one.items()): word for one, word in zip(settings, telling_words(settings), strict=True)}
    assert [names[tuple(one.items())] for one in reversed(settings)] == telling_words(settings[::-1])
