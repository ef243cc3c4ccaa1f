"""What a gyro's output does by itself: angle random walk, flicker, rate random walk, rate ramp, quantisation of the angle.

Every number of the output is a mean over one sampling step h. Coefficients as in IEEE Std 952 annex C; Allan variances at averaging time τ:
N²/τ, (2 ln2/π)·B², K²·τ/3, R²·τ²/2, 3Q²/τ². N grows in the cold; B, K and R are not known to depend on the temperature, and counting does not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache

import torch
from torch import Tensor

from zoo.given import check_number
from zoo.simulator.streams import normal, uniform
from zoo.units import SECONDS_PER_HOUR

DIGITS = 9
"""Decimals of a counted output in °/h; a file would otherwise show it to the last bit."""
REFERENCE_C, COLD_C = 20.0, -40.0
LOSS_EXPONENT = 0.75
"""k of N ∝ P^(−k/2), P the power at the detector: 1 where shot noise rules, 0 where the source's excess noise does (engineering prior)."""


@dataclass(frozen=True)
class Noise:
    """How much noise the simulated gyro and its thermometers have; None is what the gyro's own class gives it.

    Attributes:
        random_walk: N, angle random walk at 20 °C and above [°/√h].
        flicker: B, bias instability [°/h].
        rate_random_walk: K [°/h/√h].
        rate_ramp: R, either way, from the start of a run [°/h/h].
        cold_loss_db: how much less light comes through at −40 °C than at 20 °C [dB].
        angle_step_arcsec: step in which the angle is counted, √12·Q ["], 0 for none.
        thermometer_c: standard deviation of one reading [K].
        resolution_c: step of a thermometer's reading [K], 0 for none.
    """

    random_walk: float | None = None
    flicker: float | None = None
    rate_random_walk: float | None = None
    rate_ramp: float = 0.0
    cold_loss_db: float | None = None
    angle_step_arcsec: float = 0.02
    thermometer_c: float = 0.02
    resolution_c: float = 0.0625

    def __post_init__(self) -> None:
        """Check that every number is one that noise can have.

        Raises:
            InputError: a number is missing, not finite, or negative and no ramp.
        """
        for field in fields(self):
            value, low = getattr(self, field.name), -math.inf if field.name == "rate_ramp" else 0.0
            if value is not None or field.default is not None:
                check_number(f"noise.{field.name}", value, low)


SILENT = Noise(**dict.fromkeys((field.name for field in fields(Noise)), 0.0))


def loss_factor(temperature_c: Tensor, cold_loss_db: float) -> Tensor:
    """(..., T) how much larger N is than at 20 °C, by the light that the fibre's bends in its stiffening coating lose in the cold.

    10^(k·L/20), L = L₋₄₀·((20 °C − T)/60 K)² below 20 °C (the square is an engineering prior), 1 above: a hot source that weakens is left out.

    Args:
        temperature_c: (..., T) temperature of the winding [°C].
        cold_loss_db: L₋₄₀, loss of optical power at −40 °C [dB].
    """
    colder = (REFERENCE_C - temperature_c).clamp_min(0.0) / (REFERENCE_C - COLD_C)
    return 10.0 ** (LOSS_EXPONENT * cold_loss_db / 20.0 * colder.square())


def white(random_walk: float, count: int, step_s: float, generator: torch.Generator, factor: Tensor | float = 1.0) -> Tensor:
    """(count,) means over one step of white rate noise of density N [°/h]: σ = 60·N/√h.

    Args:
        random_walk: N [°/√h].
        count: how many samples.
        step_s: h [s].
        generator: source of chance.
        factor: what N is multiplied by, (count,) or a number, see `loss_factor`.
    """
    return random_walk * math.sqrt(SECONDS_PER_HOUR / step_s) * factor * normal(count, generator)


def flicker(instability: float, count: int, step_s: float, generator: torch.Generator) -> Tensor:
    """(count,) means over one step of noise of one-sided density B²/(πf) [°/h], synthesised line by line (Timmer & König 1995, A&A 300:707).

    Made twice as long as needed, or a little longer, and cut, so that its end does not join its start; no lines below 1/(that length).

    Args:
        instability: B [°/h]; the Allan deviation is flat at 0.664·B.
        count: how many samples.
        step_s: h [s]; nothing depends on it, such noise has no scale of time.
        generator: source of chance.
    """
    sizes = _flicker_lines(count)
    lines = torch.view_as_complex(normal(2 * len(sizes), generator).reshape(-1, 2))
    return torch.fft.irfft(instability * sizes * lines, n=2 * (len(sizes) - 1))[:count]


@lru_cache(maxsize=8)
def _flicker_lines(count: int) -> Tensor:
    """(L/2+1,) size of either quadrature of the lines of a series of even length L for B = 1, the first of them 0.

    With u = fh, a mean over h multiplies the density by (sin πu/πu)² and one value every h folds all u + j onto u, which sums up to
    B²h/π·(sin πu/π)²·(ζ(3, u) + ζ(3, 1 − u)) with Hurwitz' ζ. A line of density S has variance S/(Lh), half of it in each quadrature.
    """
    # A product of small primes, which a Fourier transform likes, at most a fifth longer than needed.
    length = min(odd * 2 ** max(1, math.ceil(math.log2(2 * count / odd))) for odd in (1, 3, 5, 9, 15, 27))
    u, cube = torch.arange(1, length // 2 + 1, dtype=torch.float64) / length, torch.tensor(3.0, dtype=torch.float64)
    folded = (math.pi * u).sin().square() * (torch.special.zeta(cube, u) + torch.special.zeta(cube, 1 - u)) / math.pi**3
    return torch.cat([torch.zeros(1, dtype=u.dtype), (folded * length).sqrt() / 2])


def rate_walk(coefficient: float, count: int, step_s: float, generator: torch.Generator) -> Tensor:
    """(count,) means over steps of h = `step_s` seconds of a Wiener process in rate, 0 at the start, with K = `coefficient` [°/h/√h], in °/h.

    The mean of a Wiener process between two known ends is their mean plus a normal number of variance K²·h/12.
    """
    size = coefficient * math.sqrt(step_s / SECONDS_PER_HOUR)
    ends = torch.cumsum(size * normal(count, generator), 0)
    starts = torch.cat([torch.zeros(1, dtype=ends.dtype), ends[:-1]])
    return (starts + ends) / 2 + size / math.sqrt(12) * normal(count, generator)


def rate_ramp(coefficient: float, count: int, step_s: float) -> Tensor:
    """(count,) means over steps of h = `step_s` seconds of a rate that grows evenly, 0 at the start, with R = `coefficient` [°/h/h], in °/h."""
    return coefficient * step_s / SECONDS_PER_HOUR * (torch.arange(count, dtype=torch.float64) + 0.5)


def counted(rate: Tensor, angle_step_arcsec: float, step_s: float, generator: torch.Generator) -> Tensor:
    """(T,) the rate as an output shows it that counts whole steps of the angle [°/h].

    Args:
        rate: (T,) [°/h], which is as many arcseconds a second.
        angle_step_arcsec: one count ["].
        step_s: sampling step [s].
        generator: gives the angle at the start.
    """
    if angle_step_arcsec == 0:
        return rate
    counts = torch.cumsum(rate * step_s / angle_step_arcsec, 0) + uniform(generator)
    steps = torch.diff(counts.floor(), prepend=torch.zeros(1, dtype=rate.dtype))
    return (steps * (angle_step_arcsec / step_s)).round(decimals=DIGITS)
