"""Which settings tell methods of one type apart: the fewest, in short words."""

from __future__ import annotations

import re
from ast import literal_eval
from collections.abc import Iterator, Mapping, Sequence

SHORT = 24
"""A value with more letters says nothing in a name."""
TARGET = "_target_"
"""The key of a class, which is called by its name alone, as in the catalogue."""
OF_THE_DATA = ("data.average_s", "data.holdout", "data.points.where", "data.points.fitted", "data.points.checked")
"""What counts of the data: how they are used; where they lie and what their columns are called makes no method."""
ELSEWHERE = ("data", "model.inputs", "model.folder", "add", "candidates")
"""Settings that say nothing in a name: they follow from the data, or the result tells more."""


def telling_words(settings: Sequence[Mapping[str, str]]) -> list[str]:
    """For each of some methods the words of the settings by which it can be told from the others, as ``hidden5_lr0.1``.

    Settings that all of them have come first: a name without a word would say less.

    Args:
        settings: of each, flat, such as ``model.hidden``; those of equal ones get equal words.
    """
    words = [dict(_words(one)) for one in settings]
    profiles = [dict(one) for one in dict.fromkeys(tuple(one.items()) for one in words)]
    keys = [key for key in sorted({key for one in profiles for key in one}) if len({one.get(key) for one in profiles}) > 1]
    first = sorted(keys, key=lambda key: (not key.endswith(TARGET), not key.startswith("model.")))
    everywhere = [key for key in first if all(key in one for one in profiles)]
    chosen = _enough(first, _enough(everywhere, [], profiles), profiles)
    return ["_".join(one[key] for key in keys if key in chosen and key in one) for one in words]


def _enough(keys: Sequence[str], chosen: Sequence[str], profiles: Sequence[Mapping[str, str]]) -> list[str]:
    """Those chosen and as few more as tell as many profiles apart as all would: each time the one that helps most, at last without those in vain."""
    found = list(chosen)
    while keys:
        best = max(keys, key=lambda key: _apart([*found, key], profiles))
        if _apart([*found, best], profiles) == _apart(found, profiles):
            break
        found.append(best)
    for key in found[len(chosen) :]:
        less = [one for one in found if one != key]
        found = less if _apart(less, profiles) == _apart(found, profiles) else found
    return found


def _apart(keys: Sequence[str], profiles: Sequence[Mapping[str, str]]) -> int:
    """How many profiles differ in some settings."""
    return len({tuple(one.get(key) for key in keys) for one in profiles})


def _words(settings: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """What each setting is called in a name; of a list of names each for itself, so that it can be told which are there."""
    for key, value in settings.items():
        if key not in OF_THE_DATA and any(key == one or key.startswith(f"{one}.") for one in ELSEWHERE):
            continue
        if key.rpartition(".")[2] == TARGET:
            yield key, _called(value)
        elif value.startswith("[") and "'" in value:
            yield from ((f"{key}.{item}", str(item)) for item in literal_eval(value) if _tells(str(item)))
        elif _tells(value):
            yield key, _word(key.rpartition(".")[2], value)


def _called(path: str) -> str:
    """``takagi_sugeno`` for ``zoo.models.takagi_sugeno.TakagiSugeno``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", path.rpartition(".")[2]).lower()


def _tells(value: str) -> bool:
    return value not in {"None", "", "[]", "{}"} and len(value) <= SHORT and not value.startswith(("{", "$")) and "/" not in value


def _word(key: str, value: str) -> str:
    """``hidden5``, ``continuous=True``, ``edges0,15,30``."""
    plain = value.strip("[]").replace(" ", "")
    return f"{key}{'' if plain[:1].isdigit() else '='}{plain}"
