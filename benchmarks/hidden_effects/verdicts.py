"""Whether a verdict is right, and how sure it was."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations
from typing import Any

LARGEST_CLASS = 4
Row = Mapping[str, Any]


def hidden_names(row: Row) -> list[str]:
    """What was hidden."""
    return [one["name"] for one in row["hidden"]]


def members(row: Row, named: str) -> set[str]:
    """A named effect with those that the runs cannot tell from it; itself alone where there are more than four."""
    entry = next((one for one in row["candidates"] if one["effect"] == named), None)
    together = {named, *(entry["indistinguishable_from"] if entry else [])}
    return together if len(together) <= LARGEST_CLASS else {named}


def exact(row: Row) -> bool:
    """The verdict without classes: nothing more, nothing less, nothing else."""
    return _expected(row) and (row["kind"] == "outside" or sorted(row["missing"]) == sorted(hidden_names(row)))


def right(row: Row) -> bool:
    """The verdict with classes: as many effects are named as are hidden, and each hidden one is in the class of another named one."""
    if row["kind"] == "outside" or not _expected(row):
        return _expected(row)
    hidden = hidden_names(row)
    orders = permutations([members(row, name) for name in row["missing"]])
    return len(hidden) == len(row["missing"]) and any(all(name in group for name, group in zip(hidden, order, strict=True)) for order in orders)


def _expected(row: Row) -> bool:
    wanted = {"nothing": "complete", "one": "missing", "two": "missing", "outside": "unknown"}[row["kind"]]
    return bool(row.get("verdict") == wanted)


def stated(row: Row) -> float:
    """Probability that the diagnosis gives to its own verdict, classes included: the only place that knows how a record tells it.

    A record with a ``posterior`` lists hypotheses, ``"complete"``, ``"missing"`` with a set of effects, ``"unknown"``; one without, candidates.
    """
    if row.get("posterior"):
        return _of_hypotheses(row, row["posterior"])
    chance = {one["effect"]: one["probability"] for one in row["candidates"]}
    if row["verdict"] != "missing":
        return max(0.0, 1.0 - sum(chance.values()))
    sure = 1.0
    for name in row["missing"]:
        sure *= min(1.0, sum(chance.get(one, 0.0) for one in members(row, name)))
    return sure


def _of_hypotheses(row: Row, posterior: list[Mapping[str, Any]]) -> float:
    wanted = {frozenset(row["missing"] if row["verdict"] == "missing" else [])}
    for name in wanted.copy().pop():
        wanted = {(names - {name}) | {other} for names in wanted for other in members(row, name)}
    alike = (one for one in posterior if one["hypothesis"] == row["verdict"] and frozenset(one["effects"]) in wanted)
    return float(sum(one["probability"] for one in alike))
