"""What a power-on in the cold is asked for, checked where it enters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from zoo.errors import InputError
from zoo.given import LARGEST_SEED, check_number
from zoo.simulator.laboratory.program import Campaign, Program

MOST_COUNTS = 100_000
LIMITS: Mapping[str, tuple[float, float, str]] = {
    "runs": (1, 1000, ""),
    "seed": (0, LARGEST_SEED, ""),
    "soak_c": (-60.0, 85.0, " °C"),
    "seconds": (1e-3, 86400.0, " s"),
    "sample_s": (1e-3, 60.0, " s"),
    "force_g": (-50.0, 50.0, " g"),
}


@dataclass(frozen=True)
class PowerOn:
    """How often, how cold and how long.

    Attributes:
        runs: how many power-ons to record, besides the check.
        seed: the user's.
        soak_c: where everything has soaked before [°C].
        seconds: how long is recorded [s].
        sample_s: length of a count [s].
        force_g: true specific force along the axis [g]; 1 points up.
    """

    runs: int = 1
    seed: int = 1
    soak_c: float = -40.0
    seconds: float = 480.0
    sample_s: float = 10.0
    force_g: float = 1.0

    def __post_init__(self) -> None:
        """Check every number.

        Raises:
            InputError: names the key, what was given and what is possible.
        """
        for key, (low, high, unit) in LIMITS.items():
            check_number(key, getattr(self, key), low, high, unit, whole=key in {"runs", "seed"})

    @property
    def counts(self) -> int:
        """Whole counts in a run."""
        return int(self.seconds / self.sample_s + 1e-9)

    @property
    def campaign(self) -> Campaign:
        """The same soak and length in every run, the check included."""
        program = Program(((self.soak_c, self.soak_c, self.seconds),))
        return Campaign((program,), program)

    def on(self, program: Program) -> PowerOn:
        """The same with the soak and the length of a chamber program.

        Raises:
            InputError: a chamber or a table that moves, a soak or a length that cannot be, fewer than two counts.
        """
        low, high = program.range_c
        if low != high or any(rate for rate, _ in program.rates):
            moves = f"goes from {low:g} to {high:g} °C" if low != high else "turns a rate table"
            hint = "profile=hui2016, or profile=legs 'profile.legs=[[-40,-40,480]]' 'profile.check=[[-20,-20,480]]'"
            raise InputError(f"profile: {moves}; a power-on is recorded at rest in a chamber that holds one temperature:\n{hint}")
        for key, value in (("soak_c", low), ("seconds", program.seconds)):
            check_number(f"profile: {key}", value, *LIMITS[key])
        asked = replace(self, soak_c=low, seconds=program.seconds)
        if not 2 <= asked.counts <= MOST_COUNTS:
            raise InputError(f"sample_s={self.sample_s:g}: makes {asked.counts} counts of {asked.seconds:g} s; 2 to {MOST_COUNTS} are possible")
        return asked
