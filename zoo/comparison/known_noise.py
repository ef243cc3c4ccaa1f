"""What a complete model would leave of runs, where a refinement has found the gyro's noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isclose
from typing import Any, Self

from zoo.fitting.noise import floor_of
from zoo.measurements.recording import JITTER
from zoo.measurements.run import HELD_OUT, Run
from zoo.scoring.noise import NoiseModel
from zoo.units import convert

COMPLETE = "complete"
WRITTEN = ("noise", "noise_floor_by_run", "unit", "average_s")


@dataclass(frozen=True)
class KnownNoise:
    """Noise that a refinement has found in what its model leaves, and nothing else.

    Attributes:
        noise: of block means [unit].
        left: what the fit has left of it in each run that it was fitted to, by name [unit].
        fitted: whether a run is one of these.
        unit: of these.
        average_s: length of the blocks.
    """

    noise: NoiseModel
    left: Mapping[str, float]
    fitted: Callable[[Run], bool]
    unit: str
    average_s: float

    @classmethod
    def read(cls, facts: Mapping[str, Any], fitted: Callable[[Run], bool]) -> Self | None:
        """From what a refinement has written down; None where it has not, or has found its model not to be complete.

        Args:
            facts: of `refinement.json`, or of an exported file's training.
            fitted: whether the model was fitted to a run.
        """
        if facts.get("verdict") != COMPLETE or not all(facts.get(key) for key in WRITTEN):
            return None
        noise, left, unit, average_s = (facts[key] for key in WRITTEN)
        return cls(NoiseModel(**noise), left, fitted, unit, average_s)

    def applies(self, run: Run) -> bool:
        """Whether a run's blocks are as long: white noise is read off their differences, which in longer ones flicker makes as well."""
        return isclose(run.average_s, self.average_s, rel_tol=JITTER)

    def floor(self, run: Run) -> float:
        """What a complete model leaves of a run [its unit], see `floor_of`; less what the fit has taken up of one that was fitted."""
        times, left = convert(1.0, self.unit, run.unit), self.left.get(run.name.removesuffix(HELD_OUT))
        return floor_of(run, self.noise.scaled(times)) if left is None or not self.fitted(run) else times * left


def floors(runs: list[Run], known: KnownNoise | None) -> dict[str, float]:
    """What a complete model leaves of each run [its unit], by name: its white noise alone where nothing else is known."""
    return {run.name: floor_of(run) if known is None else known.floor(run) for run in runs}
