"""What an ideal detector could do, and how far from it the diagnosis is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import beta, binom, norm

Array = NDArray[Any]
FALSE_ALARM, CERTAIN, COVER = 0.02, 0.9, 0.9
PRIOR_SPREAD = 3.0
"""Of the logistic's level and steepness about 0 and 3: as good as nothing against ten cases, and a limit where all or none were found."""
FEWEST = 4


def threshold(hypotheses: int) -> float:
    """The t at which the largest |matched filter| of M independent hypotheses of one amplitude each exceeds t in 2 % of the noise alone.

    1 − (1 − 2Q(t))^M = 0.02, Q the normal distribution's tail.
    """
    return float(-norm.ppf((1 - (1 - FALSE_ALARM) ** (1 / hypotheses)) / 2))


def ideal(z: Array | float, hypotheses: Array | int) -> Array:
    """Probability that the right one of M matched filters passes the threshold: Q(t − z) + Q(t + z)."""
    limit = np.vectorize(threshold)(hypotheses)
    return np.asarray(norm.sf(limit - z) + norm.sf(limit + z))


def ideal_limit(hypotheses: int) -> float:
    """The z that an ideal detector finds with 90 %: t + Q⁻¹(0.1), as the other tail adds nothing there."""
    return threshold(hypotheses) + float(norm.ppf(CERTAIN))


@dataclass(frozen=True)
class Curve:
    """Logistic of ln z, of which the size `at` is found with 90 %."""

    level: float
    steepness: float

    def __call__(self, z: Array) -> Array:
        """Probability of detection."""
        return np.asarray(1 / (1 + np.exp(-self.level - self.steepness * np.log(z))))

    @property
    def at(self) -> float:
        """The z found with 90 %."""
        return float(np.exp((np.log(CERTAIN / (1 - CERTAIN)) - self.level) / self.steepness))


def fitted(z: Sequence[float], found: Sequence[bool], reference: float) -> Curve | None:
    """Detection against ln(z/reference), most probable under a wide prior; None for fewer than four cases."""
    if len(z) < FEWEST:
        return None
    x, y = np.log(np.maximum(z, 1e-3) / reference), np.where(found, 1.0, -1.0)

    def cost(p: Array) -> float:
        return float(np.logaddexp(0, -y * (p[0] + np.exp(p[1]) * x)).sum() + 0.5 * (p[0] / PRIOR_SPREAD) ** 2 + 0.5 * (p[1] - np.log(3)) ** 2)

    level, log_steepness = minimize(cost, np.array([0.0, np.log(3)]), method="Nelder-Mead").x
    return Curve(level - np.exp(log_steepness) * np.log(reference), float(np.exp(log_steepness)))


def share_interval(hits: int, count: int) -> tuple[float, float]:
    """90 % interval of a share (Clopper and Pearson 1934, Biometrika 26:404)."""
    tail = (1 - COVER) / 2
    low = beta.ppf(tail, hits, count - hits + 1) if hits else 0.0
    return float(low), float(beta.ppf(1 - tail, hits + 1, count - hits) if hits < count else 1.0)


def quantile_interval(values: Sequence[float], share: float) -> tuple[float, float]:
    """90 % interval of a quantile, from how many of the values may lie below it."""
    ordered, tail = np.sort(values), (1 - COVER) / 2
    low, high = binom.ppf([tail, 1 - tail], len(ordered), share).astype(int)
    return float(ordered[min(low, len(ordered) - 1)]), float(ordered[min(high, len(ordered) - 1)])


def reliability(stated: Sequence[float], right: Sequence[bool], bins: int = 10) -> list[tuple[float, float, int]]:
    """Mean probability, share right and number of cases of each bin that has any."""
    p, hit = np.asarray(stated), np.asarray(right, dtype=float)
    place = np.minimum((p * bins).astype(int), bins - 1)
    return [(float(p[place == i].mean()), float(hit[place == i].mean()), int((place == i).sum())) for i in range(bins) if (place == i).any()]


def calibration_error(stated: Sequence[float], right: Sequence[bool]) -> float:
    """Expected calibration error: mean distance of the bins from the diagonal, weighted by their cases."""
    found = reliability(stated, right)
    return sum(count * abs(p - share) for p, share, count in found) / sum(count for _, _, count in found)


def calibration_by_chance(stated: Sequence[float], draws: int = 1000) -> float:
    """The calibration error that as many verdicts would show in the median if every stated probability were true."""
    chance, said = np.random.default_rng(1), np.array(stated)
    return float(np.median([calibration_error(stated, list(chance.random(len(said)) < said)) for _ in range(draws)]))
