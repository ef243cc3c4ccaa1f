"""What a next run can rely on: the temperatures used so far, the true input, how late the thermometers follow the chamber."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.physics.lag import lagged
from zoo.simulator.laboratory.earth import EARTH_RAD_PER_S
from zoo.units import convert

EARTH_DPH = round(convert(EARTH_RAD_PER_S, "rad_per_s", "dph"), 3)
"""Rate of the Earth's rotation: the true input that is proposed where the runs have none."""
SELF_HEATING_K = 8.0
"""How far a gyro's thermometers are above the chamber's air, at most; an engineering prior, 3 to 12 K for 1 to 15 W."""
PACKAGE_S, SLOWEST_S, FASTEST_S = 900.0, 5400.0, 60.0
"""Time constant of a package behind the air, where the runs do not tell, and its bounds; an engineering prior, 10 to 40 min."""
TRIED = 24
MEAN_S = 300.0
"""Lags are read off means over this time."""
SHARPER = 1.2
"""Contrast of the deconvolved air's corners over that of the thermometer, from which on it is believed."""


@dataclass(frozen=True)
class Circumstances:
    """What is known of the laboratory from the runs at hand.

    Attributes:
        low_c: coldest set point that is proposed [°C].
        high_c: hottest one [°C].
        start_c: where programs begin and end [°C].
        usual: true input of the runs at hand [output's unit].
        reference: true input that can be turned over, that of the runs at hand or, where they had none, the Earth's rate; None where there is none.
        lags_s: time constant of each thermometer behind the chamber's air [s].
        offsets_k: of each thermometer above the main one at rest [K].
    """

    low_c: float
    high_c: float
    start_c: float
    usual: float
    reference: float | None
    lags_s: tuple[float, ...]
    offsets_k: tuple[float, ...]


def circumstances_of(runs: list[Run]) -> Circumstances:
    """Read them off the runs.

    Programs stay between the coldest temperature seen and `SELF_HEATING_K` below the hottest: the chamber itself was no hotter than that.

    Args:
        runs: R runs with the same columns.
    """
    seen = torch.cat([run.block_mean(run.temperature) for run in runs])
    low, high = _up(float(seen.min())), _down(float(seen.max()) - SELF_HEATING_K)
    if high - low < SELF_HEATING_K:  # a short range: as it was
        low, high = float(seen.min()), float(seen.max())
    first = float(torch.stack([run.temperature[0] for run in runs]).median())
    reference = float(torch.cat([run.table[:, -1] for run in runs]).median())
    seen_by = [[_thinned(run, name) for run in runs] for name in runs[0].thermometers]
    offsets = tuple(float(torch.stack([other[0] - main[0] for other, main in zip(one, seen_by[0], strict=True)]).median()) for one in seen_by)
    start = min(max(5.0 * round(first / 5.0), low), high)
    return Circumstances(low, high, start, reference, reference or _earth(runs[0].unit), _lags(seen_by, _step(runs[0])), offsets)


def _up(value: float) -> float:
    return -_down(-value)


def _down(value: float) -> float:
    """The multiple of 5 K below, or what is less than half a kelvin above it."""
    return 5.0 * ((value + 0.5) // 5.0)


def _earth(unit: str) -> float | None:
    try:
        return float(convert(EARTH_DPH, "dph", unit))
    except InputError:
        return None


def _step(run: Run) -> float:
    """Time between the means that lags are read off [s]."""
    return run.average_s * max(1, round(MEAN_S / run.average_s))


def _thinned(run: Run, name: str) -> Tensor:
    """(M,) means of a thermometer over some minutes, so that its resolution does not matter."""
    means = run.block_mean(run.column(name)).cpu()
    count = min(round(_step(run) / run.average_s), len(means))
    return means[: len(means) // count * count].reshape(-1, count).mean(dim=1)


def _lags(seen_by: list[list[Tensor]], step_s: float) -> tuple[float, ...]:
    """Time constant behind the air of each thermometer [s].

    That of the quickest from the air's corners; of the others what they follow the quickest with, on top of it.
    """
    swings = [sum(float(torch.diff(one).abs().pow(2).sum()) for one in seen) for seen in seen_by]
    quickest = max(range(len(swings)), key=swings.__getitem__)
    first = _lag(seen_by[quickest], step_s)
    behind = [_behind(seen_by[quickest], seen, step_s) if place != quickest else 0.0 for place, seen in enumerate(seen_by)]
    return tuple(first + more for more in behind)


def _times() -> Tensor:
    """(G,) time constants to try [s]."""
    return torch.logspace(math.log10(FASTEST_S), math.log10(SLOWEST_S), TRIED, dtype=torch.float64)


def _lag(temperatures: list[Tensor], step_s: float) -> float:
    """Time constant of a thermometer behind air that goes in straight legs [s].

    u = T + τ·dT/dt is the air; at the right τ its second difference consists of a few corners, so that its kurtosis is largest (Wiggins 1978,
    Geoexploration 16:21, minimum entropy deconvolution).
    """
    times = _times()
    contrast = torch.stack([_contrast(temperatures, step_s, float(tau)) for tau in times])
    best = int(contrast.argmax())
    sharper = float(contrast[best]) > SHARPER * float(_contrast(temperatures, step_s, 0.0))
    return float(times[best]) if sharper and 0 < best < TRIED - 1 else PACKAGE_S


def _contrast(temperatures: list[Tensor], step_s: float, tau: float) -> Tensor:
    """Kurtosis of the second difference of T + τ·dT/dt."""
    bends = []
    for seen in temperatures:
        rate = (seen[2:] - seen[:-2]) / (2 * step_s)
        bends.append(torch.diff(seen[1:-1] + tau * rate, n=2))
    bend = torch.cat(bends)
    return bend.pow(4).mean() / bend.square().mean().square().clamp_min(1e-300)


def _behind(ahead: list[Tensor], seen: list[Tensor], step_s: float) -> float:
    """Time constant with which one thermometer follows another [s]."""
    times = _times()
    cost = torch.zeros_like(times)
    for before, after in zip(ahead, seen, strict=True):
        clock = torch.arange(len(before), dtype=torch.float64) * step_s
        rest = lagged(clock, before, times) - after
        cost += (rest - rest.mean(dim=-1, keepdim=True)).square().sum(dim=-1)
    return float(times[int(cost.argmin())])


def thermometer(time: Tensor, air: Tensor, lag_s: float, cold_start: bool) -> Tensor:
    """What a thermometer shows in a chamber, its self-heating counted into the set point.

    Args:
        time: (T,) [s].
        air: (T,) set point [°C].
        lag_s: behind the air.
        cold_start: whether the run begins at power-on, with the body `SELF_HEATING_K` colder than it will be.

    Returns:
        (T,) [°C].
    """
    first = air[0] - (SELF_HEATING_K if cold_start else 0.0)
    return lagged(time, air, torch.tensor(lag_s, dtype=time.dtype), first)
