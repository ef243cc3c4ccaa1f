"""What a chamber makes of its program: the lag and the overshoot of its controller, the cycling of its compressor or heater, its fan."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.errors import InputError, nearest
from zoo.given import check_number
from zoo.physics.recurrence import affine
from zoo.simulator.laboratory.program import Program
from zoo.simulator.streams import normal, uniform

WANDER_RAD = 0.3
"""How far the phase of the cycling wanders within one period, 1 rad in eleven; an engineering prior."""
FANS = ("always", "in_motion", "never")
RANGES = {
    "lag_s": (0.0, 1e6),
    "overshoot": (0.0, 0.5),
    "cycling_k": (0.0, 20.0),
    "cycling_s": (1.0, 86400.0),
    "fan_dph": (-1e9, 1e9),
}


@dataclass(frozen=True)
class Chamber:
    """The chamber that the gyro stands in.

    Attributes:
        lag_s: how late the air is on a long ramp; without overshoot the time constant of a first-order lag [s].
        overshoot: by how much of a step the air goes beyond it, 0 to 0.5.
        cycling_k: amplitude of the limit cycle of compressor or heater [K].
        cycling_s: its period [s].
        fan: when the fan runs: ``"always"``, ``"in_motion"`` (while the set point moves) or ``"never"``.
        fan_dph: bias that the gyro makes of the running fan's vibration [°/h].
    """

    lag_s: float = 120.0
    overshoot: float = 0.0
    cycling_k: float = 0.0
    cycling_s: float = 300.0
    fan: str = "never"
    fan_dph: float = 0.0

    def __post_init__(self) -> None:
        """Check every setting.

        Raises:
            InputError: names the key, what was given and what is possible.
        """
        for key, (low, high) in RANGES.items():
            check_number(f"chamber.{key}", getattr(self, key), low, high)
        if self.fan not in FANS:
            raise InputError(f"chamber.fan={self.fan}: {nearest(str(self.fan), FANS)}")
        if self.overshoot > 0 and self.lag_s == 0:
            raise InputError(f"chamber.overshoot={self.overshoot:g}: air without a lag cannot overshoot; set chamber.lag_s above 0 or overshoot to 0")

    def air(self, program: Program, time: Tensor, generator: torch.Generator) -> Tensor:
        """Temperature of the air, steady before the program begins.

        Args:
            program: what is asked for.
            time: (T,) equidistant [s].
            generator: source of chance, for the phase of the cycling.

        Returns:
            (T,) [°C].
        """
        mean = self.controlled(program, time)
        return mean + self.cycling(time, generator) if self.cycling_k > 0 else mean

    def controlled(self, program: Program, time: Tensor) -> Tensor:
        """What the controller makes of the set point: (T,) [s] -> (T,) [°C], exact for its legs and steps whatever the sampling.

        With overshoot M the loop is one of integral action around a plant of first order, H(s) = 1/(1 + λs + (s/ω)²), λ the lag, whose step
        response goes beyond the step by M = exp(−πζ/√(1 − ζ²)), ζ = λω/2. Its poles are those of a pair of conjugate first-order lags, τ and
        its conjugate, τ = (λ/2)(1 + iπ/ln(1/M)): the air is Re[(1 − i·ln(1/M)/π)·x], x the set point behind the lag τ. On a ramp it is late
        by λ for every M. (Two real poles with a zero reach no more than M = e⁻² unless the air runs ahead of every ramp.)
        """
        if self.lag_s == 0:
            return program.asked(time)
        if self.overshoot == 0:
            return followed(program, time, complex(self.lag_s)).real
        damping = -math.log(self.overshoot) / math.pi
        both = (1 - 1j * damping) * followed(program, time, self.lag_s / 2 * (1 + 1j / damping))
        return both.real

    def cycling(self, time: Tensor, generator: torch.Generator) -> Tensor:
        """Limit cycle of compressor or heater: a sine whose phase wanders, as means over one step show it.

        Args:
            time: (T,) equidistant [s].
            generator: gives the phase.

        Returns:
            (T,) [K]; a mean over a step of h seconds leaves sin(πfh)/(πfh) of the amplitude, nothing where h is a period.
        """
        step_s = float(time[1] - time[0]) if len(time) > 1 else 0.0
        periods = step_s / self.cycling_s
        phase = WANDER_RAD * math.sqrt(periods) * torch.cumsum(normal(len(time), generator), 0)
        seen = self.cycling_k * float(torch.sinc(torch.tensor(periods, dtype=torch.float64)))
        return seen * torch.sin(2 * math.pi * (time / self.cycling_s + uniform(generator)) + phase)

    def fan_on(self, program: Program, time: Tensor) -> Tensor:
        """Whether the fan runs: (T,) [s] -> (T,) 0 or 1; a step of the set point takes no time and starts no fan."""
        if self.fan != "in_motion":
            return torch.full_like(time, float(self.fan == "always"))
        moves = [float(start != end) for start, end, _ in program.legs]
        return torch.tensor([*moves, 0.0], dtype=time.dtype)[program.leg(time)]


def followed(program: Program, time: Tensor, tau: complex) -> Tensor:
    """The set point behind a lag, τ·dx/dt = u(t) − x with x(0) = u(0): solved leg by leg, so that steps and corners may lie anywhere.

    Within a leg of slope r that begins at u₀, x(t) = u₀ + r(t − τ) + c·exp(−t/τ) with t since its begin; c goes from leg to leg so that x has no
    steps.

    Args:
        program: what is asked for.
        time: (T,) [s].
        tau: time constant [s], of positive real part.

    Returns:
        (T,) complex [°C].
    """
    held = (program.legs[-1][1], program.legs[-1][1], 1.0)
    begin, end, seconds = torch.tensor((*program.legs, held), dtype=torch.float64).T
    slope = (end - begin) / seconds
    kick = (end[:-1] - slope[:-1] * tau) - (begin[1:] - slope[1:] * tau)
    first = (slope[0] * tau).unsqueeze(0)
    rest = torch.cat([first, affine(torch.exp(-seconds[:-1] / tau), kick, first[0])])
    leg = program.leg(time)
    since = time - (torch.cumsum(seconds, 0) - seconds)[leg]
    return begin[leg] + slope[leg] * (since - tau) + rest[leg] * torch.exp(-since / tau)
