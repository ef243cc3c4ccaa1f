"""What a simulation is asked for, checked where it enters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from zoo.errors import InputError, nearest
from zoo.given import check_number, check_seed, check_switch
from zoo.physics.conduction import FIDELITIES
from zoo.simulator.laboratory.earth import earth_rate
from zoo.simulator.laboratory.program import Campaign

MOST_RUNS = 1000
MOST_ROWS = 10_000_000
PLACES = ("spool", "housing", "inner_layer", "outer_layer", "air")
"""Where a thermometer can sit."""


@dataclass(frozen=True)
class Settings:
    """How a campaign is run and recorded.

    Attributes:
        runs: how many runs to record, besides the check run.
        seed: which gyro and which chance.
        sample_s: time between rows [s]; noise, counts and the true rate are means over the step that begins at a row's time, temperatures and
            effects are those of that time.
        thermometers: how many of the first `PLACES` have one, or their names, the main one first.
        heat: fidelity of the winding's heat, ``lumped``, ``radial`` or ``radial_axial``.
        cold_start: whether the gyro's body begins as cold as the air, and not warmed through by its electronics.
        reference_dph: true rate besides the Earth's and the table's [°/h].
        latitude_deg: of the laboratory; None leaves the Earth's rate out.
        axis: where the input axis points, see `zoo.simulator.laboratory.earth`.
        amplitude: RMS of each hidden effect over the runs, beyond what the other effects could take up [°/h]; None draws it.
        torch_device: where the heat and the effects are computed.
    """

    runs: int = 3
    seed: int = 1
    sample_s: float = 10.0
    thermometers: int | Sequence[str] = 2
    heat: str = "radial"
    cold_start: bool = False
    reference_dph: float = 0.0
    latitude_deg: float | None = None
    axis: str | Sequence[float] = "up"
    amplitude: float | None = None
    torch_device: str = "cpu"

    def __post_init__(self) -> None:
        """Check every number.

        Raises:
            InputError: names the key, what was given and what is possible.
        """
        check_number("runs", self.runs, 1, MOST_RUNS, whole=True)
        check_seed("seed", self.seed)
        check_number("sample_s", self.sample_s, 1e-6, math.inf)
        check_number("reference_dph", self.reference_dph, -1e9, 1e9)
        check_switch("cold_start", self.cold_start)
        if self.amplitude is not None:
            check_number("amplitude", self.amplitude, 0.0, 1e9)
        if self.heat not in FIDELITIES:
            raise InputError(f"heat={self.heat}: {nearest(str(self.heat), FIDELITIES)}")
        _ = self.places, self.constant_rate

    @property
    def places(self) -> tuple[str, ...]:
        """Where the thermometers sit."""
        asked = self.thermometers
        if isinstance(asked, int) and not isinstance(asked, bool) and 1 <= asked <= len(PLACES):
            return PLACES[:asked]
        if isinstance(asked, Sequence) and asked and not isinstance(asked, str) and len(set(asked)) == len(asked) and set(asked) <= set(PLACES):
            return tuple(asked)
        raise InputError(f"thermometers={asked}: 1 to {len(PLACES)}, or a list of {', '.join(PLACES)}, are possible")

    @property
    def constant_rate(self) -> float:
        """What turns all the time: the reference and the Earth's share [°/h]."""
        earth = earth_rate(0.0 if self.latitude_deg is None else self.latitude_deg, self.axis)
        return self.reference_dph + (0.0 if self.latitude_deg is None else earth)

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
