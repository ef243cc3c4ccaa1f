"""What `train` and `refine` have written down of the runs that a model was fitted to."""

from __future__ import annotations

from typing import Any


def fitted_runs(facts: dict[str, Any]) -> list[str]:
    """The runs that a model was fitted to: `train` lists them with their numbers, `refine` by name."""
    return [str(one["run"] if isinstance(one, dict) else one) for one in facts.get("runs") or []]


def uncompensated_rms(facts: dict[str, Any]) -> dict[str, float]:
    """RMS of the error of each run that a model was fitted to [output's unit], by name, where it is known: names alone do not tell gyros apart."""
    listed = {str(one["run"]): one.get("uncompensated") for one in facts.get("runs") or [] if isinstance(one, dict)}
    return {name: value for name, value in (listed | (facts.get("uncompensated_by_run") or {})).items() if value is not None}
