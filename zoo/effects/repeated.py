"""What may happen several times: each time is an effect of its own in a model, under the next name, such as ``bias_step_2``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from zoo.effects.base import Effect

MOST = 9
"""How often anything may."""


def kind(name: str, effect: Effect) -> str:
    """What the catalogue calls an effect that a model has under this name."""
    return effect.name if effect.again else name


def kinds(names: Iterable[str], effects: Mapping[str, Effect]) -> list[str]:
    """What the catalogue calls some effects of a model, each once, in their order."""
    return list(dict.fromkeys(kind(name, effects[name]) for name in names))


def by_kind(names: Iterable[str], effects: Mapping[str, Effect]) -> dict[str, list[str]]:
    """Some effects of a model by what the catalogue calls them, in the order in which each comes first."""
    given = list(names)
    return {one: [name for name in given if kind(name, effects[name]) == one] for one in kinds(given, effects)}


def with_times(effects: Mapping[str, Effect]) -> dict[str, Effect]:
    """Effects by name, and what may happen several times under its further names as well, where those are free."""
    again = {name: effect for name, effect in effects.items() if effect.again and name == effect.name}
    return {**{f"{name}_{time}": effect for name, effect in again.items() for time in range(2, MOST + 1)}, **effects}


def candidates_beside(names: Iterable[str], present: Iterable[str], effects: Mapping[str, Effect]) -> list[str]:
    """What of some effects may be added to a model: what it has already once more, where that may be, under the first name that is free.

    Args:
        names: in the catalogue.
        present: of the effects in the model.
        effects: by name, see `with_times`.
    """
    there, found = set(present), []
    for name in names:
        times = [name, *(f"{name}_{time}" for time in range(2, MOST + 1))] if effects[name].again else [name]
        found += [one for one in times if one not in there and kind(one, effects[one]) == name][:1]
    return found
