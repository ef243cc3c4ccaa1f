"""Models that differ by nothing but their seed are one method."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

from zoo.comparison.entrant import Entrant
from zoo.comparison.naming import distinct_names


@dataclass(frozen=True, eq=False)
class Method:
    """One way to make a model.

    Attributes:
        name: of its own.
        members: the models, by seed.
    """

    name: str
    members: dict[int, Entrant]


def methods_of(entrants: list[Entrant], starts: Collection[str]) -> list[Method]:
    """The methods behind named entrants, in the order of their first members.

    What makes a method is the model's type, start, optimizer and every setting but the seed. A second model of the same seed is another method: it
    was made by another version or on another machine.

    Args:
        entrants: each with a name of its own.
        starts: names of all starts that there are.
    """
    groups: dict[tuple[Any, ...], dict[int, Entrant]] = {}
    for place, one in enumerate(entrants):
        seed = one.facts.get("seed")
        if seed is None:
            groups[(place,)] = {0: one}
            continue
        key = (one.kind, one.facts.get("init"), one.facts.get("optimizer"), one.facts.get("average_s"), *sorted(one.settings.items()))
        again = 0
        while seed in groups.get((*key, again), {}):
            again += 1
        groups.setdefault((*key, again), {})[int(seed)] = one
    first = [next(iter(members.values())) for members in groups.values()]
    names = distinct_names([replace(one, facts=one.facts | {"seed": None}) for one in first], starts)
    return [Method(name, members) for name, members in zip(names, groups.values(), strict=True)]
