"""What noise alone would leave, on the fitted runs and on those that were only checked on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from zoo.report.wording import finite, times

WORTH_TELLING = 1.25
"""An RMS beyond so many times the floor is not simply called noise."""


@dataclass(frozen=True)
class Floors:
    """RMS that complete predictions would leave [output's unit]; None where unknown.

    Attributes:
        fitted: of the fitted runs.
        checked: of the check runs, where it is known by itself.
        by_run: of each fitted run, where they differ.
    """

    fitted: float | None = None
    checked: float | None = None
    by_run: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def read(cls, diagnosis: dict[str, Any], refinement: dict[str, Any] | None = None) -> Floors:
        """From the contract's records; the diagnosis knows no check runs."""
        later = refinement or {}
        # The ladder's numbers are the refinement's: all of one page are divided by the same floor.
        own = later if finite(later.get("noise_floor")) else diagnosis
        return cls(finite(own.get("noise_floor")), finite(later.get("noise_floor_check")), own.get("noise_floor_by_run") or {})

    def of(self, role: str, run: str = "") -> float | None:
        """The floor of a run by its role, ``"fit"`` or ``"check"``, and its name; without one that of all."""
        return self.checked or self.fitted if role == "check" else self.by_run.get(run, self.fitted)


def excess(value: Any, floor: Any) -> float | None:
    """A value as a multiple of the noise floor; None where either is unknown."""
    number, noise = finite(value), finite(floor)
    return number / noise if number is not None and noise else None


def multiple(value: Any, floor: Any) -> str:
    """``3.5× noise floor``; empty where it is not known."""
    ratio = excess(value, floor)
    return "" if ratio is None else f"{times(ratio)} noise floor"
