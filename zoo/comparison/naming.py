"""Models are called by what tells them apart."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any, Protocol

from zoo.scoring.comparison import UNCOMPENSATED

TAKEN = ("run", "stage", "blocks", UNCOMPENSATED)
"""Columns of the table that no model may be called like."""
TOLD_BY = ("origin", "added", "init", "optimizer", "settings", "seed")
"""What a name says where it differs among models of one type."""


class Named(Protocol):
    """What a name is made of: see `Entrant`."""

    @property
    def kind(self) -> str:
        """Its type."""

    @property
    def facts(self) -> dict[str, Any]:
        """What is known of how it was made."""


def distinct_names(models: Sequence[Named], starts: Collection[str]) -> list[str]:
    """The models' types with what tells any two of a type apart, a seed only where there are others; and at last a number.

    Args:
        models: to be called by names.
        starts: names of all starts that there are.
    """
    kinds = [model.kind for model in models]
    found, told = kinds, [_told(model, starts) for model in models]
    for key in TOLD_BY:
        bearers: dict[str, set[str]] = {}
        for name, facts in zip(found, told, strict=True):
            bearers.setdefault(name, set()).add(facts[key])
        groups = found if key == "seed" else kinds
        unclear = {group for group, name in zip(groups, found, strict=True) if len(bearers[name]) > 1}
        found = [f"{name}_{facts[key]}" if facts[key] and group in unclear else name for name, group, facts in zip(found, groups, told, strict=True)]
    seen = dict.fromkeys(TAKEN, 1)
    return [_numbered(name, seen) for name in found]


def _told(model: Named, starts: Collection[str]) -> dict[str, str]:
    """What may go into a name, empty where there is nothing to say."""
    facts, ladder = model.facts, model.facts.get("ladder")
    # What is solved without a start has nothing to draw: its seed decides nothing.
    seed = "" if facts.get("init") is None or facts.get("seed") is None else f"seed{facts['seed']}"
    added = "_".join(str(step["added"]) for step in ladder or [] if step.get("added"))
    plain = {key: str(facts.get(key) or "") for key in ("init", "optimizer", "settings")}
    if not plain["init"] and plain["optimizer"] in starts:  # what fits by itself here is a start elsewhere
        plain |= {"init": f"by_{plain['optimizer']}", "optimizer": ""}
    return {"origin": "" if ladder is None else "refined", "added": added, **plain, "seed": seed}


def _numbered(name: str, seen: dict[str, int]) -> str:
    """The name, with a number from its second bearer on; adds to those seen."""
    while name in seen:
        seen[name] += 1
        numbered = f"{name}_{seen[name]}"
        if numbered not in seen:
            name = numbered
    seen[name] = 1
    return name
