"""What a gyro's output does by itself: angle random walk, flicker, rate random walk, quantisation of the angle.

Every number of the output is a mean over one sampling step. Coefficients as in IEEE Std 952 annex C; Allan variances at averaging time τ:
N²/τ, (2 ln2/π)·B², K²·τ/3, 3Q²/τ².
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.simulator.streams import normal, uniform

SECONDS_PER_HOUR = 3600.0


@dataclass(frozen=True)
class Noise:
    """How much noise the simulated gyro and its thermometers have; None is what the gyro's own class gives it.

    Attributes:
        random_walk: N, angle random walk [°/√h].
        flicker: B, bias instability [°/h].
        rate_random_walk: K [°/h/√h].
        angle_step_arcsec: step in which the angle is counted ["], 0 for none.
        thermometer_c: standard deviation of one reading [K].
        resolution_c: step of a thermometer's reading [K], 0 for none.
    """

    random_walk: float | None = None
    flicker: float | None = None
    rate_random_walk: float | None = None
    angle_step_arcsec: float = 0.02
    thermometer_c: float = 0.02
    resolution_c: float = 0.0625

    def __post_init__(self) -> None:
        """Check that every number is one that noise can have.

        Raises:
            InputError: a number is negative or not finite.
        """
        for key, value in vars(self).items():
            if value is not None and (isinstance(value, (str, bool)) or not 0 <= value < math.inf):
                raise InputError(f"noise.{key}={value}: a number from 0 up is possible")


SILENT = Noise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def white(random_walk: float, count: int, step_s: float, generator: torch.Generator) -> Tensor:
    """(count,) means over one step of white rate noise of density N [°/h]: σ = 60·N/√h for a step of h seconds.

    Args:
        random_walk: N [°/√h].
        count: how many samples.
        step_s: h [s].
        generator: source of chance.
    """
    return random_walk * math.sqrt(SECONDS_PER_HOUR / step_s) * normal(count, generator)


def flicker(instability: float, count: int, step_s: float, generator: torch.Generator) -> Tensor:
    """(count,) noise of one-sided density B²/(πf), two-sided B²/(2π|f|) [°/h], synthesised line by line (Timmer & König 1995, A&A 300:707).

    Made twice as long as needed and cut, so that its end does not join its start; no lines below 1/(2·count·h), and the mean over a
    step, sin(πfh)/(πfh), is applied.

    Args:
        instability: B [°/h]; the Allan deviation is flat at 0.664·B.
        count: how many samples.
        step_s: h [s].
        generator: source of chance.
    """
    length = 2 ** math.ceil(math.log2(2 * count))
    frequency = torch.arange(1, length // 2 + 1, dtype=torch.float64) / (length * step_s)
    density = instability**2 / (math.pi * frequency) * torch.sinc(frequency * step_s) ** 2
    # A line of density S and width Δf has variance S·Δf, half of it in each quadrature.
    size = (density / (length * step_s)).sqrt() * (length / 2)
    lines = torch.complex(size * normal(len(size), generator), size * normal(len(size), generator))
    spectrum = torch.cat([torch.zeros(1, dtype=lines.dtype), lines])
    return torch.fft.irfft(spectrum, n=length)[:count]


def rate_walk(coefficient: float, count: int, step_s: float, generator: torch.Generator) -> Tensor:
    """(count,) means over one step of a Wiener process in rate [°/h], starting at 0.

    The mean of a Wiener process between two known ends is their mean plus a normal number of variance K²·h/12.

    Args:
        coefficient: K [°/h/√h].
        count: how many samples.
        step_s: h [s].
        generator: source of chance.
    """
    size = coefficient * math.sqrt(step_s / SECONDS_PER_HOUR)
    ends = torch.cumsum(size * normal(count, generator), 0)
    starts = torch.cat([torch.zeros(1, dtype=ends.dtype), ends[:-1]])
    return (starts + ends) / 2 + size / math.sqrt(12) * normal(count, generator)


def counted(rate: Tensor, angle_step_arcsec: float, step_s: float, generator: torch.Generator) -> Tensor:
    """The rate as an output shows it that counts whole steps of the angle.

    Args:
        rate: (T,) [°/h], which is as many arcseconds a second.
        angle_step_arcsec: one count ["].
        step_s: sampling step [s].
        generator: gives the angle at the start.

    Returns:
        (T,) [°/h].
    """
    if angle_step_arcsec == 0:
        return rate
    counts = torch.cumsum(rate * step_s / angle_step_arcsec, 0) + uniform(generator)
    return torch.diff(counts.floor(), prepend=torch.zeros(1, dtype=rate.dtype)) * (angle_step_arcsec / step_s)
