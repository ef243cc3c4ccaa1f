"""What a simulation is asked for, checked where it enters."""

from __future__ import annotations

import math
from dataclasses import dataclass

from zoo.errors import InputError
from zoo.simulator.program import Campaign

MOST_RUNS = 1000
MOST_ROWS = 1_000_000


@dataclass(frozen=True)
class Settings:
    """How a campaign is run and recorded.

    Attributes:
        runs: how many runs to record, besides the check run.
        seed: which gyro and which chance.
        sample_s: time between rows [s]; every row is a mean over it.
        thermometers: 1 (at the spool) or 2 (also at the housing).
        chamber_s: time constant of the chamber's air behind its controller [s].
        cold_start: switched on at the first row; otherwise long before.
        reference_dph: true rate [°/h].
        amplitude: RMS of each hidden effect over the runs, about its mean [°/h]; None draws it.
    """

    runs: int = 3
    seed: int = 1
    sample_s: float = 10.0
    thermometers: int = 2
    chamber_s: float = 120.0
    cold_start: bool = False
    reference_dph: float = 0.0
    amplitude: float | None = None

    def __post_init__(self) -> None:
        """Check every number.

        Raises:
            InputError: names the key, what was given and what is possible.
        """
        _whole("runs", self.runs, 1, MOST_RUNS)
        _whole("seed", self.seed, 0, 2**63 - 1)
        _number("sample_s", self.sample_s, 1e-6, math.inf)
        _number("chamber_s", self.chamber_s, 0.0, 1e6)
        _number("reference_dph", self.reference_dph, -1e9, 1e9)
        if not isinstance(self.cold_start, bool):
            raise InputError(f"cold_start={self.cold_start}: true or false is possible")
        if self.amplitude is not None:
            _number("amplitude", self.amplitude, 0.0, 1e9)

    def check_programs(self, campaign: Campaign) -> None:
        """Refuse a step that does not fit into the programs.

        Raises:
            InputError: a step longer than a run, or so short that a run has more rows than memory.
        """
        for program in (*campaign.runs, campaign.check):
            rows = program.seconds / self.sample_s
            if self.sample_s > program.seconds:
                raise InputError(f"sample_s={self.sample_s:g}: is longer than a run of {program.seconds:g} s; a run needs at least two rows")
            if rows > MOST_ROWS:
                raise InputError(f"sample_s={self.sample_s:g}: makes {rows:.3g} rows of a run; at most {MOST_ROWS} are possible")


def _whole(key: str, value: object, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise InputError(f"{key}={value}: a whole number from {low} to {high} is possible")


def _number(key: str, value: object, low: float, high: float) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high or not math.isfinite(value):
        raise InputError(f"{key}={value}: a number from {low:g} {f'to {high:g}' if math.isfinite(high) else 'up'} is possible")
