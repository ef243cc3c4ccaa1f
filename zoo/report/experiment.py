"""The run that the diagnosis proposes: in two sentences, in one line, and drawn."""

from __future__ import annotations

import itertools
from typing import Any

from markupsafe import Markup

from zoo.report.canvas import inline_svg
from zoo.report.experiment_figure import CURVES, experiment_figure
from zoo.report.palette import styled
from zoo.report.verdict import Record
from zoo.report.wording import Scale, finite, joined, significant

NEEDS = {
    "axis_flip": "a fixture that turns the input axis over",
    "rate_table": "a rate table",
    "power_on": "a soak without power before it",
}


def experiment_drawing(experiment: Record, scale: Scale) -> Markup | None:
    """Program, true input and the difference to be seen; None where the record does not hold what was predicted.

    Args:
        experiment: the contract's `next_experiment`.
        scale: how the output's values are written.
    """
    curves = experiment.get("prediction")
    if not isinstance(curves, dict) or not all(_numbers(curves.get(name)) for name in CURVES):
        return None
    if len({len(curves[name]) for name in CURVES}) > 1:
        return None
    with styled("experiment"):
        return inline_svg(
            experiment_figure(curves, scale, _legs(experiment)), f"Proposed run: {experiment.get('name')}. Separates {separated(experiment)}."
        )


def _legs(experiment: Record) -> list[list[float]]:
    """The chamber's program; empty where it is not given as legs of three numbers."""
    profile = experiment.get("profile")
    legs = profile.get("legs") if isinstance(profile, dict) else None
    return legs if isinstance(legs, list) and all(_numbers(leg) and len(leg) == 3 for leg in legs) else []


def _numbers(values: Any) -> bool:
    return isinstance(values, list) and len(values) > 1 and all(finite(value) is not None for value in values)


def experiment_line(experiment: Record | None) -> str | None:
    """The proposal in one line, for the terminal; None where there is none."""
    if not experiment or not experiment.get("name"):
        return None
    hours, evidence = finite(experiment.get("duration_s")), finite(experiment.get("expected_evidence"))
    facts = [f"{significant(hours / 3600.0)} h" if hours else "", f"log Bayes factor {significant(evidence, 2)}" if evidence is not None else ""]
    return f"to separate {separated(experiment)}: {experiment['name']} ({', '.join(fact for fact in facts if fact)})"


def experiment_settings(experiment: Record) -> list[tuple[str, str]]:
    """Label and value of what a reader should know besides: what the run needs, what else was considered."""
    rows = []
    if experiment.get("input") in NEEDS:
        rows.append(("Needs besides a chamber", NEEDS[experiment["input"]]))
    for number, other in enumerate(experiment.get("alternatives") or [], 1):
        hours, evidence = finite(other.get("duration_s")), finite(other.get("expected_evidence"))
        known = hours is not None and evidence is not None
        told = f" ({significant((hours or 0.0) / 3600.0)} h, log Bayes factor {significant(evidence, 2)})" if known else ""
        rows.append((f"Alternative {number}", f"{other.get('name')}{told}{_why_not(experiment, other)}"))
    return rows


def _why_not(experiment: Record, other: Record) -> str:
    """Why a run that would tell more is not proposed: what is enough in less time is."""
    longer, more = ((finite(other.get(key)) or 0.0) > (finite(experiment.get(key)) or 0.0) for key in ("duration_s", "expected_evidence"))
    return ": longer, for more than is needed" if longer and more and experiment.get("enough") else ""


def separated(experiment: Record) -> str:
    """What the run tells apart, ``a and (b or c)`` where b and c stay alike; empty where there is nothing."""
    names, alike = [str(one) for one in experiment.get("separates") or []], [set(pair) for pair in experiment.get("not_separated") or []]
    sides: list[list[str]] = []
    for name in names:
        with_it = [side for side in sides if any({name, other} in alike for other in side)]
        joint = [*itertools.chain.from_iterable(with_it), name]
        sides = [joint if side is with_it[0] else side for side in sides if side not in with_it[1:]] if with_it else [*sides, joint]
    return joined(f"({joined(side, 'or')})" if len(side) > 1 else side[0] for side in sides) if len(sides) > 1 else joined(names)
